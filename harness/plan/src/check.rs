//! The kinds of checks that a measurement can be declared with.

use super::band::Band;
use super::number;
use super::quantity::QuantityName;
use schemars::JsonSchema;
use serde::Deserialize;
use wire::time::Span;
use wire::units::Length;

/// What a declared measurement must satisfy. One key names the kind of check:
///
/// | key | figure that is judged | must lie in |
/// |---|---|---|
/// | `all_within = band` | the worst value | the band |
/// | `never_outside = { band, during }` | the worst value during a step or label | the band |
/// | `share_within = { share, band }` | share of the values in the band | `share` to 1 |
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
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Check {
    /// Every value lies in the band.
    AllWithin(Band),
    /// Every value observed during a phase lies in the band, and there is at least one.
    NeverOutside {
        /// The band.
        band: Band,
        /// Name or label of a step.
        during: String,
    },
    /// At least a share of the values lies in the band.
    ShareWithin {
        /// The least share.
        #[serde(deserialize_with = "number::share")]
        #[schemars(schema_with = "number::schema::share")]
        share: f64,
        /// The band.
        band: Band,
    },
    /// All values but so many lie in the band.
    AllButWithin {
        /// How many may lie outside.
        count: u32,
        /// The band.
        band: Band,
    },
    /// All positions but so many lie in a square along the axes.
    AllButInSquare {
        /// How many may lie outside.
        count: u32,
        /// Length of a side.
        #[serde(rename = "side_m", deserialize_with = "number::length")]
        #[schemars(schema_with = "number::schema::length")]
        side: Length,
        /// The quantity that is y, of the same unit.
        y: QuantityName,
        /// Where the square's centre is. The paper does not say where its 10 x 10 cm square lies; the
        /// start of the lap, which is the default, is the strictest reading.
        #[serde(rename = "centre_m", default)]
        centre: [f64; 2],
    },
    /// The mean lies in the band.
    MeanWithin(Band),
    /// The root mean square lies in the band.
    RmsWithin(Band),
    /// The root mean square, over that of another quantity of the same unit, lies in the band.
    RmsRatioWithin {
        /// The other quantity.
        to: QuantityName,
        /// Standard uncertainty of an offset that all values of `to` in a run share, in their unit: known from a model
        /// of their source, because their scatter does not show it.
        #[serde(default, deserialize_with = "number::positive")]
        #[schemars(schema_with = "number::schema::positive")]
        to_offset: f64,
        /// The band.
        band: Band,
    },
    /// The slope of the least-squares line lies in the band.
    SlopeWithin {
        /// The tag that is the abscissa.
        against: String,
        /// The band.
        band: Band,
    },
    /// The ordinate of the least-squares line at zero lies in the band.
    InterceptWithin {
        /// The tag that is the abscissa.
        against: String,
        /// The band.
        band: Band,
    },
    /// Pearson's correlation lies in the band.
    CorrelationWithin {
        /// The tag to correlate with.
        against: String,
        /// The band.
        band: Band,
    },
    /// From some time on every value lies in the band.
    EventuallyWithin {
        /// The band.
        band: Band,
        /// The latest such time, counted from the first value.
        #[serde(rename = "within_s", deserialize_with = "number::duration_or_zero")]
        #[schemars(schema_with = "number::schema::duration_or_zero")]
        within: Span,
    },
    /// A figure of UMBmark lies in the band.
    UmbmarkWithin {
        /// Which.
        figure: UmbmarkFigure,
        /// The quantity that is y, of the same unit.
        y: QuantityName,
        /// Side of the square path.
        #[serde(rename = "side_m", default = "paper_side", deserialize_with = "number::length")]
        #[schemars(
            schema_with = "number::schema::length",
            extend("default" = number::schema::written(PAPER_SIDE.m()))
        )]
        side: Length,
        /// The band.
        band: Band,
    },
}

/// Side of the paper's square path: 4 m (section 4.1), which is UMBmark's too.
pub const PAPER_SIDE: Length = Length::from_m(4.0);

fn paper_side() -> Length {
    PAPER_SIDE
}

/// The figures of UMBmark that make sense without a wheelbase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum UmbmarkFigure {
    /// E_max,syst: the larger distance of the two directions' centres of gravity from the origin, m.
    EMaxSyst,
    /// alpha: the effective error of each corner's turn, deg.
    Alpha,
    /// beta: the effective change of heading along one side, deg.
    Beta,
}

impl Check {
    /// The figure is estimated from many values, and its uncertainty says how far another run's would be from it. That of
    /// a worst value is the reading's alone, and counts are exact.
    pub const fn estimates(&self) -> bool {
        matches!(
            self,
            Self::MeanWithin(_)
                | Self::RmsWithin(_)
                | Self::RmsRatioWithin { .. }
                | Self::SlopeWithin { .. }
                | Self::InterceptWithin { .. }
                | Self::CorrelationWithin { .. }
                | Self::UmbmarkWithin { .. }
        )
    }

    /// The tag on the abscissa, if any.
    pub fn against(&self) -> Option<&str> {
        match self {
            Self::SlopeWithin { against, .. }
            | Self::InterceptWithin { against, .. }
            | Self::CorrelationWithin { against, .. } => Some(against),
            _ => None,
        }
    }

    /// The key and the name of the second quantity, if any.
    pub fn second_quantity(&self) -> Option<(&'static str, &QuantityName)> {
        match self {
            Self::AllButInSquare { y, .. } | Self::UmbmarkWithin { y, .. } => Some(("y", y)),
            Self::RmsRatioWithin { to, .. } => Some(("to", to)),
            _ => None,
        }
    }

    /// Unit of the judged figure; `unit` is that of the quantity, `against` that of the abscissa. `1` for shares,
    /// counts and ratios.
    pub fn figure_unit(&self, unit: &str, against: &str) -> String {
        match self {
            Self::AllWithin(_)
            | Self::NeverOutside { .. }
            | Self::MeanWithin(_)
            | Self::RmsWithin(_)
            | Self::InterceptWithin { .. } => unit.to_owned(),
            Self::ShareWithin { .. }
            | Self::AllButWithin { .. }
            | Self::AllButInSquare { .. }
            | Self::RmsRatioWithin { .. }
            | Self::CorrelationWithin { .. } => "1".to_owned(),
            Self::SlopeWithin { .. } => match against {
                "1" => unit.to_owned(),
                against => format!("{unit}/{against}"),
            },
            Self::EventuallyWithin { .. } => "s".to_owned(),
            Self::UmbmarkWithin { figure: UmbmarkFigure::EMaxSyst, .. } => unit.to_owned(),
            Self::UmbmarkWithin { .. } => "deg".to_owned(),
        }
    }

    /// The band of the judged figure.
    pub fn figure_band(&self) -> Band {
        match self {
            Self::AllWithin(band)
            | Self::MeanWithin(band)
            | Self::RmsWithin(band)
            | Self::NeverOutside { band, .. }
            | Self::RmsRatioWithin { band, .. }
            | Self::SlopeWithin { band, .. }
            | Self::InterceptWithin { band, .. }
            | Self::CorrelationWithin { band, .. }
            | Self::UmbmarkWithin { band, .. } => *band,
            Self::ShareWithin { share, .. } => Band::at_least(*share),
            Self::AllButWithin { count, .. } | Self::AllButInSquare { count, .. } => {
                Band::at_most(f64::from(*count))
            }
            Self::EventuallyWithin { within, .. } => Band::at_most(within.as_secs_f64()),
        }
    }

    /// The band of single values; `None` if the check is on a figure of all values.
    pub const fn value_band(&self) -> Option<Band> {
        match self {
            Self::AllWithin(band)
            | Self::NeverOutside { band, .. }
            | Self::ShareWithin { band, .. }
            | Self::AllButWithin { band, .. }
            | Self::EventuallyWithin { band, .. } => Some(*band),
            _ => None,
        }
    }

    /// The key that names this kind of check.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::AllWithin(_) => "all_within",
            Self::NeverOutside { .. } => "never_outside",
            Self::ShareWithin { .. } => "share_within",
            Self::AllButWithin { .. } => "all_but_within",
            Self::AllButInSquare { .. } => "all_but_in_square",
            Self::MeanWithin(_) => "mean_within",
            Self::RmsWithin(_) => "rms_within",
            Self::RmsRatioWithin { .. } => "rms_ratio_within",
            Self::SlopeWithin { .. } => "slope_within",
            Self::InterceptWithin { .. } => "intercept_within",
            Self::CorrelationWithin { .. } => "correlation_within",
            Self::EventuallyWithin { .. } => "eventually_within",
            Self::UmbmarkWithin { .. } => "umbmark_within",
        }
    }
}
