//! What a bench does at a plan's word: power, relays, flashing.

use crate::number;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, de};
use wire::time::Span;

/// What a command may take where the bench does not say, in seconds. Assumption: flashing a megabyte over SWD takes 30.
const USUAL_S: f64 = 60.0;

/// A command of the bench: `[command.flash] run = ["openocd", "-f", "board.cfg"]`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CommandSection {
    /// A program and its arguments, which no shell reads. The program is where PATH leads, or a path from the working directory.
    #[serde(deserialize_with = "words")]
    #[schemars(length(min = 1))]
    pub run: Vec<String>,
    /// It must not take longer, s.
    #[serde(rename = "time_limit_s", default = "usual", with = "number::WithinHour")]
    pub time_limit: Span,
}

/// A program and its arguments.
pub(super) fn words<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<String>, D::Error> {
    let words = Vec::<String>::deserialize(deserializer)?;
    if words.first().is_none_or(String::is_empty) {
        return Err(de::Error::custom("no program in the command line, expected one first"));
    }
    if words.iter().any(|word| word.contains('\0')) {
        return Err(de::Error::custom("a NUL in the command line, which no program can be given"));
    }
    Ok(words)
}

pub(super) fn given_words<'de, D: Deserializer<'de>>(
    d: D,
) -> Result<Option<Vec<String>>, D::Error> {
    words(d).map(Some)
}

fn usual() -> Span {
    Span::from_secs_f64(USUAL_S)
}
