//! Selects the source of the bias.

use super::{Known, Op, StepKind};
use controller::mission::{BiasMethod, Command};
use schemars::JsonSchema;
use std::fmt;

/// [`controller::mission::BiasMethod`], as it is written.
#[derive(JsonSchema)]
#[schemars(rename = "BiasMethod", rename_all = "snake_case")]
#[schemars(description = "Where the bias that is subtracted comes from.")]
#[expect(dead_code, reason = "it is only described")]
pub(super) enum Word {
    /// The last static bias test.
    StaticTest,
    /// The calibration's table of bias against temperature, for comparison.
    TemperatureTable,
    /// None is subtracted, for comparison.
    None,
}

impl StepKind for BiasMethod {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::StaticTest => "bias by static test",
            Self::TemperatureTable => "bias by temperature table",
            Self::None => "bias by no method: nothing is subtracted",
        })
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::mission(Command::SetBiasMethod(*self))])
    }
}
