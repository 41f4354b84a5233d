//! Words of the command line for values of other crates: the formats of a gyro, what it outputs, what is recorded.

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use std::num::NonZeroUsize;
use wire::gyro::{GyroFormat, OutputMode};

/// Takes one of these words. Of each: the word, its help, and the value.
pub fn one_of<T: Clone + Send + Sync + 'static>(
    choices: impl IntoIterator<Item = (&'static str, &'static str, T)>,
) -> impl TypedValueParser<Value = T> {
    let choices: Vec<_> = choices.into_iter().collect();
    let help = |text: &'static str| (!text.is_empty()).then_some(text);
    let words = choices.iter().map(|(word, text, _)| PossibleValue::new(*word).help(help(text)));
    PossibleValuesParser::new(words.collect::<Vec<_>>()).try_map(move |word| {
        let chosen = choices.iter().find(|(one, ..)| *one == word);
        chosen.map(|(.., value)| value.clone()).ok_or("no such word")
    })
}

/// The word for a value on the command line.
pub fn word(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// A number of things at a time.
///
/// # Errors
/// When it is no whole number, or zero.
pub fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let number: usize = text.parse().map_err(|_| "expected a whole number".to_owned())?;
    NonZeroUsize::new(number).ok_or_else(|| "expected at least 1".to_owned())
}

/// The format of a gyro's stream.
pub fn gyro_format() -> impl TypedValueParser<Value = GyroFormat> {
    one_of(GyroFormat::ALL.map(|format| (format.facts().name, format.facts().title, format)))
}

/// What the gyro puts out.
pub fn output_mode() -> impl TypedValueParser<Value = OutputMode> {
    one_of([
        ("rate", "Mean rate since the last output", OutputMode::Rate),
        ("increment", "Angle since the last output", OutputMode::Increment),
        ("integrated", "Angle modulo one turn", OutputMode::Integrated),
    ])
}
