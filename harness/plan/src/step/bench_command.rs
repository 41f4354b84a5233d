//! What the bench does by a command of its own.

use super::{Known, Op, Order, StepKind};
use crate::bench_file::COMMAND_S_MAX;
use crate::name::Name;
use crate::time_limits::SLACK;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// A command of the bench file is run: `do = "flash"`. In virtual time there is no bench, and nothing is run.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct BenchCommand {
    /// That of a `[command.NAME]` of the bench file.
    pub name: Name,
}

impl StepKind for BenchCommand {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "run `{}` of the bench", self.name)
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Order(Order::Command(self.name.as_str().to_owned()))])
    }

    /// The bench says what its command may take; this is beyond.
    fn limit(&self) -> Span {
        Span::from_secs_f64(COMMAND_S_MAX) + SLACK
    }
}
