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

macro_rules! kinds {
    ($($name:ident = $key:literal,)*) => {
        /// What a declared measurement must satisfy. One key names the kind of check:
        ///
        /// | key | figure that is judged | must lie in |
        /// |---|---|---|
        /// | `all_within = band` | the worst value | the band |
        /// | `never_outside = { band, during }` | the worst value during a step or label | the band |
        /// | `share_within = { share, band }` | share of the values in the band; of periods, of the time | `share` to 1 |
        /// | `all_but_within = { count, band }` | number of values outside the band | 0 to `count` |
        /// | `all_but_in_square = { count, side_m, y }` | number of positions outside the square | 0 to `count` |
        /// | `mean_within = band` | mean | the band |
        /// | `rms_within = band` | root mean square | the band |
        /// | `rms_ratio_within = { to, to_offset, band }` | root mean square over that of `to` | the band |
        /// | `slope_within = { against, band }` | slope of the least-squares line over a tag | the band |
        /// | `intercept_within = { against, band }` | that line at zero | the band |
        /// | `correlation_within = { against, band }` | correlation with a tag | the band |
        /// | `eventually_within = { band, within_s }` | time until values stay in the band | 0 to `within_s` |
        /// | `umbmark_within = { figure, y, side_m, band }` | a figure of UMBmark | the band |
        ///
        /// Where a check takes `y`, the measurement's own quantity is x.
        #[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        #[expect(missing_docs, reason = "each kind documents itself")]
        pub enum Check {
            $(#[serde(rename = $key)] $name($name),)*
        }

        impl Check {
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
    AllWithin = "all_within",
    NeverOutside = "never_outside",
    ShareWithin = "share_within",
    AllButWithin = "all_but_within",
    AllButInSquare = "all_but_in_square",
    MeanWithin = "mean_within",
    RmsWithin = "rms_within",
    RmsRatioWithin = "rms_ratio_within",
    SlopeWithin = "slope_within",
    InterceptWithin = "intercept_within",
    CorrelationWithin = "correlation_within",
    EventuallyWithin = "eventually_within",
    UmbmarkWithin = "umbmark_within",
}
