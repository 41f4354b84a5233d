//! The gyro's rate over the whole run, with the reference rate.
//!
//! At rest the true rate is zero. On the table it is known while the table turns steadily. The start of a ramp is not
//! known to a fraction of a second, so rows that may overlap one have no reference. Neither have rows in which the base
//! moves or the robot is carried.

use super::columns::{Columns, Field};
use super::turns;
use controller::mission::{Report, State};
use identification::dataset::{Role, Unit};
use plan::observation::Observation;
use record::{Record, RecordKind};

const FIELDS: [Field; 4] = [
    ("time", Role::Time, Unit::Second),
    ("gyro_rate", Role::GyroRate, Unit::DegreePerSecond),
    ("reference_rate", Role::ReferenceRate, Unit::DegreePerSecond),
    ("temperature", Role::Temperature, Unit::Celsius),
];

/// The most rows: nearly a year of 16-hour days at one per second.
const ROWS_MAX: usize = 20_000_000;

/// Prefixes of the titles of steps at rest; see `plan::title`.
const AT_REST: [&str; 4] = ["bias test of", "bias residual over", "log at rest", "wait "];

/// A mean over the time between two states.
#[derive(Debug)]
struct Mean {
    from_s: f64,
    to_s: f64,
    rate_deg_per_s: f64,
    temperature: Option<f64>,
    at_rest: bool,
}

/// The part of a table turn at constant rate.
#[derive(Debug)]
struct Steady {
    from_s: f64,
    to_s: f64,
    rate_deg_per_s: f64,
}

/// The events that concern the gyro, in order.
#[derive(Debug, Default)]
pub(super) struct Course {
    means: Vec<Mean>,
    steady: Vec<Steady>,
    last: Option<(f64, State)>,
    at_rest: bool,
    /// Whether a step began or ended since the last state.
    changed: bool,
}

impl Course {
    pub(super) fn take(&mut self, record: &Record) {
        let at_s = record.at.as_secs_f64();
        match &record.kind {
            RecordKind::StepBegan { title, .. } => {
                self.changed = true;
                self.at_rest = AT_REST.iter().any(|words| title.starts_with(words));
            }
            RecordKind::StepEnded { .. } => {
                self.changed = true;
                self.at_rest = false;
            }
            RecordKind::Report(Report::State(state)) => self.state(at_s, state),
            RecordKind::Observation(turn) if turn.quantity == turns::QUANTITY.name => {
                self.steady.extend(steady(at_s, turn));
            }
            _ => {}
        }
    }

    fn state(&mut self, at_s: f64, state: &State) {
        let changed = std::mem::take(&mut self.changed);
        let Some((from_s, before)) = self.last.replace((at_s, *state)) else { return };
        // Without a new sample there is no mean; a counter that restarts means another gyro.
        if state.samples <= before.samples || at_s <= from_s || self.means.len() >= ROWS_MAX {
            return;
        }
        let moved = state.moving || before.moving;
        self.means.push(Mean {
            from_s,
            to_s: at_s,
            rate_deg_per_s: state.raw_rate.deg_per_s(),
            temperature: state.temperature.map(|temperature| temperature.celsius()),
            at_rest: self.at_rest && !changed && !moved,
        });
    }

    /// One row per mean, at the middle of its interval.
    pub(super) fn columns(&self) -> Columns {
        let mut columns = Columns::new(&FIELDS);
        for mean in &self.means {
            let within = |turn: &&Steady| turn.from_s <= mean.from_s && mean.to_s <= turn.to_s;
            // Turns are sorted and do not overlap.
            let next = self.steady.partition_point(|turn| turn.to_s < mean.to_s);
            let turning = self.steady.get(next).filter(within).map(|turn| turn.rate_deg_per_s);
            let reference = if mean.at_rest { Some(0.0) } else { turning };
            let middle_s = mean.from_s.midpoint(mean.to_s);
            let row = [Some(middle_s), Some(mean.rate_deg_per_s), reference, mean.temperature];
            columns.push("1".to_owned(), &row);
        }
        columns
    }
}

/// The interval in which the table certainly turned steadily, for any start within the duration of the turn.
fn steady(end_s: f64, turn: &Observation) -> Option<Steady> {
    let tag = |name: &str| turn.tags.get(name).copied().filter(|value| value.is_finite());
    let (angle, rate, acceleration) = (tag("angle")?, tag("table_rate")?, tag("acceleration")?);
    let begin_s = end_s - tag("duration")?;
    let ramp_s = rate / acceleration;
    let turning_s = angle.abs() / rate + ramp_s;
    let slack_s = end_s - begin_s - turning_s;
    let (from_s, to_s) = (begin_s + slack_s + ramp_s, begin_s + turning_s - ramp_s);
    (slack_s >= 0.0 && from_s < to_s).then(|| Steady {
        from_s,
        to_s,
        rate_deg_per_s: rate.copysign(angle),
    })
}

#[cfg(test)]
mod tests {
    use super::AT_REST;
    use plan::Plan;

    #[test]
    fn titles_say_when_everything_stands() {
        let plan = r#"
name = "rest"
title = "rest"
devices = "paper"
steps = [
    { bias_test = { duration_s = 20 } },
    { bias_residual = { duration_s = 20 } },
    { log = { duration_s = 60, interval_s = 10 } },
    { wait = { duration_s = 5 } },
    { turn = { angle_deg = 90 } },
]

[[measurement]]
name = "faults"
doc = "Any"
quantity = "health.fault"
unit = "1"
check = { all_within = [0, 0] }
paper = "none"
"#;
        let plan = Plan::parse("rest.toml", plan).unwrap();
        let at_rest: Vec<bool> = plan
            .steps
            .iter()
            .map(|step| AT_REST.iter().any(|words| step.action.to_string().starts_with(words)))
            .collect();
        assert_eq!(at_rest, [true, true, true, true, false]);
    }
}
