//! Sources of the values of sent signals.

use super::formula::formula;
use super::parts;
use super::scope::Local;
use crate::error::{Mistake, Read};
use crate::expression::{Expression, Scope};
use crate::file::{Formula, SourceTable};
use crate::files::Files;
use crate::hint;
use crate::place::Place;
use crate::steps::Procedure;

/// Maximum length of a series. Assumption: sixteen hours at 17 Hz are enough for a trace.
const SERIES_MAX: usize = 1_000_000;

#[derive(Debug, Clone)]
pub(crate) struct SignalSource {
    pub(crate) source: Source,
    /// Standard deviation of the noise on each sent value, in the signal's unit.
    pub(crate) noise: f64,
}

#[derive(Debug, Clone)]
pub(crate) enum Source {
    /// Undriven: the signal's start value; a multiplexer cycles through its pages.
    Unsaid,
    Expression(Expression),
    /// One expression per state of the machine whose state is in this slot.
    States(usize, Box<[Expression]>),
    Series(Series),
    Sensor(Box<Sensor>),
}

/// Values over the time since power-on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Series {
    /// Time in seconds, increasing, and value. Not empty.
    points: Vec<(f64, f64)>,
    interpolate: bool,
    repeat: bool,
}

impl Series {
    /// The value at `t` seconds: the first value before the series, the last one after it.
    pub(crate) fn value(&self, t: f64) -> f64 {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return f64::NAN;
        };
        let t = if self.repeat { t - last.0 * libm::floor(t / last.0) } else { t };
        let behind = self.points.partition_point(|(at, _)| *at <= t);
        let before = behind.checked_sub(1).map_or(*first, |index| self.points[index]);
        match self.points.get(behind) {
            Some(next) if self.interpolate && behind > 0 => {
                before.1 + (next.1 - before.1) * (t - before.0) / (next.0 - before.0)
            }
            _ => before.1,
        }
    }
}

/// Parses a `[signal.NAME]`; `unit` is the signal's.
pub(super) fn source(
    table: &SourceTable,
    unit: &str,
    scope: &Local<'_>,
    place: &Place,
    files: &mut dyn Files,
) -> Read<SignalSource> {
    let noise = table.noise.unwrap_or(0.0);
    if !(0.0..f64::INFINITY).contains(&noise) {
        let message = format!("the noise cannot be {noise}");
        return Err(Mistake::new(place.key("noise"), message)
            .help("its standard deviation, in the unit of the signal"));
    }
    let given = [
        ("interpolate", table.interpolate.is_some(), table.expression.is_none()),
        ("repeat", table.repeat.is_some(), table.expression.is_none()),
        ("time", table.time.is_some(), table.csv.is_some()),
        ("value", table.value.is_some(), table.csv.is_some()),
        ("temperature", table.temperature.is_some(), table.model.is_some()),
        ("heading", table.heading.is_some(), table.model.is_some()),
    ];
    if let Some((key, ..)) = given.iter().find(|(_, given, wanted)| *given && !*wanted) {
        return Err(place.key(key).name().mistake(format!("`{key}` has no meaning here")).help(
            "`interpolate` and `repeat` are of `steps` and `csv`, `time` and `value` of `csv`, \
                 `temperature` and `heading` of `model`",
        ));
    }
    let said = said(table, scope, place, files)?;
    let source = match &table.model {
        Some(file) => {
            let sensor = sensor(table, said, (file, unit), scope, place, files)?;
            Source::Sensor(Box::new(sensor))
        }
        None => said,
    };
    Ok(SignalSource { source, noise })
}

/// Parses the source without a model.
fn said(
    table: &SourceTable,
    scope: &Local<'_>,
    place: &Place,
    files: &mut dyn Files,
) -> Read<Source> {
    if !table.in_states.is_empty() {
        if table.steps.is_some() || table.csv.is_some() {
            return Err(Mistake::new(place.key("in").name(), "a signal has one source")
                .help("in the other states it is the `expression`"));
        }
        return in_states(table, scope, place);
    }
    let (points, from) = match (&table.expression, &table.steps, &table.csv) {
        (Some(expression), None, None) => {
            let expression = formula(expression, scope, &place.key("expression"))?;
            return Ok(Source::Expression(expression));
        }
        (None, Some(steps), None) => (steps.clone(), place.key("steps")),
        (None, None, Some(csv)) => {
            let place = place.key("csv");
            let text = parts::text(files, csv, &place)?;
            let columns = [table.time.as_deref(), table.value.as_deref()];
            (points(csv, &text, columns, &place)?, place)
        }
        _ => {
            return Err(Mistake::new(place.clone(), "a signal has one source")
                .help("one of `expression`, `steps` and `csv`"));
        }
    };
    let repeat = table.repeat.unwrap_or(false);
    let series = Series { points, interpolate: table.interpolate.unwrap_or(false), repeat };
    check(&series, &from)?;
    Ok(Source::Series(series))
}

/// Parses the values per state of a machine.
fn in_states(table: &SourceTable, scope: &Local<'_>, place: &Place) -> Read<Source> {
    let all = place.key("in");
    let mut machines = table.in_states.iter();
    let (Some((machine, said)), None) = (machines.next(), machines.next()) else {
        return Err(Mistake::new(all.name(), "a signal is said in the states of one machine"));
    };
    let place_of = all.key(machine);
    let unknown = |place: Place, (text, help)| Mistake::new(place, text).help(help);
    let states = scope.states(machine).map_err(|error| unknown(place_of.name(), error))?;
    if let Some(state) = said.keys().find(|state| !states.names.contains(state)) {
        let text = format!("`{machine}` has no state `{state}`");
        return Err(Mistake::new(place_of.key(state).name(), text)
            .help(hint::proposal(state, states.names)));
    }
    let each = states.names.iter().map(|state| match (said.get(state), &table.expression) {
        (Some(given), _) => formula(given, scope, &place_of.key(state)),
        (None, Some(given)) => formula(given, scope, &place.key("expression")),
        (None, None) => Err(place_of
            .mistake(format!("nothing is said in `{state}`"))
            .help("add it, or an `expression` for all others")),
    });
    Ok(Source::States(states.slot, each.collect::<Result<_, _>>()?))
}

fn check(series: &Series, place: &Place) -> Read {
    let points = &series.points;
    let wrong = |message: String| Err(Mistake::new(place.clone(), message));
    if points.is_empty() || points.len() > SERIES_MAX {
        return wrong(format!(
            "a series has from 1 to {SERIES_MAX} points, this one {}",
            points.len()
        ));
    }
    if let Some((t, value)) = points.iter().find(|(t, v)| !t.is_finite() || !v.is_finite()) {
        return wrong(format!("({t}, {value}) is not a point of a series"));
    }
    if let Some(pair) = points.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
        let message = format!("the time does not increase from {} s to {} s", pair[0].0, pair[1].0);
        return Err(Mistake::new(place.clone(), message).help("a jump: two points 1 ms apart"));
    }
    if series.repeat && points.last().is_none_or(|(t, _)| *t <= 0.0) {
        return wrong(
            "a series that repeats ends after 0 s: its last time is its period".to_owned(),
        );
    }
    Ok(())
}

/// Two columns of a CSV file by the names in its first line; without names the first two.
fn points(
    file: &str,
    text: &str,
    columns: [Option<&str>; 2],
    place: &Place,
) -> Read<Vec<(f64, f64)>> {
    let numbers = parts::csv((file, text), place, SERIES_MAX + 1, |headers| {
        let column = |index: usize| {
            let Some(name) = columns[index] else { return Ok(index) };
            headers.iter().position(|known| known == name).ok_or_else(|| {
                let known: Vec<&str> = headers.iter().collect();
                Mistake::new(place.clone(), format!("`{file}` has no column `{name}`"))
                    .help(hint::proposal(name, &known))
            })
        };
        Ok(vec![column(0)?, column(1)?])
    })?;
    Ok(numbers.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect())
}

#[derive(Debug, Clone)]
pub(crate) struct Sensor {
    /// The true value, in the signal's unit.
    pub(crate) truth: Source,
    pub(crate) errs: Procedure<Expression>,
}

/// The sensor of a `[signal.NAME]` with a `model`: measures `truth`, with the model's file and the signal's unit.
pub(super) fn sensor(
    table: &SourceTable,
    truth: Source,
    (file, unit): (&str, &str),
    scope: &Local<'_>,
    place: &Place,
    files: &mut dyn Files,
) -> Read<Sensor> {
    let unfit =
        |error: String| place.key("model").mistake(format!("failed to use `{file}`: {error}"));
    let steps = files.errors(file, unit).map_err(unfit)?;
    // A mistake in an expression of the file is reported at its own place, not at that of the model.
    let mut wrong = None;
    let given = |key: &str, given: &Option<Formula>| match given {
        Some(given) => formula(given, scope, &place.key(key)),
        None => Err(place
            .key("model")
            .mistake(format!("the model reads a {key}, and the signal does not give one"))
            .help(format!("add `{key} = \"...\"` to the signal"))),
    };
    let read = steps.read(|name| {
        let seen = match name {
            "temperature" => given(name, &table.temperature),
            "heading" => given(name, &table.heading),
            other => Expression::parse(other, scope).map_err(|error| {
                let message = format!("the model sees `{other}`: {}", error.message);
                Mistake { help: error.help, ..Mistake::new(place.key("model"), message) }
            }),
        };
        seen.map_err(|mistake| {
            let message = mistake.message.clone();
            wrong = Some(mistake);
            message
        })
    });
    match (read, wrong) {
        (_, Some(mistake)) => Err(mistake),
        (Ok(errs), None) => Ok(Sensor { truth, errs }),
        (Err(error), None) => Err(unfit(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::Series;

    fn series(interpolate: bool, repeat: bool) -> Series {
        Series { points: vec![(1.0, 10.0), (2.0, 20.0), (4.0, 0.0)], interpolate, repeat }
    }

    #[test]
    fn a_step_holds_and_a_ramp_goes_on() {
        let at = |series: &Series| [0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0].map(|t| series.value(t));
        assert_eq!(at(&series(false, false)), [10.0, 10.0, 10.0, 20.0, 20.0, 0.0, 0.0]);
        assert_eq!(at(&series(true, false)), [10.0, 10.0, 15.0, 20.0, 10.0, 0.0, 0.0]);
    }

    #[test]
    fn what_repeats_begins_again_at_its_last_time() {
        let series = series(false, true);
        assert_eq!(series.value(4.0), 10.0);
        assert_eq!(series.value(6.5), 20.0);
        assert_eq!(series.value(4_001.5), 10.0);
    }
}
