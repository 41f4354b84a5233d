//! A gyro's stream on the command line: the name of each format, and what it outputs.

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use wire::gyro::{GyroFormat, OutputMode};

pub fn format() -> impl TypedValueParser<Value = GyroFormat> {
    let value = |format: &GyroFormat| {
        let facts = format.facts();
        PossibleValue::new(facts.name).help(facts.title)
    };
    let names = PossibleValuesParser::new(GyroFormat::ALL.iter().map(value));
    names.try_map(|name| GyroFormat::named(&name).ok_or("no format has this name"))
}

/// What the gyro puts out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Mode {
    /// Mean rate since the last output
    Rate,
    /// Angle since the last output
    Increment,
    /// Angle modulo one turn
    Integrated,
}

impl From<Mode> for OutputMode {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Rate => Self::Rate,
            Mode::Increment => Self::Increment,
            Mode::Integrated => Self::Integrated,
        }
    }
}
