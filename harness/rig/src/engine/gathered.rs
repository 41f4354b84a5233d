//! The observations of this run so far, as a data set with the same rows as the export of a completed run.

use controller::mission::HeadingSource;
use dataset::export::columns::{Columns, Field};
use dataset::export::{laps, turns};
use identification::dataset::{Dataset, Kind, Role, Unit};
use plan::Source;
use plan::observation::{Observation, Observations, Observed};
use plan::quantities::{self as q, during_tag};
use std::collections::BTreeSet;
use std::path::Path;

pub(super) struct Selection<'a> {
    pub(super) source: Source,
    /// During this step or label.
    pub(super) over: Option<&'a str>,
    /// Observed after this time, s. Something that ended just as a calibration came into force was measured under the
    /// previous one.
    pub(super) since_s: f64,
    /// Heading source of the loops: dead reckoning by the gyro is not odometry.
    pub(super) heading_source: HeadingSource,
}

/// Whether data sets of `source` are made of that quantity.
pub(super) fn is_of(source: Source, quantity: &str) -> bool {
    match source {
        Source::Turns => quantity == turns::QUANTITY.name,
        Source::Laps => laps::is_of_lap(quantity),
        Source::Series => quantity == q::GYRO_RATE.name,
        // The step itself names the quantities of a sensor.
        Source::Sensor => false,
    }
}

const REST_FIELDS: [Field; 4] = [
    ("time", Role::Time, Unit::Second),
    ("gyro_rate", Role::GyroRate, Unit::DegreePerSecond),
    ("reference_rate", Role::ReferenceRate, Unit::DegreePerSecond),
    ("temperature", Role::Temperature, Unit::Celsius),
];

/// Returns the data set called `name`. Parameters in `swept` become fields, as candidates for a cause: the plan knows
/// them, because it sets them.
///
/// # Errors
/// When there is no such observation, or when the observations do not make a data set.
pub(super) fn dataset(
    observations: &Observations,
    selection: &Selection<'_>,
    swept: &BTreeSet<String>,
    name: &str,
) -> Result<Dataset, String> {
    let observed = select(observations, selection);
    let (kind, mut columns) = match selection.source {
        Source::Turns => (Kind::Turns, turns::columns(&observed)),
        Source::Laps => {
            let source = selection.heading_source;
            let with_source: Vec<_> = observed.iter().cloned().map(|one| (one, source)).collect();
            (Kind::Laps, laps::columns(&with_source))
        }
        Source::Series => (Kind::Series, at_rest(&observed)),
        Source::Sensor => return Err("signals of nodes are gathered by themselves".to_owned()),
    };
    if columns.is_empty() {
        let source = selection.source.name();
        return Err(format!("no {source} were observed under the calibration in force"));
    }
    // Observations of one row have the same time.
    let rows = observed.chunk_by(|one, other| one.tags.get("time") == other.tags.get("time"));
    let firsts: Vec<&Observation> = rows.filter_map(<[_]>::first).collect();
    for parameter in swept {
        let value = |row: &&Observation| row.tags.get(parameter).copied().unwrap_or(f64::NAN);
        let values = firsts.iter().map(value).collect();
        columns.add(parameter, Role::Auxiliary, unit_of(parameter), values);
    }
    columns.dataset(kind, name, Path::new(name)).map_err(|error| error.to_string())
}

fn select(observations: &Observations, selection: &Selection<'_>) -> Vec<Observation> {
    let during = selection.over.map(during_tag);
    let is_meant = |observed: &Observed<'_>| {
        observed.time().is_some_and(|time| time > selection.since_s)
            && during.as_ref().is_none_or(|tag| observed.tag(tag).is_some())
    };
    let mut selected: Vec<Observation> = observations
        .quantities()
        .filter(|quantity| is_of(selection.source, quantity))
        .flat_map(|quantity| {
            observations.of(quantity).filter(is_meant).map(|one| one.named(quantity))
        })
        .collect();
    let time = |observed: &Observation| observed.tag("time").unwrap_or(f64::NAN);
    selected.sort_by(|one, other| time(one).total_cmp(&time(other)));
    selected
}

/// One row per interval of a log: at rest the true rate is zero.
fn at_rest(observed: &[Observation]) -> Columns {
    let mut columns = Columns::new(&REST_FIELDS);
    for mean in observed {
        let tag = |name: &str| mean.tags.get(name).copied();
        let row = [tag("time"), Some(mean.value), Some(0.0), tag("temperature")];
        columns.push(tag("run").unwrap_or(1.0).to_string(), &row);
    }
    columns
}

/// Unit of a parameter, from the last part of its name; a plain number if the contract has no such unit.
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
    // A quotient of quantities is in none of these units.
    ending.filter(|_| parameter.matches("_per_").count() < 2).map_or(Unit::One, |(_, unit)| *unit)
}

#[cfg(test)]
mod tests {
    use super::{Selection, dataset};
    use controller::mission::HeadingSource;
    use identification::dataset::{Kind, Role, Unit};
    use plan::Source;
    use plan::observation::{Observation, Observations};
    use plan::quantities as q;

    fn turn(observations: &mut Observations, run: f64, direction: f64, error: f64) {
        let tags = [
            ("run", run),
            ("time", 100.0 * run + direction),
            ("direction", direction),
            ("temperature", 30.0),
            ("table_rate", 30.0),
            ("angle", 360.0 * direction),
            ("gyro.supply_deviation_volt", 0.5 * run),
            ("during.warm_up", f64::from(u8::from(run > 1.0))),
        ];
        let tags: std::collections::BTreeMap<_, _> = tags
            .into_iter()
            .filter(|(name, value)| !(name.starts_with("during") && *value == 0.0))
            .map(|(name, value)| (name.to_owned(), value))
            .collect();
        let quantity = q::TABLE_ANGLE.name.to_owned();
        let turn = Observation { quantity, value: 360.0 + error, uncertainty: 0.0, tags };
        observations.push(&turn).unwrap();
    }

    #[test]
    fn turns_are_rows_with_their_runs_and_their_signs() {
        let mut observations = Observations::default();
        for run in [1.0, 2.0, 3.0] {
            turn(&mut observations, run, -1.0, -2.0 * run);
            turn(&mut observations, run, 1.0, run);
        }
        let swept = ["gyro.supply_deviation_volt".to_owned()].into();
        let of = |over, since_s| {
            let selection = Selection {
                source: Source::Turns,
                over,
                since_s,
                heading_source: HeadingSource::Gyro,
            };
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
