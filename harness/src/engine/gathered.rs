//! What was observed, as a data set for the identification: what somebody with the same bench would have
//! noted down.

use crate::observation::Observation;
use crate::plan::Source;
use crate::plan::quantities::{self as q, Quantity, during_tag};
use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use std::collections::{BTreeMap, BTreeSet};

/// Observations, by quantity.
pub(super) type Observations = BTreeMap<String, Vec<Observation>>;

/// Which observations are meant.
pub(super) struct Selection<'a> {
    pub(super) source: Source,
    /// During this step or label.
    pub(super) over: Option<&'a str>,
    /// Observed after then, s: what ended as a calibration came into force was read under the one before.
    pub(super) since_s: f64,
}

/// The quantities that a data set of `source` is made of. The first stands for the row; the others are
/// observed at the same time, and as often.
pub(super) fn quantities(source: Source) -> &'static [&'static Quantity] {
    static OF_TURNS: [&Quantity; 2] = [&q::TABLE_ANGLE, &q::TABLE_ERROR];
    static OF_LAPS: [&Quantity; 7] = [
        &q::LAP_GYRO_ERROR,
        &q::LAP_RETURN_HEADING,
        &q::LAP_ODOMETRY_ERROR,
        &q::LAP_RETURN_X,
        &q::LAP_RETURN_Y,
        &q::UMBMARK_X,
        &q::UMBMARK_Y,
    ];
    static OF_SERIES: [&Quantity; 1] = [&q::GYRO_RATE];
    match source {
        Source::Turns => &OF_TURNS,
        Source::Laps => &OF_LAPS,
        Source::Series => &OF_SERIES,
    }
}

/// Degrees of a lap.
const LAP_DEG: f64 = 360.0;

/// Tags that become fields of their own, in any kind.
const TAGS: [(&str, Role, Unit); 7] = [
    ("time", Role::Time, Unit::Second),
    ("direction", Role::Direction, Unit::One),
    ("temperature", Role::Temperature, Unit::Celsius),
    ("table_rate", Role::TableRate, Unit::DegreePerSecond),
    ("duration", Role::Duration, Unit::Second),
    ("bias", Role::Bias, Unit::DegreePerSecond),
    ("heading", Role::Heading, Unit::Degree),
];

/// The data set called `name`. Parameters in `swept` are fields of it: candidates for a cause, as
/// whoever sets them knows them.
///
/// # Errors
///
/// When nothing of the kind was observed.
pub(super) fn dataset(
    observations: &Observations,
    selection: &Selection<'_>,
    swept: &BTreeSet<String>,
    name: &str,
) -> Result<Dataset, String> {
    let rows = rows(observations, selection);
    if rows.is_empty() {
        let source = selection.source.name();
        return Err(format!("no {source} were observed under the calibration in force"));
    }
    let (run_of_row, run_labels) = runs(&rows);
    let mut columns: Vec<Column> = values(selection.source, &rows);
    let tag = |row: &Row<'_>, tag: &str| row[0].tags.get(tag).copied().unwrap_or(f64::NAN);
    for (field, role, unit) in TAGS {
        columns.push(column(field, role, unit, rows.iter().map(|row| tag(row, field)).collect()));
    }
    for parameter in swept {
        let unit = unit_of(parameter);
        let values = rows.iter().map(|row| tag(row, parameter)).collect();
        columns.push(column(parameter, Role::Auxiliary, unit, values));
    }
    columns.retain(|column| column.values.iter().any(|value| value.is_finite()));
    Ok(Dataset {
        name: name.to_owned(),
        kind: match selection.source {
            Source::Turns => Kind::Turns,
            Source::Laps => Kind::Laps,
            Source::Series => Kind::Series,
        },
        drive: None,
        constants: BTreeMap::new(),
        columns,
        run_of_row,
        run_labels,
        notices: Vec::new(),
    })
}

/// What was observed of one turn, lap or interval: an observation of each quantity.
type Row<'a> = Vec<&'a Observation>;

fn rows<'a>(observations: &'a Observations, selection: &Selection<'_>) -> Vec<Row<'a>> {
    let during = selection.over.map(during_tag);
    let meant = |observation: &&Observation| {
        let in_time = observation.tags.get("time").is_some_and(|t| *t > selection.since_s);
        in_time && during.as_ref().is_none_or(|tag| observation.tags.contains_key(tag))
    };
    let of = |quantity: &&Quantity| -> Vec<&'a Observation> {
        observations.get(quantity.name).into_iter().flatten().filter(meant).collect()
    };
    let columns: Vec<_> = quantities(selection.source).iter().map(of).collect();
    let count = columns.iter().map(Vec::len).min().unwrap_or(0);
    (0..count).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
}

/// The run of each row and the runs' labels. A run ends where the next begins: numbers only grow.
fn runs(rows: &[Row<'_>]) -> (Vec<usize>, Vec<String>) {
    let mut labels: Vec<String> = Vec::new();
    let of_row = rows
        .iter()
        .map(|row| {
            let label = row[0].tags.get("run").copied().unwrap_or(1.0).to_string();
            if labels.last() != Some(&label) {
                labels.push(label);
            }
            labels.len() - 1
        })
        .collect();
    (of_row, labels)
}

/// The fields that the observed values make.
fn values(source: Source, rows: &[Row<'_>]) -> Vec<Column> {
    let each = |f: &dyn Fn(&Row<'_>) -> f64| rows.iter().map(f).collect::<Vec<f64>>();
    let direction = |row: &Row<'_>| row[0].tags.get("direction").copied().unwrap_or(f64::NAN);
    let deg = |name, role, values| column(name, role, Unit::Degree, values);
    let metre = |name, role, values| column(name, role, Unit::Metre, values);
    match source {
        Source::Turns => vec![
            deg("gyro_angle", Role::GyroAngle, each(&|row| direction(row) * row[0].value)),
            deg(
                "reference_angle",
                Role::ReferenceAngle,
                each(&|row| direction(row) * (row[0].value - row[1].value)),
            ),
        ],
        Source::Laps => {
            let turned = |row: &Row<'_>| direction(row) * LAP_DEG + row[1].value;
            vec![
                deg(
                    "gyro_angle",
                    Role::GyroAngle,
                    each(&|row| turned(row) + direction(row) * row[0].value),
                ),
                deg("reference_angle", Role::ReferenceAngle, each(&turned)),
                deg("reference_heading", Role::ReferenceHeading, each(&|row| row[1].value)),
                deg(
                    "odometry_heading",
                    Role::OdometryHeading,
                    each(&|row| row[1].value + direction(row) * row[2].value),
                ),
                metre("reference_x", Role::ReferenceX, each(&|row| row[3].value)),
                metre("reference_y", Role::ReferenceY, each(&|row| row[4].value)),
                metre("odometry_x", Role::OdometryX, each(&|row| row[3].value - row[5].value)),
                metre("odometry_y", Role::OdometryY, each(&|row| row[4].value - row[6].value)),
            ]
        }
        Source::Series => {
            let rate = |name, role, values| column(name, role, Unit::DegreePerSecond, values);
            vec![
                rate("gyro_rate", Role::GyroRate, each(&|row| row[0].value)),
                rate("reference_rate", Role::ReferenceRate, each(&|_| 0.0)),
            ]
        }
    }
}

fn column(name: &str, role: Role, unit: Unit, values: Vec<f64>) -> Column {
    Column { name: name.to_owned(), role, axis: None, unit, values }
}

/// A parameter's unit is the last part of its name; where the contract has none of it, a plain number.
fn unit_of(parameter: &str) -> Unit {
    const ENDINGS: [(&str, Unit); 8] = [
        ("_deg_per_s", Unit::DegreePerSecond),
        ("_deg_per_h", Unit::DegreePerHour),
        ("_celsius", Unit::Celsius),
        ("_kelvin", Unit::Celsius),
        ("_volt", Unit::Volt),
        ("_ampere", Unit::Ampere),
        ("_deg", Unit::Degree),
        ("_s", Unit::Second),
    ];
    let ending = ENDINGS.iter().find(|(ending, _)| parameter.ends_with(ending));
    // What is per something else is none of these.
    ending.filter(|_| parameter.matches("_per_").count() < 2).map_or(Unit::One, |(_, unit)| *unit)
}

#[cfg(test)]
mod tests {
    use super::{Observations, Selection, dataset};
    use crate::observation::Observation;
    use crate::plan::Source;
    use crate::plan::quantities as q;
    use identification::dataset::{Kind, Role, Unit};

    fn turn(observations: &mut Observations, run: f64, direction: f64, error: f64) {
        let tags = [
            ("run", run),
            ("time", 100.0 * run + direction),
            ("direction", direction),
            ("temperature", 30.0),
            ("table_rate", 30.0),
            ("gyro.supply_deviation_volt", 0.5),
            ("during.warm_up", f64::from(u8::from(run > 1.0))),
        ];
        let tags: std::collections::BTreeMap<_, _> = tags
            .into_iter()
            .filter(|(name, value)| !(name.starts_with("during") && *value == 0.0))
            .map(|(name, value)| (name.to_owned(), value))
            .collect();
        for (quantity, value) in [(&q::TABLE_ANGLE, 360.0 + error), (&q::TABLE_ERROR, error)] {
            observations.entry(quantity.name.to_owned()).or_default().push(Observation {
                quantity: quantity.name.to_owned(),
                value,
                uncertainty: 0.0,
                tags: tags.clone(),
            });
        }
    }

    #[test]
    fn turns_are_rows_with_their_runs_and_their_signs() {
        let mut observations = Observations::new();
        for run in [1.0, 2.0, 3.0] {
            turn(&mut observations, run, -1.0, -2.0 * run);
            turn(&mut observations, run, 1.0, run);
        }
        let swept = ["gyro.supply_deviation_volt".to_owned()].into();
        let of = |over, since_s| {
            let selection = Selection { source: Source::Turns, over, since_s };
            dataset(&observations, &selection, &swept, "x")
        };
        let all = of(None, 0.0).unwrap();
        assert_eq!((all.kind, all.rows(), all.run_labels.len()), (Kind::Turns, 6, 3));
        assert_eq!(all.run_of_row, [0, 0, 1, 1, 2, 2]);
        let angle = |role| all.column(role).unwrap().values[..2].to_vec();
        assert_eq!(angle(Role::GyroAngle), [-358.0, 361.0]);
        assert_eq!(angle(Role::ReferenceAngle), [-360.0, 360.0]);
        assert_eq!(all.column(Role::Auxiliary).map(|c| c.unit), Some(Unit::Volt));
        assert!(all.column(Role::Duration).is_none(), "nothing is known of it");
        assert_eq!(of(Some("warm_up"), 0.0).unwrap().rows(), 4);
        assert_eq!(of(None, 250.0).unwrap().run_labels, ["3"]);
        assert!(of(Some("nothing"), 0.0).unwrap_err().contains("no turns"));
    }
}
