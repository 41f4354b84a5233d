//! Judges one straight line or turn by the truth of the base and by the base's own odometry.
//!
//! Neither comes from the controller: the truth is the emulator's, and the odometry is what the base would answer to
//! another host. The truth of a real base is unknown, so nothing is observed there.

use super::observe::{BASE_HEADING_U_DEG, Collector, DISPLACEMENT_U_M};
use crate::bench::Look;
use plan::{Segment, quantities as q};

impl Collector<'_> {
    pub(super) fn segment(&mut self, segment: Segment, before: &Look, after: &Look) {
        let (from, to) = (before.truth, after.truth);
        match segment {
            Segment::Straight(distance) => {
                let (x, y) = (to.x - from.x, to.y - from.y);
                let went = x * from.heading.cos() + y * from.heading.sin();
                let sign = 1f64.copysign(distance.m());
                let error = (went - distance).m() * sign;
                self.add(&q::STRAIGHT_TRUE_STOP_ERROR, error, 0.0, &[]);
            }
            Segment::Turn(angle) => {
                let sign = 1f64.copysign(angle.rad());
                let error = (to.heading - from.heading - angle).deg() * sign;
                let more = [("direction", sign), ("angle", angle.deg())];
                self.add(&q::TURN_TRUE_STOP_ERROR, error, 0.0, &more);
            }
        }
        let (base, u) = (after.odometry, DISPLACEMENT_U_M);
        self.add(&q::BASE_POSE_X_ERROR, (base.x - to.x).m(), u, &[]);
        self.add(&q::BASE_POSE_Y_ERROR, (base.y - to.y).m(), u, &[]);
        let heading = (base.heading - to.heading).wrapped().deg();
        self.add(&q::BASE_POSE_HEADING_ERROR, heading, BASE_HEADING_U_DEG, &[]);
    }
}

#[cfg(test)]
mod tests {
    use super::Look;
    use crate::engine::observe::{Collector, Tags};
    use plan::Segment;
    use wire::units::{Angle, Length, Pose};

    fn at(x: f64, y: f64, deg: f64) -> Pose {
        Pose { x: Length::from_m(x), y: Length::from_m(y), heading: Angle::from_deg(deg) }
    }

    fn observed(segment: Segment, from: Pose, to: Pose, base: Pose) -> Vec<(String, f64)> {
        let tags = Tags::new();
        let mut collector = Collector::new(&tags);
        let before = Look { truth: from, odometry: from };
        collector.segment(segment, &before, &Look { truth: to, odometry: base });
        let rounded = |value: f64| (value * 1e6).round() / 1e6 + 0.0;
        collector.out.iter().map(|o| (o.quantity.clone(), rounded(o.value))).collect()
    }

    #[test]
    fn backward_too_far_is_positive_and_the_base_is_held_against_the_truth() {
        let back = Segment::Straight(Length::from_m(-4.0));
        let seen = observed(back, at(1.0, 2.0, 90.0), at(1.0, -2.003, 90.5), at(1.01, -2.0, 90.0));
        let expected = [
            ("straight.true_stop_error", 0.003),
            ("base_pose.x_error", 0.01),
            ("base_pose.y_error", 0.003),
            ("base_pose.heading_error", -0.5),
        ];
        assert_eq!(seen, expected.map(|(name, value)| (name.to_owned(), value)));
    }

    #[test]
    fn a_turn_is_as_long_as_it_was_and_the_base_says_a_direction() {
        let cw = Segment::Turn(Angle::from_deg(-360.0));
        let seen = observed(cw, at(0.0, 0.0, 10.0), at(0.0, 0.0, -350.2), at(0.0, 0.0, 9.9));
        let value = |name: &str| seen.iter().find(|(known, _)| known == name).unwrap().1;
        assert_eq!(value("turn.true_stop_error"), 0.2);
        assert_eq!(value("base_pose.heading_error"), 0.1);
    }
}
