//! Reasons why a synchro-drive base does not drive straight.
//!
//! All wheels steer and drive together; the body does not turn with them and should not turn at all. Two effects turn
//! it, both in proportion to the path:
//!
//! * **Unequal wheels.** With the wheels pointing along d (left normal n), foot i at p_i from the
//!   centre of all feet, relative radius error e_i and toe d_i, foot i wants to move by
//!   (1 + e_i)(d + d_i n) per metre. The rotation that leaves the least squared slip is
//!
//!   kappa = sum(d_i (p_i . d) - e_i (p_i . n)) / sum |p_i|^2,
//!
//!   a first harmonic of the wheels' direction relative to the body. It cancels over a closed square.
//! * **Leakage.** The drive shaft runs inside the steering shaft and drags it. At a steady speed its torque balances
//!   rolling resistance and so has the sign of the speed v. Side forces at the feet transfer this torque to the body,
//!   and a rolling wheel creeps sideways in proportion to the force and to the distance rolled. Per metre of path the
//!   body turns by k0 sign(v), in any direction of the wheels: over a square it adds up, with the lap's sign or against
//!   it.
//!
//! Both change sign with v, so the body's rate is (kappa + k0) v. To tell them apart, drive the same floor direction
//! forward and, with the steering turned by half a turn, backward: kappa is the same for both, k0 changes sign.

use super::direction::Direction;
use super::parameters::Wheel;
use wire::units::Angle;

/// Curvature by unequal wheels as a function of the steering angle: a cos + b sin, in rad/m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Harmonic {
    /// With the wheels along the body's x axis.
    pub along_rad_per_m: f64,
    /// With the wheels along the body's y axis.
    pub across_rad_per_m: f64,
}

impl Harmonic {
    /// Equal wheels.
    pub const NONE: Self = Self { along_rad_per_m: 0.0, across_rad_per_m: 0.0 };

    /// The harmonic of these wheels; zero if all feet are in one place.
    pub fn of(wheels: &[Wheel]) -> Self {
        let spread: f64 = wheels.iter().map(|w| w.x_m * w.x_m + w.y_m * w.y_m).sum();
        if spread == 0.0 {
            return Self::default();
        }
        let sum = |term: fn(&Wheel, f64) -> f64| {
            wheels.iter().map(|w| term(w, Angle::from_deg(w.toe_deg).rad())).sum::<f64>() / spread
        };
        Self {
            along_rad_per_m: sum(|w, toe| toe * w.x_m - w.radius_error * w.y_m),
            across_rad_per_m: sum(|w, toe| toe * w.y_m + w.radius_error * w.x_m),
        }
    }

    /// Curvature in rad/m for wheels that point along `direction`, relative to the body.
    pub fn curvature(self, direction: Angle) -> f64 {
        self.towards(Direction::of(direction.rad()))
    }

    pub(super) fn towards(self, direction: Direction) -> f64 {
        self.along_rad_per_m * direction.cos + self.across_rad_per_m * direction.sin
    }
}

#[cfg(test)]
mod tests {
    use super::{Harmonic, Wheel};
    use proptest::prelude::*;
    use wire::units::Angle;

    fn three_feet() -> Vec<Wheel> {
        [0.0, 120.0, 240.0]
            .map(|deg: f64| Wheel {
                x_m: 0.25 * deg.to_radians().cos(),
                y_m: 0.25 * deg.to_radians().sin(),
                ..Wheel::default()
            })
            .to_vec()
    }

    /// The largest heading error in 10 m, over all directions, in degrees.
    fn worst_deg_in_10_m(wheels: &[Wheel]) -> f64 {
        let harmonic = Harmonic::of(wheels);
        (0..360)
            .map(|deg| harmonic.curvature(Angle::from_deg(deg.into())).to_degrees() * 10.0)
            .fold(0.0, f64::max)
    }

    #[test]
    fn the_sizes_are_those_of_the_literature() {
        let mut wheels = three_feet();
        wheels[0].radius_error = 0.002;
        assert!((worst_deg_in_10_m(&wheels) - 1.5).abs() < 0.05);
        let mut wheels = three_feet();
        wheels[1].toe_deg = 0.1;
        assert!((worst_deg_in_10_m(&wheels) - 1.3).abs() < 0.05);
        assert_eq!(worst_deg_in_10_m(&three_feet()), 0.0);
        assert_eq!(Harmonic::of(&[Wheel::default()]), Harmonic::default());
    }

    #[test]
    fn a_larger_wheel_on_the_left_turns_right() {
        let mut wheels = three_feet();
        wheels[1].radius_error = 0.001;
        assert!(Harmonic::of(&wheels).curvature(Angle::ZERO) < 0.0);
    }

    proptest! {
        /// The formula as written, with d and n as vectors.
        #[test]
        fn the_harmonic_is_the_formula(
            errors in prop::collection::vec((-0.5f64..0.5, -0.5f64..0.5, -0.01f64..0.01, -1f64..1.0), 1..6),
            direction in -10f64..10.0,
        ) {
            let wheels: Vec<Wheel> = errors
                .iter()
                .map(|&(x_m, y_m, radius_error, toe_deg)| Wheel { x_m, y_m, radius_error, toe_deg })
                .collect();
            let (d, n) = ((direction.cos(), direction.sin()), (-direction.sin(), direction.cos()));
            let spread: f64 = wheels.iter().map(|w| w.x_m.powi(2) + w.y_m.powi(2)).sum();
            prop_assume!(spread > 1e-3);
            let formula = wheels
                .iter()
                .map(|w| {
                    w.toe_deg.to_radians() * (w.x_m * d.0 + w.y_m * d.1)
                        - w.radius_error * (w.x_m * n.0 + w.y_m * n.1)
                })
                .sum::<f64>()
                / spread;
            let harmonic = Harmonic::of(&wheels).curvature(Angle::from_rad(direction));
            prop_assert!((harmonic - formula).abs() < 1e-12);
        }

        #[test]
        fn it_cancels_over_a_square(toe_deg in -1f64..1.0, radius_error in -0.01f64..0.01, first in -4f64..4.0) {
            let mut wheels = three_feet();
            wheels[2].toe_deg = toe_deg;
            wheels[1].radius_error = radius_error;
            let harmonic = Harmonic::of(&wheels);
            let sum: f64 = [0.0, 90.0, 180.0, 270.0]
                .map(|deg| harmonic.curvature(Angle::from_rad(first) + Angle::from_deg(deg)))
                .iter()
                .sum();
            prop_assert!(sum.abs() < 1e-15);
        }
    }
}
