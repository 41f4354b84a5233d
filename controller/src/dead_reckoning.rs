//! Dead reckoning: path length from the base and heading from the selected source, summed to a pose.

use crate::kalman::Correction;
use wire::base::{Motion, PoseWriteResult};
use wire::units::{Angle, Length, Pose};

/// The sum of the base's motion messages.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct DeadReckoning {
    x: Length,
    y: Length,
    displacement: Option<Length>,
    heading_before: Angle,
    odometry_heading: Angle,
    last_odometry: Option<(Angle, u8)>,
}

impl DeadReckoning {
    /// Current position, with `heading` as the current heading.
    pub(crate) const fn pose(&self, heading: Angle) -> Pose {
        Pose { x: self.x, y: self.y, heading }
    }

    /// Path length by the base.
    pub(crate) fn displacement(&self) -> Length {
        self.displacement.unwrap_or(Length::ZERO)
    }

    /// Heading by the base's odometry, not wrapped. A pose written to the base does not show here: the base's heading
    /// jumps, this one continues.
    pub(crate) const fn odometry_heading(&self) -> Angle {
        self.odometry_heading
    }

    /// Sets the current pose.
    pub(crate) const fn place(&mut self, pose: Pose) {
        self.x = pose.x;
        self.y = pose.y;
        self.heading_before = pose.heading;
        self.odometry_heading = pose.heading;
    }

    /// Applies an estimator's correction.
    pub(crate) fn correct(&mut self, by: &Correction) {
        self.x += by.x;
        self.y += by.y;
        self.heading_before += by.heading;
    }

    /// Changes the heading source: the next piece of path starts from `heading`.
    pub(crate) const fn take_heading(&mut self, heading: Angle) {
        self.heading_before = heading;
    }

    /// Takes the odometry's part of a motion message; call before [`Self::advance`].
    pub(crate) fn odometry(&mut self, motion: &Motion) {
        let write = motion.pose_write_counter;
        if let Some((last, last_write)) = self.last_odometry {
            let written = motion.pose_write == PoseWriteResult::Accepted && write != last_write;
            if !written {
                self.odometry_heading += (motion.heading - last).wrapped();
            }
        }
        self.last_odometry = Some((motion.heading, write));
    }

    /// The base's path count restarts with this message: the distance before it is unknown.
    pub(crate) const fn count_anew(&mut self, motion: &Motion) {
        self.displacement = Some(motion.displacement);
    }

    /// Advances along the path since the previous message, on the mean of the headings at its ends.
    pub(crate) fn advance(&mut self, motion: &Motion, heading: Angle) {
        if let Some(before) = self.displacement {
            let path = motion.displacement - before;
            if path != Length::ZERO {
                let mean = (heading + self.heading_before) * 0.5;
                self.x += path * mean.cos();
                self.y += path * mean.sin();
            }
        }
        self.displacement = Some(motion.displacement);
        self.heading_before = heading;
    }
}

#[cfg(test)]
mod tests {
    use super::{Angle, DeadReckoning, Length, Motion, PoseWriteResult};
    use proptest::prelude::*;

    fn motion(displacement: f64, heading: Angle) -> Motion {
        Motion { displacement: Length::from_m(displacement), heading, ..Motion::default() }
    }

    #[test]
    fn an_arc_of_a_quarter_turn_ends_where_geometry_says() {
        let mut reckoning = DeadReckoning::default();
        let steps = 1_000;
        for n in 0..=steps {
            let heading = Angle::from_deg(90.0 * f64::from(n) / f64::from(steps));
            reckoning.advance(&motion(2.0 * heading.rad(), heading), heading);
        }
        let pose = reckoning.pose(Angle::from_deg(90.0));
        assert!((pose.x.m() - 2.0).abs() < 1e-6 && (pose.y.m() - 2.0).abs() < 1e-6, "{pose:?}");
    }

    #[test]
    fn a_written_pose_does_not_turn_the_odometry() {
        let mut reckoning = DeadReckoning::default();
        reckoning.odometry(&motion(0.0, Angle::from_deg(170.0)));
        reckoning.odometry(&motion(0.0, Angle::from_deg(-170.0)));
        assert!((reckoning.odometry_heading().deg() - 20.0).abs() < 1e-9);
        let written = Motion {
            pose_write: PoseWriteResult::Accepted,
            pose_write_counter: 1,
            ..motion(0.0, Angle::from_deg(3.0))
        };
        reckoning.odometry(&written);
        assert!((reckoning.odometry_heading().deg() - 20.0).abs() < 1e-9);
        reckoning.odometry(&Motion { heading: Angle::from_deg(4.0), ..written });
        assert!((reckoning.odometry_heading().deg() - 21.0).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn a_closed_square_closes_from_any_pose(heading in -7.0f64..7.0, side in 0.1f64..10.0) {
            let mut reckoning = DeadReckoning::default();
            let mut at = 0.0;
            for leg in 0..4 {
                let heading = Angle::from_rad(heading) + Angle::from_deg(90.0 * f64::from(leg));
                reckoning.take_heading(heading);
                reckoning.advance(&motion(at, heading), heading);
                at += side;
                reckoning.advance(&motion(at, heading), heading);
            }
            let pose = reckoning.pose(Angle::ZERO);
            prop_assert!(pose.x.m().abs() < 1e-9 && pose.y.m().abs() < 1e-9);
        }
    }
}
