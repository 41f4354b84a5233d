//! A driven path: the base's own telemetry between the ends of each lap, and the absolute pose at the ends.
//!
//! A run of the data set is a lap. Its frame is the pose measured before the lap: the reference is zero there, and in
//! the last row it is the pose measured after the lap. There is no reference in between, because a moving robot is not
//! measured. `drive_distance` and `steer_angle` are the base's counters of path and heading, which never reset or wrap;
//! a row is one state of the controller.

use super::columns::{Columns, Field};
use controller::mission::{Report, State};
use identification::dataset::{Role, Unit};
use plan::observation::Observation;
use plan::quantities as q;
use record::{Record, RecordKind};

const FIELDS: [Field; 8] = [
    ("time", Role::Time, Unit::Second),
    ("drive_distance", Role::DriveDistance, Unit::Metre),
    ("steer_angle", Role::SteerAngle, Unit::Degree),
    ("reference_x", Role::ReferenceX, Unit::Metre),
    ("reference_y", Role::ReferenceY, Unit::Metre),
    ("reference_heading", Role::ReferenceHeading, Unit::Degree),
    ("gyro_rate", Role::GyroRate, Unit::DegreePerSecond),
    ("temperature", Role::Temperature, Unit::Celsius),
];

/// The most states of all laps: one per second for half a year.
const ROWS_MAX: usize = 10_000_000;
/// The fewest rows of a lap: its start, some motion, and its end.
const LAP_ROWS_MIN: usize = 3;

/// A state of the base.
#[derive(Debug, Clone, Copy)]
struct Row {
    at_s: f64,
    distance_m: f64,
    heading_deg: f64,
    /// Mean since the previous row; `None` without a sample.
    rate_deg_per_s: Option<f64>,
    celsius: Option<f64>,
}

impl Row {
    fn has_moved(&self, since: &Self) -> bool {
        (self.distance_m, self.heading_deg) != (since.distance_m, since.heading_deg)
    }
}

/// A lap with the pose at its end: x and y in metres, heading in degrees; NaN where it was not measured.
#[derive(Debug)]
struct Lap {
    rows: Vec<Row>,
    end: [f64; 3],
}

impl Lap {
    fn is_whole(&self) -> bool {
        self.rows.len() >= LAP_ROWS_MIN && self.end.iter().all(|value| value.is_finite())
    }
}

/// Laps, in order.
#[derive(Debug, Default)]
pub(super) struct Drives {
    /// States since the start of the step.
    under_way: Vec<Row>,
    samples: u64,
    laps: Vec<Lap>,
    /// Time of the observations of the last lap.
    ended_s: Option<f64>,
    rows: usize,
    overflowed: bool,
}

impl Drives {
    pub(super) fn take(&mut self, record: &Record) {
        match &record.kind {
            RecordKind::StepBegan { .. } => self.under_way.clear(),
            RecordKind::Report(Report::State(state)) => {
                self.state(record.at.as_secs_f64(), state);
            }
            RecordKind::Observation(observed) => self.observe(observed),
            _ => {}
        }
    }

    fn state(&mut self, at_s: f64, state: &State) {
        let fresh = state.samples > self.samples;
        self.samples = state.samples;
        if self.rows + self.under_way.len() >= ROWS_MAX {
            self.overflowed = true;
            return;
        }
        if self.under_way.last().is_some_and(|last| at_s <= last.at_s) {
            return;
        }
        self.under_way.push(Row {
            at_s,
            distance_m: state.displacement.m(),
            heading_deg: state.odometry_heading.deg(),
            rate_deg_per_s: fresh.then(|| state.raw_rate.deg_per_s()),
            celsius: state.temperature.map(|temperature| temperature.celsius()),
        });
    }

    /// The observations of a lap share one time and mark its end.
    fn observe(&mut self, observed: &Observation) {
        if !super::laps::is_of_lap(&observed.quantity) {
            return;
        }
        let ended_s = observed.tags.get("time").copied();
        if ended_s.is_none() || ended_s != self.ended_s {
            self.ended_s = ended_s;
            let rows = driven(std::mem::take(&mut self.under_way));
            self.rows += rows.len();
            self.laps.push(Lap { rows, end: [f64::NAN; 3] });
        }
        let ends = [&q::LAP_RETURN_X, &q::LAP_RETURN_Y, &q::LAP_RETURN_HEADING];
        let which = ends.iter().position(|quantity| quantity.name == observed.quantity);
        if let (Some(which), Some(lap)) = (which, self.laps.last_mut()) {
            lap.end[which] = observed.value;
        }
    }

    /// One row per state, from the laps with sufficient data.
    pub(super) fn columns(&self) -> Columns {
        let mut columns = Columns::new(&FIELDS);
        for (number, lap) in self.laps.iter().enumerate().filter(|(_, lap)| lap.is_whole()) {
            let last = lap.rows.len() - 1;
            for (index, row) in lap.rows.iter().enumerate() {
                let reference = match index {
                    0 => [Some(0.0); 3],
                    index if index == last => lap.end.map(Some),
                    _ => [None; 3],
                };
                let [x, y, heading] = reference;
                let moved = [Some(row.at_s), Some(row.distance_m), Some(row.heading_deg)];
                let seen = [x, y, heading, row.rate_deg_per_s, row.celsius];
                let cells: Vec<Option<f64>> = moved.into_iter().chain(seen).collect();
                columns.push((number + 1).to_string(), &cells);
            }
        }
        columns
    }

    /// Why there are no rows.
    pub(super) fn why_not(&self) -> String {
        if self.laps.is_empty() {
            return "no lap was driven: where the robot was is known at the ends of laps alone"
                .to_owned();
        }
        let with_rows = self.laps.iter().filter(|lap| lap.rows.len() >= LAP_ROWS_MIN).count();
        if with_rows == 0 {
            return "the record holds no states of the base between the ends of its laps"
                .to_owned();
        }
        "the pose at the end of its laps was not measured".to_owned()
    }

    /// A notice about laps that are left out.
    pub(super) fn notice(&self) -> Option<String> {
        let lost = self.laps.iter().filter(|lap| !lap.is_whole()).count();
        let overflow = if self.overflowed {
            format!("; more than {ROWS_MAX} states are not read")
        } else {
            String::new()
        };
        (lost > 0 || self.overflowed).then(|| {
            format!(
                "{lost} of {} laps lack states of the base or the pose at their end, and are left out{overflow}",
                self.laps.len()
            )
        })
    }
}

/// The rows from just before the first motion of the base to just after its last: nothing moves during measurements.
fn driven(rows: Vec<Row>) -> Vec<Row> {
    let (Some(first), Some(last)) = (rows.first().copied(), rows.last().copied()) else {
        return rows;
    };
    let from = rows.iter().position(|row| row.has_moved(&first)).map_or(0, |moved| moved - 1);
    let to = rows.iter().rposition(|row| row.has_moved(&last)).map_or(from, |moves| moves + 1);
    rows[from..=to.max(from)].to_vec()
}

#[cfg(test)]
mod tests {
    use super::{Drives, Row, driven};

    fn row(at_s: f64, distance_m: f64) -> Row {
        Row { at_s, distance_m, heading_deg: 0.0, rate_deg_per_s: None, celsius: None }
    }

    #[test]
    fn rest_before_and_after_is_left_out() {
        let moved = [0.0, 0.0, 0.0, 0.1, 0.2, 0.2, 0.3, 0.3, 0.3];
        let rows = moved.iter().enumerate().map(|(at, moved)| row(at as f64, *moved)).collect();
        let times: Vec<f64> = driven(rows).iter().map(|row| row.at_s).collect();
        assert_eq!(times, [2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(driven(vec![row(0.0, 0.0), row(1.0, 0.0)]).len(), 1);
        assert!(driven(Vec::new()).is_empty());
    }

    #[test]
    fn nothing_driven_is_said_plainly() {
        assert!(Drives::default().why_not().contains("no lap"));
        assert_eq!(Drives::default().notice(), None);
    }
}
