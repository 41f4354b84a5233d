//! Turns answers and measured poses into observations of the named quantities.

use super::rest_watch::Window;
use crate::bench::{BenchFacts, Look};
use controller::mission::{BiasTestResult, State, StraightResult, TurnResult};
use plan::observation::Observation;
use plan::quantities::{self as q, OPEN_AT_END, OPEN_TAG, Quantity, SINCE_PREFIX};
use plan::{Direction, TableTurn};
use std::collections::BTreeMap;
use wire::base::HEADING_STEP;
use wire::base::payload::COUNTS_PER_DEG;
use wire::time::Timestamp;
use wire::units::{Angle, Pose, Temperature};

/// Resolution of the base's displacement, 0.1 mm on the wire, as a standard uncertainty in m.
pub const DISPLACEMENT_U_M: f64 = 0.000_1 / STEP_OVER_U;

/// Resolution of the heading in the base's pose, 0.01 deg on the wire, as a standard uncertainty in deg.
pub(super) const BASE_HEADING_U_DEG: f64 = 1.0 / COUNTS_PER_DEG / STEP_OVER_U;

/// A resolution step divided by its standard uncertainty: the square root of 12.
pub(super) const STEP_OVER_U: f64 = 3.464_101_615_137_754_6;

/// Readings at both ends of a lap or of a turn of the table.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Ends {
    pub(super) state_before: Option<State>,
    pub(super) state_after: Option<State>,
    pub(super) began: Option<Timestamp>,
    pub(super) ended: Option<Timestamp>,
    pub(super) pose_before: Option<Pose>,
    pub(super) pose_after: Option<Pose>,
    pub(super) look_before: Option<Look>,
    pub(super) look_after: Option<Look>,
}

impl Ends {
    /// Takes a state for each end without a state.
    pub(super) fn take(&mut self, now: Timestamp, state: &State) {
        if self.state_before.is_none() {
            (self.state_before, self.began) = (Some(*state), Some(now));
        }
        if self.state_after.is_none() {
            (self.state_after, self.ended) = (Some(*state), Some(now));
        }
    }

    /// Values between the ends: duration, subtracted bias, and temperature as the mean of both ends.
    fn between(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let duration =
            self.began.zip(self.ended).map(|(began, ended)| (ended - began).as_secs_f64());
        let bias = self.state_after.map(|state| state.bias.deg_per_s());
        let told = |state: Option<State>| state.and_then(|state| state.temperature);
        let (before, after) = (told(self.state_before), told(self.state_after));
        let temperature =
            before.or(after).zip(after).map(|(a, b)| (a.celsius() + b.celsius()) / 2.0);
        let named =
            [("duration", duration), ("bias", bias), ("temperature", temperature)].into_iter();
        named.filter_map(|(name, value)| Some((name, value?)))
    }
}

/// Tags of every observation of the moment.
pub type Tags = BTreeMap<String, f64>;

/// A reaction time, or how long a stimulus has waited in vain.
#[derive(Debug)]
pub(super) struct Took {
    pub(super) quantity: String,
    pub(super) seconds: f64,
    /// Standard uncertainty of that: how late a harness in real time was at its ends.
    pub(super) uncertainty: f64,
    /// Tags of the step during which the stimulus came.
    pub(super) tags: Tags,
    /// The run ended before the answer.
    pub(super) is_open: bool,
}

/// How long the first message has been waited for.
#[derive(Debug)]
pub(super) struct Waited {
    pub(super) quantity: String,
    pub(super) since: String,
    pub(super) seconds: f64,
}

/// Collects observations with common tags.
pub(super) struct Collector<'a> {
    pub(super) tags: &'a Tags,
    pub(super) out: Vec<Observation>,
}

fn temperature_tag(temperature: Option<Temperature>) -> Option<(&'static str, f64)> {
    temperature.map(|t| ("temperature", t.celsius()))
}

impl<'a> Collector<'a> {
    pub(super) const fn new(tags: &'a Tags) -> Self {
        Self { tags, out: Vec::new() }
    }

    pub(super) fn add(&mut self, quantity: &Quantity, value: f64, u: f64, more: &[(&str, f64)]) {
        self.add_named(quantity.name, value, u, more);
    }

    pub(super) fn add_named(&mut self, name: &str, value: f64, u: f64, more: &[(&str, f64)]) {
        let mut tags = self.tags.clone();
        tags.extend(more.iter().map(|&(name, value)| (name.to_owned(), value)));
        self.out.push(Observation { quantity: name.to_owned(), value, uncertainty: u, tags });
    }

    /// With the tags of the step during which the stimulus came, and the time of now.
    pub(super) fn reaction(&mut self, took: Took) {
        let Took { quantity, seconds, uncertainty, mut tags, is_open } = took;
        let time = self.tags.get("time").map(|time| ("time".to_owned(), *time));
        let open = is_open.then(|| (OPEN_TAG.to_owned(), OPEN_AT_END));
        tags.extend(time.into_iter().chain(open));
        self.out.push(Observation { quantity, value: seconds, uncertainty, tags });
    }

    /// The time before the first message; with the value of the tag where it never came.
    pub(super) fn waited(&mut self, waited: &Waited, open: Option<f64>) {
        let since = format!("{SINCE_PREFIX}{}", waited.since);
        let tags = [(&*since, 1.0)].into_iter().chain(open.map(|open| (OPEN_TAG, open)));
        self.add_named(&waited.quantity, waited.seconds, 0.0, &Vec::from_iter(tags));
    }

    /// Gaps between messages that are still open, with this value of the tag.
    pub(super) fn gaps(&mut self, gaps: Vec<(String, f64)>, open: f64) {
        for (quantity, seconds) in gaps {
            self.add_named(&quantity, seconds, 0.0, &[(OPEN_TAG, open)]);
        }
    }

    pub(super) fn bias_test(&mut self, result: &BiasTestResult) {
        let more = temperature_tag(result.temperature);
        let u = u_of_mean(result, u64::from(result.samples));
        self.add(&q::BIAS_MEAN, result.mean.deg_per_s(), u, more.as_slice());
        let u_spread = u / std::f64::consts::SQRT_2;
        self.add(&q::BIAS_SPREAD, result.spread.deg_per_s(), u_spread, more.as_slice());
    }

    /// How far each method's prediction is off the mean of a later window at rest. `test` is the last bias test and its
    /// age in s.
    pub(super) fn bias_residual(
        &mut self,
        window: &Window,
        test: Option<(&BiasTestResult, f64)>,
        table_deg_per_s: Option<f64>,
    ) {
        let rate = window.rate_deg_per_s;
        let mut more: Vec<_> = temperature_tag(window.temperature).into_iter().collect();
        more.extend(test.map(|(_, age)| ("age", age)));
        let u = test.map_or(0.0, |(result, _)| u_of_mean(result, window.samples));
        if let Some((result, _)) = test {
            let u_test = u_of_mean(result, u64::from(result.samples));
            let residual = rate - result.mean.deg_per_s();
            self.add(&q::BIAS_RESIDUAL_TEST, residual, u.hypot(u_test), &more);
        }
        if let Some(table) = table_deg_per_s {
            self.add(&q::BIAS_RESIDUAL_TABLE, rate - table, u, &more);
        }
        self.add(&q::BIAS_RESIDUAL_NONE, rate, u, &more);
    }

    /// One interval of a log at rest.
    pub(super) fn log(&mut self, window: &Window) {
        let more = temperature_tag(window.temperature);
        self.add(&q::GYRO_RATE, window.rate_deg_per_s, 0.0, more.as_slice());
        if let Some(temperature) = window.temperature {
            self.add(&q::GYRO_TEMPERATURE, temperature.celsius(), 0.0, &[]);
        }
    }

    /// A straight line, by the base's displacement and the heading source.
    pub(super) fn straight(&mut self, result: &StraightResult, heading_u_deg: f64) {
        self.add(&q::STRAIGHT_STOP_ERROR, result.stop_error.m(), DISPLACEMENT_U_M, &[]);
        let heading_error = result.heading_error_max.deg();
        self.add(&q::STRAIGHT_HEADING_ERROR_MAX, heading_error, heading_u_deg, &[]);
        let retries = f64::from(result.pose_writes.saturating_sub(1));
        self.add(&q::POSE_WRITE_RETRIES, retries, 0.0, &[]);
    }

    /// A turn, by the heading source.
    pub(super) fn turn(&mut self, result: &TurnResult, heading_u_deg: f64) {
        let more = [("direction", 1f64.copysign(result.gyro_angle.rad()))];
        self.add(&q::TURN_STOP_ERROR, result.stop_error.deg(), heading_u_deg, &more);
        let difference = result.odometry_angle - result.gyro_angle;
        self.add(&q::TURN_ODOMETRY_ERROR, difference.deg(), heading_u_deg, &more);
    }

    /// One turn of the table: Eqs 1 and 2, `E = |theta| - 360`, for any angle.
    pub(super) fn table_turn(
        &mut self,
        ends: &Ends,
        turn: &TableTurn,
        heading: Angle,
        facts: &BenchFacts,
    ) {
        let angle = turn.angle;
        let (Some(before), Some(after)) = (&ends.state_before, &ends.state_after) else { return };
        let direction = 1f64.copysign(angle.rad());
        let turned = direction * (after.gyro_heading - before.gyro_heading).deg();
        let mut more = vec![
            ("direction", direction),
            ("angle", angle.deg()),
            ("table_rate", turn.rate.deg_per_s()),
            ("acceleration", turn.acceleration.rad_per_s2().to_degrees()),
            ("heading", heading.deg()),
        ];
        more.extend(ends.between());
        let u = facts.table_u_deg * std::f64::consts::SQRT_2;
        self.add(&q::TABLE_ANGLE, turned, u, &more);
        self.add(&q::TABLE_ERROR, turned - angle.abs().deg(), u, &more);
    }

    /// One lap: the error of each heading with the signs of Eq. 1, and where the robot returned to, in the frame of its
    /// start.
    pub(super) fn lap(&mut self, ends: &Ends, direction: Direction, facts: &BenchFacts) {
        let Ends {
            state_before: Some(state_before),
            state_after: Some(state_after),
            pose_before: Some(pose_before),
            pose_after: Some(pose_after),
            ..
        } = ends
        else {
            return;
        };
        let sign = direction.sign();
        let mut more = vec![("direction", sign)];
        more.extend(ends.between());
        // Each figure rests on two readings of the absolute measurement.
        let u_heading = facts.absolute_heading_u_deg * std::f64::consts::SQRT_2;
        let u_position = facts.absolute_position_u_m * std::f64::consts::SQRT_2;
        let nominal = Angle::TURN * sign;
        let off_nominal = (pose_after.heading - pose_before.heading - nominal).wrapped();
        let turned = nominal + off_nominal;
        let gyro = state_after.gyro_heading - state_before.gyro_heading;
        let odometry = state_after.odometry_heading - state_before.odometry_heading;
        self.add(&q::LAP_GYRO_ERROR, sign * (gyro - turned).deg(), u_heading, &more);
        // The odometry has a resolution step at both ends.
        let u_odometry = u_heading.hypot(HEADING_STEP.deg() / 6f64.sqrt());
        self.add(&q::LAP_ODOMETRY_ERROR, sign * (odometry - turned).deg(), u_odometry, &more);
        self.add(&q::LAP_RETURN_HEADING, off_nominal.deg(), u_heading, &more);
        let (x, y) = seen_from(pose_before, pose_after);
        self.add(&q::LAP_RETURN_X, x, u_position, &more);
        self.add(&q::LAP_RETURN_Y, y, u_position, &more);
        self.add(&q::LAP_POSITION_ERROR, x.hypot(y), u_position, &more);
        let believed = seen_from(&state_before.pose, &state_after.pose);
        self.add(&q::UMBMARK_X, x - believed.0, u_position, &more);
        self.add(&q::UMBMARK_Y, y - believed.1, u_position, &more);
        let (Some(look_before), Some(look_after)) = (&ends.look_before, &ends.look_after) else {
            return;
        };
        let (from, to) = (&look_before.odometry, &look_after.odometry);
        let heading = (to.heading - from.heading - off_nominal).wrapped().deg();
        let (base_x, base_y) = seen_from(from, to);
        let u_heading = u_heading.hypot(BASE_HEADING_U_DEG);
        self.add(&q::LAP_BASE_HEADING_ERROR, heading, u_heading, &more);
        self.add(&q::LAP_BASE_X_ERROR, base_x - x, u_position, &more);
        self.add(&q::LAP_BASE_Y_ERROR, base_y - y, u_position, &more);
    }

    /// One reading of the absolute measurement.
    pub(super) fn pose(&mut self, pose: &Pose, facts: &BenchFacts) {
        self.add(&q::POSE_X, pose.x.m(), facts.absolute_position_u_m, &[]);
        self.add(&q::POSE_Y, pose.y.m(), facts.absolute_position_u_m, &[]);
        self.add(&q::POSE_HEADING, pose.heading.deg(), facts.absolute_heading_u_deg, &[]);
    }
}

/// Standard uncertainty of a mean of `samples` readings that scatter as in `result`, deg/s.
fn u_of_mean(result: &BiasTestResult, samples: u64) -> f64 {
    result.spread.deg_per_s() / (samples.max(1) as f64).sqrt()
}

/// Position of `to` in the frame of `from`, in metres.
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
