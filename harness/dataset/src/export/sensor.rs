//! Signals of nodes as a data set of kind `sensor`: a measured signal beside a reference signal.
//!
//! Each row is a value of the measured signal. The other signals come in their own messages: each is interpolated
//! linearly between its values before and after, an angle along the shorter way.

use super::ExportError;
use super::columns::{Columns, Field as Written};
use identification::dataset::{Dataset, Dimension, Kind, Role, Unit};
use plan::observation::{Observation, Observations, Observed};
use plan::quantities::during_tag;
use plan::{MessagePlace, QuantityName, Rig, models, resolve, unit};
use record::run_folder::RunFolder;
use record::{Ear, RecordKind};
use std::path::Path;

/// A signal, in the unit of its layout.
#[derive(Debug, Clone, Copy)]
pub struct Field<'a> {
    /// Its name: `NODE.SIGNAL`.
    pub quantity: &'a QuantityName,
    /// Its unit.
    pub unit: Unit,
}

/// The signals of a data set.
#[derive(Debug, Clone)]
pub struct Signals {
    /// What the sensor says.
    pub measured: QuantityName,
    /// What is true, in the same unit.
    pub reference: QuantityName,
    /// What may be a cause beside.
    pub beside: Vec<QuantityName>,
}

/// The data set of these signals of a run on `rig`, which must have been recorded with all messages.
///
/// # Errors
/// When the run cannot be read, when the rig has no such signal, or when one was never sent.
pub fn of_run(folder: &RunFolder, rig: &Rig, signals: &Signals) -> Result<Dataset, ExportError> {
    let Signals { measured, reference, beside } = signals;
    let wanted: Vec<Wanted<'_>> = [measured, reference]
        .into_iter()
        .chain(beside)
        .map(|quantity| Wanted::of(quantity, rig))
        .collect::<Result<_, _>>()?;
    if let Some(twice) = wanted.iter().skip(1).find(|one| one.is_same(&wanted[0])) {
        return Err(ExportError::NoSignal {
            message: format!("`{}` is what is measured itself", twice.quantity),
            help: "a reference, and what is beside, are other signals".to_owned(),
        });
    }
    let speaks = |index: &usize| wanted.iter().any(|one| one.place.speaker == *index);
    let heard = rig.speakers.iter().enumerate().filter(|(index, _)| speaks(index));
    let ears = heard.filter_map(|(index, one)| Some((index, Ear::of(rig, one)?)));
    let mut ears: Vec<(usize, Ear)> = ears.collect();
    let records = folder.records()?;
    let name = format!("{}-seed{}", records.header().plan, records.header().seed);
    let mut observations = Observations::default();
    let mut is_full = Ok(());
    let mut rounds = Rounds::default();
    for record in records {
        let record = record.map_err(|source| folder.unreadable(source))?;
        if let RecordKind::StepBegan { path, .. } = &record.kind {
            rounds.began(path);
        }
        for (speaker, ear) in &mut ears {
            ear.hear(&record, false, &mut |decoded| {
                for Wanted { quantity, place, signal } in &wanted {
                    let is_here = (place.speaker, place.message) == (*speaker, decoded.message);
                    let value = decoded.values.get(*signal).copied().flatten();
                    let Some(value) = value.filter(|_| is_here && decoded.is_sound()) else {
                        continue;
                    };
                    let observation = Observation {
                        quantity: quantity.as_str().to_owned(),
                        value,
                        uncertainty: 0.0,
                        tags: [
                            ("time".to_owned(), record.at.as_secs_f64()),
                            ("run".to_owned(), f64::from(rounds.count.max(1))),
                        ]
                        .into(),
                    };
                    if is_full.is_ok() {
                        is_full = observations.push(&observation);
                    }
                }
            });
        }
    }
    is_full.map_err(|full| ExportError::Sensor { why: full.to_string() })?;
    let fields: Vec<_> = wanted.iter().map(|one| one.field(rig)).collect();
    dataset(&observations, (&fields[0], &fields[1], &fields[2..]), None, &name)
        .map_err(|why| ExportError::Sensor { why })
}

/// A signal of a rig, and where it is.
struct Wanted<'a> {
    quantity: &'a QuantityName,
    place: MessagePlace,
    /// Index in its message.
    signal: usize,
}

impl<'a> Wanted<'a> {
    fn of(quantity: &'a QuantityName, rig: &Rig) -> Result<Self, ExportError> {
        let no_signal = || ExportError::NoSignal {
            message: format!("`{quantity}` is no signal of a node"),
            help: "write NODE.SIGNAL".to_owned(),
        };
        let of = quantity.of_message().ok_or_else(no_signal)?;
        let place = resolve(&rig.speakers, of).map_err(|(message, known)| {
            ExportError::NoSignal { message, help: format!("known here: {}", known.join(", ")) }
        })?;
        let signal = place.signal.ok_or_else(no_signal)?;
        Ok(Self { quantity, place, signal })
    }

    /// Whether both are one signal, under whatever name.
    fn is_same(&self, other: &Self) -> bool {
        let of = |one: &Self| (one.place.speaker, one.place.message, one.signal);
        of(self) == of(other)
    }

    fn field(&self, rig: &Rig) -> Field<'a> {
        let unit = models::unit_of(&unit(&rig.speakers, self.place));
        Field { quantity: self.quantity, unit }
    }
}

/// Counts the rounds of a plan's repeats, each of which is a run that can be held out.
#[derive(Debug, Default)]
struct Rounds {
    /// Those that began.
    count: u32,
    last: String,
}

impl Rounds {
    /// Takes the place of a step that begins, such as `steps[2].repeat[1] (round 3 of 6)`.
    fn began(&mut self, path: &str) {
        let Some((place, number)) = path.rsplit_once(" (round ") else { return };
        // The steps of a round differ in their index in its list.
        let list = place.rsplit_once('[').map_or(place, |(list, _)| list);
        let round = format!("{list} {number}");
        if round != self.last {
            self.last = round;
            self.count += 1;
        }
    }
}

/// Returns the data set called `name` of the measured signal, the reference and the others, from all rows or from those
/// during a step or label.
///
/// # Errors
/// When one of the signals was never received, or when the observations do not make a data set.
pub fn dataset(
    observations: &Observations,
    (measured, reference, beside): (&Field<'_>, &Field<'_>, &[Field<'_>]),
    over: Option<&str>,
    name: &str,
) -> Result<Dataset, String> {
    let heard = |field: &Field<'_>| {
        let heard: Vec<_> = observations.of(field.quantity.as_str()).collect();
        if heard.is_empty() { Err(format!("no `{}` was heard", field.quantity)) } else { Ok(heard) }
    };
    let during = over.map(during_tag);
    let rows: Vec<Observed<'_>> = heard(measured)?
        .into_iter()
        .filter(|row| during.as_ref().is_none_or(|tag| row.tag(tag).is_some()))
        .collect();
    const FIXED: [Written; 1] = [("time", Role::Time, Unit::Second)];
    let mut columns = Columns::new(&FIXED);
    for row in &rows {
        let run = row.tag("run").unwrap_or(1.0);
        columns.push(run.to_string(), &[row.time()]);
    }
    let values = rows.iter().map(Observed::value).collect();
    columns.add(measured.quantity.as_str(), Role::Measured, measured.unit, values);
    let mut temperature = Some(Role::Temperature);
    for (place, field) in [reference].into_iter().chain(beside).enumerate() {
        let role = match field.unit.dimension() {
            _ if place == 0 => Role::Reference,
            Dimension::Angle => Role::Heading,
            // The first temperature is that of the sensor itself.
            Dimension::Temperature => temperature.take().unwrap_or(Role::Auxiliary),
            _ => Role::Auxiliary,
        };
        let values = along(&heard(field)?, &rows, field.unit);
        columns.add(field.quantity.as_str(), role, field.unit, values);
    }
    columns.dataset(Kind::Sensor, name, Path::new(name)).map_err(|error| error.to_string())
}

fn time(observed: &Observed<'_>) -> f64 {
    observed.time().unwrap_or(f64::NAN)
}

/// A signal at each of the rows; NaN before its first and after its last value.
fn along(signal: &[Observed<'_>], rows: &[Observed<'_>], unit: Unit) -> Vec<f64> {
    let turn = std::f64::consts::TAU / unit.si();
    let mut behind = 0;
    let at = rows.iter().map(|row| {
        let now = time(row);
        while signal.get(behind).is_some_and(|one| time(one) < now) {
            behind += 1;
        }
        let after = signal.get(behind)?;
        if time(after) == now {
            return Some(after.value());
        }
        let before = signal.get(behind.checked_sub(1)?)?;
        let mut rise = after.value() - before.value();
        if unit.dimension() == Dimension::Angle {
            rise -= turn * (rise / turn).round();
        }
        Some(before.value() + rise * (now - time(before)) / (time(after) - time(before)))
    });
    at.map(|value| value.unwrap_or(f64::NAN)).collect()
}

#[cfg(test)]
mod tests {
    use super::{Field, dataset};
    use identification::dataset::{Role, Unit};
    use plan::QuantityName;
    use plan::observation::{Observation, Observations};

    fn heard(observations: &mut Observations, name: &str, values: &[(f64, f64)], label: bool) {
        for (time, value) in values {
            let mut tags = vec![("time".to_owned(), *time), ("run".to_owned(), 1.0)];
            tags.extend((label && *time > 1.2).then(|| ("during.late".to_owned(), 1.0)));
            let one = Observation {
                quantity: name.to_owned(),
                value: *value,
                uncertainty: 0.0,
                tags: tags.into_iter().collect(),
            };
            observations.push(&one).unwrap();
        }
    }

    #[test]
    fn rows_are_of_what_is_measured_and_the_rest_is_straight_between() {
        let mut observations = Observations::default();
        let angles: Vec<(f64, f64)> = (0..20).map(|i| (f64::from(i) * 0.5, 10.0)).collect();
        heard(&mut observations, "signal.Angle", &angles, true);
        let truth = [(0.25, 350.0), (1.25, 10.0), (2.25, 20.0), (9.75, 20.0)];
        heard(&mut observations, "table.Angle", &truth, false);
        let warm = [(0.0, 20.0), (9.5, 39.0)];
        heard(&mut observations, "signal.Warm", &warm, false);
        let names = ["signal.Angle", "table.Angle", "signal.Warm"];
        let names = names.map(|name| QuantityName::new(name).unwrap());
        let field = |place: usize, unit| Field { quantity: &names[place], unit };
        let (angle, table) = (field(0, Unit::Degree), field(1, Unit::Degree));
        let beside = [field(2, Unit::Celsius)];
        let of = |over| dataset(&observations, (&angle, &table, &beside), over, "x").unwrap();
        let all = of(None);
        assert_eq!(all.rows(), 20);
        let reference = &all.column(Role::Reference).unwrap().values;
        assert!(reference[0].is_nan(), "before the first truth");
        assert!((reference[1] - 355.0).abs() < 1e-9, "the short way: {}", reference[1]);
        assert!((reference[3] - 12.5).abs() < 1e-9);
        assert_eq!(all.column(Role::Temperature).unwrap().values[1], 21.0);
        assert_eq!(of(Some("late")).rows(), 17);
        let mut alone = Observations::default();
        heard(&mut alone, "signal.Angle", &angles, true);
        let error = dataset(&alone, (&angle, &table, &[]), None, "x").unwrap_err();
        assert_eq!(error, "no `table.Angle` was heard");
    }
}
