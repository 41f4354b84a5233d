//! The steps that firmware performs for each reading, in order.

use super::formula::Formula;
use crate::finding::{CompensationInput, CompensationStep};

/// An external input of a program.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Input {
    /// The reading, in the unit of its field.
    Reading,
    /// The reading one latency earlier.
    Late,
    /// Time, s.
    Time,
    /// Time since the previous reading, s.
    Interval,
    /// A field, in its own unit.
    Field(String),
}

#[derive(Debug, Clone, PartialEq)]
struct Step {
    name: usize,
    /// The formula at the first reading, if it differs.
    first: Option<Formula>,
    always: Formula,
}

/// Steps over inputs; the last step is the output.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Program {
    names: Vec<String>,
    inputs: Vec<(Input, usize)>,
    steps: Vec<Step>,
}

impl Program {
    fn named(&mut self, name: &str) -> usize {
        self.names.push(name.to_owned());
        self.names.len() - 1
    }

    /// The name of an input.
    pub(super) fn input(&mut self, input: Input) -> Formula {
        if let Some((_, name)) = self.inputs.iter().find(|(known, _)| *known == input) {
            return Formula::Now(*name);
        }
        let name = match &input {
            Input::Reading => "x".to_owned(),
            Input::Late => "late".to_owned(),
            Input::Time => "t".to_owned(),
            Input::Interval => "dt".to_owned(),
            Input::Field(field) => self.free_name(field),
        };
        let name = self.named(&name);
        self.inputs.push((input, name));
        Formula::Now(name)
    }

    /// An unused name made of letters, digits and underscores.
    fn free_name(&self, field: &str) -> String {
        let last = field.rsplit('.').next().unwrap_or(field);
        let name: String =
            last.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let begins = name.starts_with(|c: char| c.is_ascii_alphabetic());
        let mut name = if begins && name.len() > 2 { name } else { format!("field_{name}") };
        while self.names.contains(&name) {
            name.push('_');
        }
        name
    }

    /// Adds a step under its name, numbered if that name exists.
    pub(super) fn step(&mut self, name: &str, always: Formula) -> Formula {
        self.add(name, None, |_| always)
    }

    /// Adds a step that differs at the first reading and may refer to its own previous value.
    pub(super) fn remembering(
        &mut self,
        name: &str,
        first: Formula,
        always: impl FnOnce(Formula) -> Formula,
    ) -> Formula {
        self.add(name, Some(first), always)
    }

    fn add(
        &mut self,
        name: &str,
        first: Option<Formula>,
        always: impl FnOnce(Formula) -> Formula,
    ) -> Formula {
        let mut free = name.to_owned();
        let mut number = 2;
        while self.names.contains(&free) {
            free = format!("{name}_{number}");
            number += 1;
        }
        let name = self.named(&free);
        let always = always(Formula::Before(name));
        self.steps.push(Step { name, first, always });
        Formula::Now(name)
    }

    /// Fields that the program reads.
    pub(super) fn fields(&self) -> impl Iterator<Item = &str> {
        self.inputs.iter().filter_map(|(input, _)| match input {
            Input::Field(field) => Some(field.as_str()),
            _ => None,
        })
    }

    /// The program in the form of the contract; `unit_of` returns the unit of the reading and of fields.
    pub(super) fn written(
        &self,
        reading: &str,
        unit_of: impl Fn(&str) -> String,
    ) -> (Vec<CompensationInput>, Vec<CompensationStep>) {
        let inputs = self.inputs.iter().map(|(input, name)| {
            let (of, unit) = match input {
                Input::Reading => (reading.to_owned(), unit_of(reading)),
                Input::Late => (format!("{reading}, late"), unit_of(reading)),
                Input::Time => ("time".to_owned(), "s".to_owned()),
                Input::Interval => ("time since the reading before".to_owned(), "s".to_owned()),
                Input::Field(field) => (field.clone(), unit_of(field)),
            };
            CompensationInput { name: self.names[*name].clone(), of, unit }
        });
        let steps = self.steps.iter().map(|step| CompensationStep {
            name: self.names[step.name].clone(),
            expression: step.always.text(&self.names),
            first: step.first.as_ref().map(|first| first.text(&self.names)),
        });
        (inputs.collect(), steps.collect())
    }
}

pub(super) struct Running<'a> {
    program: &'a Program,
    now: Vec<f64>,
    before: Vec<f64>,
    /// Time of the previous reading.
    at: Option<f64>,
}

impl<'a> Running<'a> {
    pub(super) fn new(program: &'a Program) -> Self {
        let none = vec![f64::NAN; program.names.len()];
        Self { program, now: none.clone(), before: none, at: None }
    }

    /// Output for the next reading. `field` returns the value of a field.
    pub(super) fn next(&mut self, time: f64, reading: f64, field: impl Fn(&str) -> f64) -> f64 {
        let is_first = self.at.is_none();
        std::mem::swap(&mut self.before, &mut self.now);
        for (input, name) in &self.program.inputs {
            self.now[*name] = match input {
                // Only emulated readings are delayed.
                Input::Reading | Input::Late => reading,
                Input::Time => time,
                Input::Interval => self.at.map_or(0.0, |at| time - at),
                Input::Field(name) => field(name),
            };
        }
        self.at = Some(time);
        let mut last = reading;
        for step in &self.program.steps {
            let formula = step.first.as_ref().filter(|_| is_first).unwrap_or(&step.always);
            last = formula.value(&self.now, &self.before);
            self.now[step.name] = last;
        }
        last
    }
}
