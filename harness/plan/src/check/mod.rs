//! The kinds of checks that a measurement can be declared with, and the figures that they judge.
//!
//! Each check forms one figure from the observations and compares it with its band. A figure inside by less than its
//! expanded uncertainty (k = 2) is [`Verdict::Marginal`]:
//!
//! | figure | its standard uncertainty |
//! |---|---|
//! | worst value | that of the observation |
//! | mean, rms | from the scatter over blocks in time, or the values' own over sqrt(n), whichever is larger |
//! | ratio, correlation | from the same blocks |
//! | slope, intercept | from the scatter about the line or the values' own, whichever is larger |
//! | share, count, time | half the change when every band moves by one standard uncertainty |
//!
//! An uncertainty from a scatter is widened by Student's t, so that k = 2 covers 95 % for few values too.
//!
//! Shares, counts and times are marginal if they pass with the band but fail with the band shrunk by each observation's
//! expanded uncertainty.

mod eventually_within;
mod exceptions;
mod figure;
mod jackknife;
mod kind;
pub mod line;
mod moments;
mod selection;
mod share_within;
mod umbmark;
mod verdict;
mod worst;

pub use eventually_within::EventuallyWithin;
pub use exceptions::{AllButInSquare, AllButWithin};
pub use figure::{Figure, Refusal};
pub use kind::{Facts, Kind, UnitOf};
pub use line::{CorrelationWithin, InterceptWithin, SlopeWithin};
pub use moments::{MeanWithin, RmsRatioWithin, RmsWithin};
pub use selection::{Meant, Selection};
pub use share_within::ShareWithin;
pub use umbmark::{PAPER_SIDE, UmbmarkFigure, UmbmarkWithin};
pub use verdict::Verdict;
pub use worst::{AllWithin, NeverOutside};

use schemars::JsonSchema;
use serde::Deserialize;

/// What a plan writes for a kind of check, and what is judged.
#[derive(Debug, Clone, Copy)]
pub struct Word {
    /// Its key, with what a plan writes there.
    pub written: &'static str,
    /// The figure that it judges.
    pub figure: &'static str,
    /// Where the figure must lie.
    pub lies_in: &'static str,
}

macro_rules! kinds {
    ($($name:ident = $key:literal, $written:literal, $figure:literal, $lies_in:literal;)*) => {
        /// What a declared measurement must satisfy. One key names the kind of check:
        ///
        /// | key | figure that is judged | must lie in |
        /// |---|---|---|
        $(#[doc = concat!("| `", $key, " = ", $written, "` | ", $figure, " | ", $lies_in, " |")])*
        ///
        /// Where a check takes `y`, the measurement's own quantity is x.
        #[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        #[expect(missing_docs, reason = "each kind documents itself")]
        pub enum Check {
            $(#[serde(rename = $key)] $name($name),)*
        }

        impl Check {
            /// All kinds.
            pub const WORDS: &[Word] = &[$(Word {
                written: concat!($key, " = ", $written),
                figure: $figure,
                lies_in: $lies_in,
            }),*];

            /// The key that names this kind of check.
            pub const fn name(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => $key,)*
                }
            }

            /// What this kind of check says of itself.
            pub fn kind(&self) -> &dyn Kind {
                match self {
                    $(Self::$name(kind) => kind,)*
                }
            }
        }
    };
}

kinds! {
    AllWithin = "all_within", "band", "the worst value", "the band";
    NeverOutside = "never_outside", "{ band, during }", "the worst value during a step or label", "the band";
    ShareWithin = "share_within", "{ share, band }",
        "share of the values in the band; of periods, of the time", "`share` to 1";
    AllButWithin = "all_but_within", "{ count, band }", "number of values outside the band", "0 to `count`";
    AllButInSquare = "all_but_in_square", "{ count, side_m, y }",
        "number of positions outside the square", "0 to `count`";
    MeanWithin = "mean_within", "band", "mean", "the band";
    RmsWithin = "rms_within", "band", "root mean square", "the band";
    RmsRatioWithin = "rms_ratio_within", "{ to, to_offset, band }",
        "root mean square over that of `to`", "the band";
    SlopeWithin = "slope_within", "{ against, band }",
        "slope of the least-squares line over a tag", "the band";
    InterceptWithin = "intercept_within", "{ against, band }", "that line at zero", "the band";
    CorrelationWithin = "correlation_within", "{ against, band }", "correlation with a tag", "the band";
    EventuallyWithin = "eventually_within", "{ band, within_s }",
        "time until values stay in the band", "0 to `within_s`";
    UmbmarkWithin = "umbmark_within", "{ figure, y, side_m, band }", "a figure of UMBmark", "the band";
}

#[cfg(test)]
mod tests {
    use super::Check;
    use crate::Action;
    use crate::documents::assert_tables;

    #[test]
    fn the_document_has_all_steps_and_checks() {
        let steps = Action::words().map(|word| {
            let example = word.example.replace('|', "\\|");
            vec![format!("`{}`", word.name), word.doc.trim().to_owned(), format!("`{example}`")]
        });
        let checks = Check::WORDS.iter().map(|word| {
            vec![format!("`{}`", word.written), word.figure.to_owned(), word.lies_in.to_owned()]
        });
        assert_tables(
            "plans.md",
            &[
                (&["step", "what is done", "example"], steps.into()),
                (&["check", "figure that is judged", "must lie in"], checks.collect()),
            ],
        );
    }
}
