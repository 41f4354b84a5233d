//! The absolute measurement of the robot's position: rulers and marks on the floor.

use crate::parameters::{ParameterError, Parameters as _, parameters};
use crate::random::RandomStream;
use libm::sqrt;
use wire::units::{Angle, Length, Pose};

parameters! {
    /// Limits of error of the absolute measurement. The default has none.
    ///
    /// An error is uniform within its limits, which is what limits of error without more say (JCGM
    /// 100:2008, 4.3.7): its standard uncertainty is limit / sqrt(3).
    pub struct AbsoluteParameters {
        /// Of x and of y. The paper: 0.002.
        position_limit_m: NOT_NEGATIVE = 0.0,
        /// Of the heading. The paper: 0.2.
        heading_limit_deg: NOT_NEGATIVE = 0.0,
    }
}

/// An absolute measurement of pose, with its errors.
#[derive(Debug, Clone)]
pub struct AbsoluteMeasurement {
    parameters: AbsoluteParameters,
    stream: RandomStream,
}

impl AbsoluteMeasurement {
    /// The measurement `name` in a run with `seed`.
    pub fn new(parameters: AbsoluteParameters, seed: u64, name: &str) -> Self {
        Self { parameters, stream: RandomStream::new(seed, name, "absolute measurement") }
    }

    /// One reading of `truth`; its heading is in [-180, 180) deg.
    pub fn measure(&mut self, truth: Pose) -> Pose {
        let position = Length::from_m(self.parameters.position_limit_m);
        let heading = Angle::from_deg(self.parameters.heading_limit_deg);
        Pose {
            x: truth.x + position * self.stream.symmetric_uniform(),
            y: truth.y + position * self.stream.symmetric_uniform(),
            heading: (truth.heading + heading * self.stream.symmetric_uniform()).wrapped(),
        }
    }

    /// Standard uncertainty of x, and of y.
    pub fn position_uncertainty(&self) -> Length {
        Length::from_m(self.parameters.position_limit_m) / sqrt(3.0)
    }

    /// Standard uncertainty of the heading.
    pub fn heading_uncertainty(&self) -> Angle {
        Angle::from_deg(self.parameters.heading_limit_deg) / sqrt(3.0)
    }

    /// Sets the parameter `name`.
    pub fn set_parameter(&mut self, name: &str, value: f64) -> Result<(), ParameterError> {
        self.parameters.set(name, value)
    }

    /// The current parameters.
    pub const fn parameters(&self) -> &AbsoluteParameters {
        &self.parameters
    }
}

#[cfg(test)]
mod tests {
    use super::{AbsoluteMeasurement, AbsoluteParameters};
    use wire::units::{Angle, Length, Pose};

    #[test]
    fn readings_fill_their_limits_evenly() {
        const READINGS: u32 = 20_000;
        let paper = AbsoluteParameters { position_limit_m: 0.002, heading_limit_deg: 0.2 };
        let mut absolute = AbsoluteMeasurement::new(paper, 1, "absolute");
        let truth = Pose {
            x: Length::from_m(1.0),
            y: Length::from_m(-2.0),
            heading: Angle::from_deg(90.0),
        };
        let (mut x2, mut heading2, mut largest) = (0.0, 0.0, 0.0f64);
        for _ in 0..READINGS {
            let read = absolute.measure(truth);
            let (x, y) = ((read.x - truth.x).m(), (read.y - truth.y).m());
            let heading = (read.heading - truth.heading).deg();
            assert!(x.abs() <= 0.002 && y.abs() <= 0.002 && heading.abs() <= 0.2 + 1e-12);
            x2 += x * x / f64::from(READINGS);
            heading2 += heading * heading / f64::from(READINGS);
            largest = largest.max(y.abs());
        }
        assert!(largest > 0.00199);
        // The variance of n uniform errors has a relative standard error of sqrt(0.8/n), 0.6 %.
        assert!((x2.sqrt() / absolute.position_uncertainty().m() - 1.0).abs() < 0.013);
        assert!((heading2.sqrt() / absolute.heading_uncertainty().deg() - 1.0).abs() < 0.013);
    }

    #[test]
    fn without_limits_it_is_the_truth() {
        let mut absolute = AbsoluteMeasurement::new(AbsoluteParameters::default(), 1, "absolute");
        let truth = Pose { heading: Angle::from_deg(100.0), ..Pose::default() };
        let read = absolute.measure(truth);
        assert!((read.heading - truth.heading).abs().rad() < 1e-15);
        assert!(absolute.set_parameter("heading_limit_deg", -1.0).is_err());
    }
}
