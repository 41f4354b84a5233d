//! Effects that a plain gyro model lacks, as functions of the true state.
//!
//! One-line effects are here with their formulas; size and source are documented at the parameter.

use super::parameters::GyroParameters;
use super::terms::Moment;
use libm::{cos, exp, sin};
use std::f64::consts::TAU;
use wire::units::{Angle, AngularRate};

const SECONDS_PER_HOUR: f64 = 3_600.0;
const PPM: f64 = 1e-6;

/// Temperature with play, updated in the slow steps.
///
/// The output follows the coil at a distance of at most the half width. The bias is proportional to that distance: one
/// sign on warming, the other on cooling, with a branch of its own in between.
pub(super) fn with_play(last: f64, celsius: f64, half_width: f64) -> f64 {
    last.clamp(celsius - half_width, celsius + half_width)
}

impl GyroParameters {
    /// Bias in rad/s by slow effects: hysteresis, warm-up, ageing, supply, fringes, a growing temperature coefficient.
    /// `play` is the coil's temperature with play.
    pub(super) fn slow_effects(&self, moment: &Moment, play: f64) -> f64 {
        let Moment { celsius, time_s, .. } = *moment;
        let off_reference = celsius - self.reference_celsius;
        let mut deg_per_h = self.hysteresis_deg_per_h_per_kelvin * (play - celsius)
            + self.bias_ageing_deg_per_h_per_h * time_s / SECONDS_PER_HOUR
            + self.bias_deg_per_h_per_volt * self.supply_deviation_volt;
        if self.warm_up_bias_deg_per_h != 0.0 {
            deg_per_h +=
                self.warm_up_bias_deg_per_h * exp(-time_s / self.warm_up_bias_time_constant_s);
        }
        if self.fringe_bias_deg_per_h != 0.0 {
            let width = off_reference / self.fringe_width_kelvin;
            deg_per_h += self.fringe_bias_deg_per_h
                * sin(TAU * off_reference / self.fringe_period_kelvin)
                * exp(-0.5 * width * width);
        }
        if self.drifting_bias_deg_per_h_per_kelvin != 0.0 {
            deg_per_h += self.drifting_bias_deg_per_h_per_kelvin
                * off_reference
                * (1.0 - exp(-time_s / self.drifting_time_constant_s));
        }
        AngularRate::from_deg_per_h(deg_per_h).rad_per_s()
    }

    /// Scale error by slow effects: ageing of the light source.
    pub(super) fn slow_scale_effects(&self, time_s: f64) -> f64 {
        self.scale_ageing_ppm_per_h * PPM * time_s / SECONDS_PER_HOUR
    }

    /// True if an effect changes from output to output.
    pub(super) fn has_fast_effects(&self) -> bool {
        [
            self.magnetic_bias_deg_per_h,
            self.motor_deg_per_h_per_ampere(),
            self.earth_deg_per_h().1,
            self.bias_step_deg_per_h,
            self.periodic_bias_deg_per_h,
            self.resonance_ppm,
            self.dead_zone_deg_per_s,
        ]
        .iter()
        .any(|&size| size != 0.0)
    }

    /// Bias in rad/s by the magnetic field, the carrier's motors, the Earth's rate along a tilted axis, a step and a
    /// disturbance.
    pub(super) fn fast_effects(&self, moment: &Moment, motor_ampere: f64) -> f64 {
        let from_field = moment.heading - Angle::from_deg(self.magnetic_heading_deg).rad();
        let mut deg_per_h = self.magnetic_bias_deg_per_h * cos(from_field)
            + self.motor_deg_per_h_per_ampere() * motor_ampere
            + self.periodic_bias_deg_per_h * sin(TAU * moment.time_s / self.periodic_bias_period_s);
        let horizontal = self.earth_deg_per_h().1;
        if horizontal != 0.0 {
            let from_north = moment.heading - Angle::from_deg(self.tilt_north_heading_deg).rad();
            deg_per_h += horizontal * cos(from_north);
        }
        if moment.time_s >= self.bias_step_at_s {
            deg_per_h += self.bias_step_deg_per_h;
        }
        AngularRate::from_deg_per_h(deg_per_h).rad_per_s()
    }

    /// Scale error by a resonance over the rate: a cusp, e^(-|w - w0|/width), in both directions alike.
    pub(super) fn resonance(&self, rate: f64) -> f64 {
        let off = Angle::from_rad(rate).deg().abs() - self.resonance_deg_per_s;
        self.resonance_ppm * PPM * exp(-off.abs() / self.resonance_width_deg_per_s)
    }

    /// `rate` after the dead zone.
    pub(super) fn beyond_dead_zone(&self, rate: f64) -> f64 {
        let width = Angle::from_deg(self.dead_zone_deg_per_s).rad();
        if rate.abs() < width { 0.0 } else { rate }
    }
}
