//! What a data package states wrongly about its fields: a sign, a unit, an axis, how a reference is mounted. It is set
//! right in the data before any model is fitted, and the model carries it over to other data.

mod drive;
mod effect;
mod fields;
mod fit;
mod legs;
mod readings;
mod reference;
mod signs;
mod turned;

pub(crate) use fields::fields;
pub(crate) use legs::{Poses, leaves};
pub(crate) use turned::{heading_of, turned};

use crate::dataset::{Axis, Column, Constant, Dataset, Kind, Role, Unit};
use crate::problem::wrap;
use crate::robust;
use crate::units::lasting;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is wrong with a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// It counts backwards; `value` is -1.
    ReversedSign,
    /// It is in degrees and the package says radians; `value` is a radian in degrees.
    DegreesForRadians,
    /// It is in radians and the package says degrees; `value` is a degree in radians.
    RadiansForDegrees,
    /// It is the right wheel, and the other the left one.
    ExchangedWheels,
    /// It is `value` greater than the heading of the robot.
    HeadingOffset,
    /// It sits to the left of the middle of the axle by `value`.
    ReferenceLeft,
    /// It comes later than the wheels by `value`.
    ReferenceDelay,
    /// The wheel is steered by `value` times as much as it says.
    SteerScale,
    /// The wheel stands to the left by `value` where it says zero.
    SteerOffset,
    /// It is the rotation about another axis; `value` is 0 for x, 1 for y, 2 for z.
    WrongAxis,
    /// It is noisy itself, and is evened out over `value` both ways.
    ReferenceNoise,
    /// Its numbers, or those of the constant with this name, are `value` times what they must be.
    WrongUnit,
    /// It adds up from the beginning, and the package says since the row before, or a rate; `value` is 1.
    AddedUp,
    /// It is y, and the other x; `value` is 1.
    ExchangedAxes,
    /// It and the speeds of the other wheels are means since the row before, where the package's are those of the moment of a
    /// row; `value` is 1.
    MeanSpeed,
}

/// A fault of a field and its size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Correction {
    /// What is wrong.
    pub fault: Fault,
    /// Name of the field, or of the constant.
    pub field: String,
    /// In `unit`.
    pub value: f64,
    /// Its unit.
    #[schemars(with = "String")]
    pub unit: Unit,
    /// Standard error of `value`; none if it can only be what it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
}

impl Correction {
    /// A fault that has no size of its own.
    fn exact(fault: Fault, field: &str, value: f64) -> Self {
        Self { fault, field: field.to_owned(), value, unit: Unit::One, standard_error: None }
    }

    /// A fault with a fitted size, SI.
    fn fitted(fault: Fault, field: &str, (value, error): (f64, f64), unit: Unit) -> Self {
        let (value, error) = (value / unit.si(), error / unit.si());
        Self { fault, field: field.to_owned(), value, unit, standard_error: Some(error) }
    }

    /// Times what is right that the field reads.
    fn factor(&self) -> f64 {
        match self.fault {
            Fault::ReversedSign
            | Fault::DegreesForRadians
            | Fault::RadiansForDegrees
            | Fault::WrongUnit => self.value,
            _ => 1.0,
        }
    }

    /// Whether both are parts of one angle.
    pub(crate) fn is_part_of(&self, other: &Self) -> bool {
        self.fault == Fault::HeadingOffset
            && (self.fault, &self.field) == (other.fault, &other.field)
    }

    /// Both angles as one.
    pub(crate) fn joined(self, other: &Self) -> Self {
        let error = |one: &Self| one.standard_error.map_or(0.0, |error| error * one.unit.si());
        let error = error(&self).hypot(error(other)) / self.unit.si();
        let value = wrap(self.si() + other.si()) / self.unit.si();
        Self { value, standard_error: (error > 0.0).then_some(error), ..self }
    }

    /// Whether it is an error of what is measured, or of how it is stated: an effect. The noise of a reference is not one.
    pub fn is_effect(&self) -> bool {
        self.fault != Fault::ReferenceNoise
    }

    /// The note in the finding, if it is no effect.
    pub(crate) fn notice(&self) -> Option<String> {
        (!self.is_effect()).then(|| {
            format!(
                "the reference `{}` is noisy itself; it is evened out over {} before and after",
                self.field,
                lasting(self.si())
            )
        })
    }

    fn si(&self) -> f64 {
        self.value * self.unit.si()
    }

    fn apply(&self, dataset: &mut Dataset) {
        // A scale that the package states comes after the offset.
        let stated_scale = dataset.constants.get("steer_scale").map_or(1.0, |one| one.value);
        match self.fault {
            Fault::ReferenceDelay => self.add_to(dataset, Constant::REFERENCE_DELAY, Unit::Second),
            Fault::ReferenceLeft => self.add_to(dataset, Constant::REFERENCE_LEFT, Unit::Metre),
            Fault::ExchangedWheels => exchange(dataset, [Role::WheelLeft, Role::WheelRight]),
            Fault::ExchangedAxes => exchange(dataset, [Role::ReferenceX, Role::ReferenceY]),
            Fault::AddedUp => fields::read_added_up(dataset, &self.field),
            Fault::MeanSpeed => self.add_to(dataset, Constant::MEAN_SPEED, Unit::One),
            Fault::ReferenceNoise => self.even_out(dataset),
            Fault::SteerScale => self.read_as(dataset, self.value, 0.0),
            Fault::HeadingOffset => self.read_as(dataset, 1.0, -self.si()),
            Fault::SteerOffset => self.read_as(dataset, 1.0, self.si() / stated_scale),
            Fault::WrongAxis => {
                let axis = Axis::ALL[(self.value as usize).min(2)];
                self.columns(dataset).for_each(|column| column.axis = Some(axis));
            }
            Fault::ReversedSign
            | Fault::DegreesForRadians
            | Fault::RadiansForDegrees
            | Fault::WrongUnit => match dataset.constants.get_mut(&self.field) {
                Some(constant) if self.fault == Fault::WrongUnit => constant.value /= self.value,
                _ => self.read_as(dataset, 1.0 / self.value, 0.0),
            },
        }
    }

    /// The field in `dataset`, if it is one.
    fn columns<'a>(&'a self, dataset: &'a mut Dataset) -> impl Iterator<Item = &'a mut Column> {
        dataset.columns.iter_mut().filter(|one| one.name == self.field).take(1)
    }

    /// Reads the field as `factor` times what it says and what is `added`, SI.
    fn read_as(&self, dataset: &mut Dataset, factor: f64, added: f64) {
        for column in self.columns(dataset) {
            let added = added / column.unit.si();
            column.values.iter_mut().for_each(|value| *value = factor * *value + added);
        }
    }

    /// Adds it to a constant of the package.
    fn add_to(&self, dataset: &mut Dataset, name: &str, unit: Unit) {
        let stated = dataset.constants.get(name).map_or(0.0, Constant::si);
        let value = stated + self.si();
        dataset.constants.insert(name.to_owned(), Constant { value, unit });
    }

    /// Evens a reference out, and notes its noise and the width.
    fn even_out(&self, dataset: &mut Dataset) {
        let Some(column) = dataset.named(&self.field) else { return };
        let evened = reference::apply(dataset, column, self.si());
        let (turns, unit) = (reference::turns(dataset.kind, column), column.unit);
        let left = |(noisy, even): (&f64, &f64)| match turns {
            true => wrap((noisy - even) * unit.si()) / unit.si(),
            false => noisy - even,
        };
        let left = column.values.iter().zip(&evened).map(left);
        let left: Vec<f64> = left.filter(|left| left.is_finite()).collect();
        let noise = Constant { value: robust::spread(&left), unit };
        self.columns(dataset).for_each(|column| column.values.clone_from(&evened));
        dataset.constants.insert(Constant::noise_of(&self.field), noise);
        let width = Constant { value: self.value, unit: self.unit };
        dataset.constants.insert(Constant::evened(&self.field), width);
    }
}

/// Exchanges two roles.
fn exchange(dataset: &mut Dataset, [one, other]: [Role; 2]) {
    for column in &mut dataset.columns {
        column.role = match column.role {
            role if role == one => other,
            role if role == other => one,
            role => role,
        };
    }
}

/// Times what is right that the readings of a sensor are, the fields for which `is_read` says so.
pub(crate) fn factor(corrections: &[Correction], is_read: impl Fn(&str) -> bool) -> f64 {
    corrections.iter().filter(|one| is_read(&one.field)).map(Correction::factor).product()
}

/// What the readings of `column` are compared with, row by row.
pub(crate) fn reference_of<'a>(dataset: &'a Dataset, column: &Column) -> Option<&'a Column> {
    let role = match (dataset.kind, column.role) {
        (Kind::Sensor, Role::Measured) => Role::Reference,
        (Kind::Series, Role::GyroRate | Role::GyroCounts) => Role::ReferenceRate,
        (Kind::Turns, Role::GyroAngle) => Role::ReferenceAngle,
        _ => return None,
    };
    dataset.columns_of(role).find(|one| Axis::agree(one.axis, column.axis))
}

/// `dataset` set right.
pub(crate) fn applied(dataset: &Dataset, corrections: &[Correction]) -> Dataset {
    let mut right = dataset.clone();
    corrections.iter().for_each(|correction| correction.apply(&mut right));
    right
}

/// What `dataset` states wrongly, in the order in which it is set right.
pub(crate) fn find(dataset: &Dataset) -> Vec<Correction> {
    let mut found = exact(dataset);
    let right = applied(dataset, &found);
    found.extend(match dataset.kind {
        Kind::Odometry => drive::find(&right),
        Kind::Series | Kind::Sensor => reference::find(&right),
        _ => Vec::new(),
    });
    found
}

/// Those that can only be what they are: how fields are to be read.
pub(crate) fn exact(dataset: &Dataset) -> Vec<Correction> {
    match dataset.kind {
        Kind::Odometry => signs::find(dataset).unwrap_or_default(),
        Kind::Series | Kind::Sensor => {
            let mut found = fields(dataset);
            found.extend(readings::find(&applied(dataset, &found)));
            found
        }
        Kind::Turns => readings::find(dataset),
        Kind::Laps => Vec::new(),
    }
}
