//! Corrections as effects of a finding.

use super::{Correction, Fault};
use crate::dataset::{Dataset, Role};
use crate::finding::{Effect, Parameter};
use crate::problem::TRACK;
use crate::significance::surprise_chi2;

impl Correction {
    pub(crate) fn name(&self) -> &'static str {
        match self.fault {
            Fault::ReversedSign => "reversed_sign",
            Fault::DegreesForRadians => "degrees_for_radians",
            Fault::RadiansForDegrees => "radians_for_degrees",
            Fault::ExchangedWheels => "exchanged_wheels",
            Fault::HeadingOffset => "reference_heading_offset",
            Fault::ReferenceLeft => "reference_left_of_axle",
            Fault::ReferenceDelay => "delay",
            Fault::SteerScale => "steer_scale",
            Fault::SteerOffset => "steer_offset",
            Fault::WrongAxis => "wrong_axis",
            Fault::ReferenceNoise => "reference_noise",
            Fault::WrongUnit if [0.25, 0.5, 2.0, 4.0].contains(&self.value) => "encoder_decoding",
            Fault::WrongUnit => "wrong_unit",
            Fault::AddedUp => "added_up",
            Fault::ExchangedAxes => "exchanged_axes",
            Fault::MeanSpeed => "mean_speed",
        }
    }

    /// How certain it is, in nats.
    fn strength(&self) -> f64 {
        let zero = if self.fault == Fault::SteerScale { 1.0 } else { 0.0 };
        self.standard_error
            .map_or(f64::MAX, |error| surprise_chi2(((self.value - zero) / error).powi(2), 1.0))
    }

    /// The effect, without its held-out errors.
    pub(crate) fn effect(&self, dataset: &Dataset) -> Effect {
        let column = dataset.named(&self.field);
        let role = column.map(|column| column.role);
        let axis = column.and_then(|column| column.axis);
        let p_value = (-self.strength()).exp().min(1.0);
        if matches!(role, Some(Role::GyroRate | Role::GyroAngle | Role::Measured)) {
            // Of a reading: a scale error of a known size.
            let parameters = vec![Parameter::new("value", self.value - 1.0, "1")];
            return Effect {
                axis,
                parameters,
                p_value,
                ..Effect::new(self.name(), "scale", "constant")
            };
        }
        let term = match self.fault {
            Fault::ReferenceDelay => "delay",
            Fault::SteerScale | Fault::SteerOffset => "curvature",
            Fault::WrongAxis => "axis",
            _ if TRACK.contains(&self.field.as_str()) => "turn",
            _ if role.is_some_and(|role| role.is_reference()) => "reference",
            _ if role.is_some_and(|role| role.is_gyro()) => "scale",
            _ if role == Some(Role::SteerAngle) => "turn",
            _ => "drive",
        };
        let name = match self.fault {
            Fault::ReferenceDelay => "delay",
            Fault::HeadingOffset | Fault::SteerOffset => "offset",
            Fault::ReferenceLeft => "value",
            _ => "factor",
        };
        // Positive where the wheels are later than their reference, as for any other sensor.
        let value = match self.fault {
            Fault::ReferenceDelay => -self.value,
            Fault::WrongAxis => 1.0,
            _ => self.value,
        };
        let degrees = |most: f64| [-most / self.unit.si(), most / self.unit.si()];
        let range = match self.fault {
            Fault::ReferenceDelay => Some([-1.0, 1.0]),
            Fault::HeadingOffset => Some(degrees(std::f64::consts::PI)),
            Fault::SteerOffset => Some(degrees(std::f64::consts::FRAC_PI_2)),
            Fault::SteerScale => Some([0.1, 10.0]),
            Fault::ReferenceLeft => Some([-5.0, 5.0]),
            _ => None,
        };
        let parameter = Parameter {
            standard_error: self.standard_error,
            range,
            ..Parameter::new(name, value, self.unit.text())
        };
        Effect {
            axis: axis.filter(|_| matches!(self.fault, Fault::WrongAxis | Fault::AddedUp)),
            drivers: vec![self.field.clone()],
            parameters: vec![parameter],
            p_value,
            ..Effect::new(self.name(), term, "constant")
        }
    }
}
