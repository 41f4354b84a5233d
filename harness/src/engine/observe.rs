//! From answers and measured poses to observations of named quantities.

use super::op::Direction;
use crate::observation::Observation;
use controller::mission::{BiasTestResult, State, StraightResult, TurnResult};
use std::collections::BTreeMap;
use wire::units::{Angle, Pose};

/// Standard uncertainties that an observation inherits from what measured it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainties {
    /// Position of one absolute measurement, m.
    pub absolute_position_m: f64,
    /// Heading of one absolute measurement, deg.
    pub absolute_heading_deg: f64,
    /// Angle of the table at rest, deg.
    pub table_deg: f64,
}

/// Resolution of the base's displacement (0.1 mm on the wire), as a standard uncertainty in m.
const DISPLACEMENT_U_M: f64 = 0.000_1 / 3.464;

/// What stands at both ends of a lap or of a turn of the table.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Ends {
    pub(super) state_before: Option<State>,
    pub(super) state_after: Option<State>,
    pub(super) pose_before: Option<Pose>,
    pub(super) pose_after: Option<Pose>,
}

/// Tags that go with every observation of the moment.
pub(super) type Tags = BTreeMap<String, f64>;

/// Collects observations with common tags.
pub(super) struct Collector<'a> {
    pub(super) tags: &'a Tags,
    pub(super) out: Vec<Observation>,
}

impl<'a> Collector<'a> {
    pub(super) const fn new(tags: &'a Tags) -> Self {
        Self { tags, out: Vec::new() }
    }

    fn add(&mut self, quantity: &str, value: f64, uncertainty: f64, more: &[(&str, f64)]) {
        let mut tags = self.tags.clone();
        tags.extend(more.iter().map(|&(name, value)| (name.to_owned(), value)));
        self.out.push(Observation { quantity: quantity.to_owned(), value, uncertainty, tags });
    }

    /// A bias test: what it found, and how far each method's prediction was off. `before` is the test
    /// before this one, whose mean would have been subtracted up to now.
    pub(super) fn bias_test(&mut self, result: &BiasTestResult, before: Option<&BiasTestResult>) {
        let mean = result.mean.deg_per_s();
        let spread = result.spread.deg_per_s();
        // Independent readings: the mean is this well known.
        let u_mean = spread / f64::from(result.samples.max(1)).sqrt();
        let temperature = result.temperature.map(|t| ("temperature", t.celsius()));
        let more = temperature.as_slice();
        self.add("bias.mean", mean, u_mean, more);
        self.add("bias.spread", spread, u_mean / std::f64::consts::SQRT_2, more);
        if let Some(before) = before {
            let u_before = before.spread.deg_per_s() / f64::from(before.samples.max(1)).sqrt();
            let u = u_mean.hypot(u_before);
            self.add("bias.residual_test", mean - before.mean.deg_per_s(), u, more);
        }
        if let Some(table) = result.table {
            self.add("bias.residual_table", mean - table.deg_per_s(), u_mean, more);
        }
        self.add("bias.residual_none", mean, u_mean, more);
    }

    /// A straight line, by the base's displacement and the heading source.
    pub(super) fn straight(&mut self, result: &StraightResult, heading_u_deg: f64) {
        self.add("straight.stop_error", result.stop_error.m(), DISPLACEMENT_U_M, &[]);
        let heading_error = result.heading_error_max.deg();
        self.add("straight.heading_error", heading_error, heading_u_deg, &[]);
        self.add("pose_write.attempts", f64::from(result.pose_writes), 0.0, &[]);
    }

    /// A turn, by the heading source.
    pub(super) fn turn(&mut self, result: &TurnResult, heading_u_deg: f64) {
        let direction = Direction::of(result.gyro_angle.rad()).sign();
        let more = [("direction", direction)];
        self.add("turn.stop_error", result.stop_error.deg(), heading_u_deg, &more);
    }

    /// One turn of the table: Eqs 1 and 2, `E = |theta| - 360`, generalised to any angle.
    pub(super) fn table_turn(&mut self, ends: &Ends, angle_deg: f64, uncertainties: &Uncertainties) {
        let (Some(before), Some(after)) = (&ends.state_before, &ends.state_after) else { return };
        let direction = Direction::of(angle_deg).sign();
        let turned = (after.gyro_heading - before.gyro_heading).deg();
        let mut more = vec![("direction", direction)];
        more.extend(after.temperature.map(|t| ("temperature", t.celsius())));
        let u = uncertainties.table_deg * std::f64::consts::SQRT_2;
        self.add("table.error", direction * turned - angle_deg.abs(), u, &more);
    }

    /// One lap: how far each heading is off by Eq. 1's signs, and where the robot came back to, seen
    /// from where it started.
    pub(super) fn lap(&mut self, ends: &Ends, direction: Direction, uncertainties: &Uncertainties) {
        let Ends {
            state_before: Some(state_before),
            state_after: Some(state_after),
            pose_before: Some(pose_before),
            pose_after: Some(pose_after),
        } = ends
        else {
            return;
        };
        let sign = direction.sign();
        let mut more = vec![("direction", sign)];
        more.extend(state_after.temperature.map(|t| ("temperature", t.celsius())));
        // Two readings of the absolute measurement stand behind each figure.
        let u_heading = uncertainties.absolute_heading_deg * std::f64::consts::SQRT_2;
        let u_position = uncertainties.absolute_position_m * std::f64::consts::SQRT_2;
        let nominal = Angle::TURN * sign;
        let off_nominal = (pose_after.heading - pose_before.heading - nominal).wrapped();
        let turned = nominal + off_nominal;
        let gyro = state_after.gyro_heading - state_before.gyro_heading;
        let odometry = state_after.odometry_heading - state_before.odometry_heading;
        self.add("lap.gyro_error", sign * (gyro - turned).deg(), u_heading, &more);
        self.add("lap.odometry_error", sign * (odometry - turned).deg(), u_heading, &more);
        self.add("lap.return_heading", off_nominal.deg(), u_heading, &more);
        let (x, y) = seen_from(pose_before, pose_after);
        self.add("lap.return_x", x, u_position, &more);
        self.add("lap.return_y", y, u_position, &more);
        let believed = seen_from(&state_before.pose, &state_after.pose);
        self.add("lap.position_error_x", x - believed.0, u_position, &more);
        self.add("lap.position_error_y", y - believed.1, u_position, &more);
        let lost = state_after.samples_lost - state_before.samples_lost;
        self.add("samples.lost", lost as f64, 0.0, &more);
    }

    /// The running log: rate and temperature at rest.
    pub(super) fn log(&mut self, state: &State) {
        let temperature = state.temperature.map(|t| ("temperature", t.celsius()));
        self.add("gyro.rate", state.raw_rate.deg_per_s(), 0.0, temperature.as_slice());
        if let Some(temperature) = state.temperature {
            self.add("gyro.temperature", temperature.celsius(), 0.0, &[]);
        }
    }

    /// The continuous observer of a straight line's heading.
    pub(super) fn heading_error(&mut self, error: Angle) {
        self.add("controller.heading_error", error.deg(), 0.0, &[]);
    }
}

/// Position of `to` in the frame that stands at `from`, in metres.
fn seen_from(from: &Pose, to: &Pose) -> (f64, f64) {
    let (dx, dy) = ((to.x - from.x).m(), (to.y - from.y).m());
    let (sin, cos) = (from.heading.sin(), from.heading.cos());
    (cos * dx + sin * dy, cos * dy - sin * dx)
}

#[cfg(test)]
mod tests {
    use super::{Angle, Pose, seen_from};
    use wire::units::Length;

    #[test]
    fn a_return_is_seen_from_the_start() {
        let at = |x, y, deg| Pose {
            x: Length::from_m(x),
            y: Length::from_m(y),
            heading: Angle::from_deg(deg),
        };
        let (x, y) = seen_from(&at(1.0, 1.0, 90.0), &at(0.0, 3.0, 0.0));
        assert!((x - 2.0).abs() < 1e-12 && (y - 1.0).abs() < 1e-12);
    }
}
