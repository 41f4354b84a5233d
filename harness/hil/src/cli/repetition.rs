//! `hil campaign --clock real`: how often a case is repeated when runs differ.

use super::failure::Failure;
use campaign::REPEATS_MAX;
use campaign::{BREAKS_AT_LEAST, CONFIDENCE, REPEATS, Repetition};
use clap::Args;

/// When a case counts as broken on a bench, where the same case does not always come to the same.
#[derive(Debug, Clone, Args)]
pub(super) struct RepetitionArguments {
    /// With --clock real: repetitions of a case that broke a property; the first run does not
    /// count. [default: 8]
    #[arg(long, value_name = "N", conflicts_with_all = ["envelope", "envelopes"],
          value_parser = clap::value_parser!(u64).range(1..=REPEATS_MAX))]
    repeat: Option<u64>,
    /// With --clock real: confidence that the property breaks in the share of --breaks-at-least.
    /// [default: 0.95]
    #[arg(long, value_name = "SHARE", conflicts_with_all = ["envelope", "envelopes"])]
    confidence: Option<f64>,
    /// With --clock real: share of all runs in which a property must break to count as broken. [default: 0.5]
    #[arg(long, value_name = "SHARE", conflicts_with_all = ["envelope", "envelopes"])]
    breaks_at_least: Option<f64>,
}

impl RepetitionArguments {
    /// Refuses repetitions: in virtual time nothing is repeated.
    pub(super) fn none(&self) -> Result<(), Failure> {
        let asked =
            self.repeat.is_some() || self.confidence.is_some() || self.breaks_at_least.is_some();
        if asked {
            return Err(Failure::arguments(
                "the virtual clock has no use for repetition: the same case always comes to the same",
                "add --clock real, or leave out --repeat, --confidence and --breaks-at-least",
            ));
        }
        Ok(())
    }

    pub(super) fn rule(&self) -> Result<Repetition, Failure> {
        Ok(Repetition::new(
            self.repeat.unwrap_or(REPEATS),
            self.confidence.unwrap_or(CONFIDENCE),
            self.breaks_at_least.unwrap_or(BREAKS_AT_LEAST),
        )?)
    }
}
