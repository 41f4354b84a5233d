//! Steps applied to every value of a signal: the errors of a sensor, or the corrections of a firmware.

use crate::expression::{Expression, Meaning, Scope, States, Unknown};
use crate::hint;
use std::collections::VecDeque;

/// Steps in order, in the language of a description. The result of the last one is the new value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Steps {
    /// Names of external inputs.
    pub inputs: Vec<(String, Input)>,
    /// The steps.
    pub steps: Vec<Step>,
    /// Delay of [`Input::Late`], s.
    pub delay_s: f64,
}

/// An external input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Input {
    /// The value itself.
    Value,
    /// The value `delay_s` ago, interpolated linearly; before the first one, the first.
    Late,
    /// Time since power-on, s.
    Time,
    /// Time since the preceding value, s.
    Interval,
    /// Another quantity that the device knows, by its name.
    Named(String),
}

/// One step; in its expression `NAME_before` is `NAME` at the preceding value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// The name of its result.
    pub name: String,
    /// The expression of its result.
    pub expression: String,
    /// The expression for the first value, if different.
    pub first: Option<String>,
}

/// Parsed steps; `I` is the source of a named input.
#[derive(Debug, Clone)]
pub(crate) struct Procedure<I> {
    inputs: Vec<(usize, Source<I>)>,
    /// Slot, expression, and the one for the first value.
    steps: Vec<(usize, Expression, Option<Expression>)>,
    names: usize,
    delay_s: f64,
}

#[derive(Debug, Clone)]
enum Source<I> {
    Value,
    Late,
    Time,
    Interval,
    From(I),
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Memory {
    /// The values of names, followed by those at the preceding value.
    slots: Vec<f64>,
    /// The time of the preceding value, and its result.
    last: Option<(f64, f64)>,
    /// Values within the delay, with their times.
    coming: VecDeque<(f64, f64)>,
}

/// Maximum number of values within the delay: a second at 10 kHz.
const COMING_MAX: usize = 10_000;

struct Names<'a>(&'a [String]);

impl Scope for Names<'_> {
    fn variable(&self, name: &str) -> Result<Meaning, Unknown> {
        let place = |name: &str| self.0.iter().position(|known| known == name);
        let before = || place(name.strip_suffix("_before")?).map(|place| place + self.0.len());
        let unknown = || {
            let known: Vec<&str> = self.0.iter().map(String::as_str).collect();
            (format!("nothing is called `{name}`"), hint::proposal(name, &known))
        };
        place(name).or_else(before).map(Meaning::Slot).ok_or_else(unknown)
    }

    fn last(&self, name: &str) -> Result<Meaning, Unknown> {
        Err((format!("`last({name})` is of states"), format!("here it is `{name}_before`")))
    }

    fn states(&self, machine: &str) -> Result<States<'_>, Unknown> {
        Err((format!("no machine `{machine}`"), "steps know no machines".to_owned()))
    }

    fn named(&self, variable: &str, _value: &str) -> Result<f64, Unknown> {
        Err((format!("values of `{variable}` have no names"), "write the number".to_owned()))
    }
}

impl Steps {
    /// Parses the steps; `find` returns the source of a named input.
    pub(crate) fn read<I>(
        &self,
        mut find: impl FnMut(&str) -> Result<I, String>,
    ) -> Result<Procedure<I>, String> {
        let names: Vec<String> = self
            .inputs
            .iter()
            .map(|(name, _)| name.clone())
            .chain(self.steps.iter().map(|step| step.name.clone()))
            .collect();
        if let Some(twice) = (1..names.len()).find(|&at| names[..at].contains(&names[at])) {
            return Err(format!("`{}` is there twice", names[twice]));
        }
        if !(0.0..f64::INFINITY).contains(&self.delay_s) {
            return Err(format!("it comes {} s before it is so", -self.delay_s));
        }
        let mut inputs = Vec::new();
        for (place, (_, input)) in self.inputs.iter().enumerate() {
            let source = match input {
                Input::Value => Source::Value,
                Input::Late => Source::Late,
                Input::Time => Source::Time,
                Input::Interval => Source::Interval,
                Input::Named(name) => Source::From(find(name)?),
            };
            inputs.push((place, source));
        }
        let scope = Names(&names);
        let parse = |text: &str, name: &str| {
            Expression::parse(text, &scope).map_err(|error| format!("`{name}`: {}", error.message))
        };
        let mut steps = Vec::new();
        for (place, step) in self.steps.iter().enumerate() {
            let always = parse(&step.expression, &step.name)?;
            let first = step.first.as_ref().map(|first| parse(first, &step.name)).transpose()?;
            steps.push((self.inputs.len() + place, always, first));
        }
        Ok(Procedure { inputs, steps, names: names.len(), delay_s: self.delay_s })
    }
}

impl<I> Procedure<I> {
    /// The result of the steps for `value` at `time`; `value` itself if that is not finite. `seen` returns named
    /// inputs.
    pub(crate) fn next(
        &self,
        memory: &mut Memory,
        time: f64,
        value: f64,
        mut seen: impl FnMut(&I) -> f64,
    ) -> f64 {
        let is_first = memory.last.is_none();
        if let Some((at, found)) = memory.last
            && time <= at
        {
            // Evaluated twice at the same time.
            return found;
        }
        let interval = memory.last.map_or(0.0, |(at, _)| time - at);
        let late = memory.delayed(time, value, self.delay_s);
        memory.slots.resize(2 * self.names, f64::NAN);
        let (now, before) = memory.slots.split_at_mut(self.names);
        before.copy_from_slice(now);
        for (place, source) in &self.inputs {
            memory.slots[*place] = match source {
                Source::Value => value,
                Source::Late => late,
                Source::Time => time,
                Source::Interval => interval,
                Source::From(from) => seen(from),
            };
        }
        let mut found = value;
        for (place, always, first) in &self.steps {
            let expression = first.as_ref().filter(|_| is_first).unwrap_or(always);
            found = expression.value(&memory.slots);
            memory.slots[*place] = found;
        }
        let found = if found.is_finite() { found } else { value };
        memory.last = Some((time, found));
        found
    }
}

impl Memory {
    /// The value `delay_s` ago, interpolated linearly; before the first one, the first.
    fn delayed(&mut self, time: f64, value: f64, delay_s: f64) -> f64 {
        if delay_s == 0.0 {
            return value;
        }
        self.coming.push_back((time, value));
        let then = time - delay_s;
        while self.coming.len() > COMING_MAX
            || self.coming.get(1).is_some_and(|(at, _)| *at <= then)
        {
            self.coming.pop_front();
        }
        match (self.coming.front(), self.coming.get(1)) {
            (Some((from, a)), Some((to, b))) if then > *from => {
                a + (b - a) * (then - from) / (to - from)
            }
            (Some((_, first)), _) => *first,
            (None, _) => value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Input, Memory, Procedure, Step, Steps};

    fn step(name: &str, expression: &str, first: Option<&str>) -> Step {
        let (name, expression) = (name.to_owned(), expression.to_owned());
        Step { name, expression, first: first.map(str::to_owned) }
    }

    fn run(steps: &Steps, values: &[f64]) -> Vec<f64> {
        let procedure: Procedure<()> = steps.read(|name| Err(format!("no {name}"))).unwrap();
        let mut memory = Memory::default();
        let at = |place: usize| place as f64 * 0.5;
        let values = values.iter().enumerate();
        values.map(|(i, x)| procedure.next(&mut memory, at(i), *x, |()| 0.0)).collect()
    }

    fn inputs(names: &[(&str, Input)]) -> Vec<(String, Input)> {
        names.iter().map(|(name, input)| ((*name).to_owned(), input.clone())).collect()
    }

    #[test]
    fn steps_see_one_another_and_what_was() {
        let steps = Steps {
            inputs: inputs(&[("x", Input::Value), ("dt", Input::Interval)]),
            steps: vec![
                step("level", "2 * x", None),
                step("slope", "(level - level_before) / dt", Some("0")),
                step("out", "level + slope", None),
            ],
            delay_s: 0.0,
        };
        assert_eq!(run(&steps, &[1.0, 2.0, 2.0]), [2.0, 8.0, 4.0]);
    }

    #[test]
    fn what_is_late_was_so_then() {
        let steps = Steps {
            inputs: inputs(&[("late", Input::Late)]),
            steps: vec![step("out", "late", None)],
            delay_s: 0.75,
        };
        assert_eq!(run(&steps, &[0.0, 1.0, 2.0, 4.0, 8.0]), [0.0, 0.0, 0.5, 1.5, 3.0]);
    }

    #[test]
    fn two_looks_at_one_instant_are_one_value() {
        let steps = Steps {
            inputs: inputs(&[("x", Input::Value)]),
            steps: vec![step("count", "count_before + x", Some("x"))],
            delay_s: 0.0,
        };
        let procedure: Procedure<()> = steps.read(|_| Ok(())).unwrap();
        let mut memory = Memory::default();
        let found = [1.0, 2.0, 2.0, 3.0].map(|at| procedure.next(&mut memory, at, 1.0, |()| 0.0));
        assert_eq!(found, [1.0, 2.0, 2.0, 3.0]);
    }

    #[test]
    fn mistakes_are_said_by_name() {
        let with = |name: &str, expression: &str| {
            let steps = vec![step(name, expression, None)];
            let steps = Steps { inputs: inputs(&[("x", Input::Value)]), steps, delay_s: 0.0 };
            steps.read(|_| Ok(())).unwrap_err()
        };
        assert_eq!(with("y", "z + 1"), "`y`: nothing is called `z`");
        assert_eq!(with("x", "1"), "`x` is there twice");
        let early = Steps { delay_s: -0.5, ..Steps::default() };
        assert_eq!(early.read(|_| Ok(())).unwrap_err(), "it comes 0.5 s before it is so");
    }
}
