//! When a fault begins: at a time, or with a phase of the plan.

use crate::{Name, number};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wire::time::Span;

/// When a fault begins, and for a phase when it ends.
///
/// A phase is named by the key of a step (`lap`, `bias_test`) or by the label of a step. `turn`,
/// `straight` and `bias_test` are counted by what the controller is told, so that a lap holds four turns.
/// Each round of a labelled repeat is a phase of its own.
///
/// ```toml
/// when = { at_s = 300 }                            # 300 s after the run began
/// when = { step = "lap", number = 3, after_s = 2 } # 2 s after the third lap began
/// when = { during = "turn", number = 3 }           # from the begin of the third turn to its end
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Fields", into = "Fields")]
pub enum When {
    /// With the run.
    #[default]
    Always,
    /// So long after the begin of the run.
    At(Span),
    /// After the begin of a phase.
    Step {
        /// Key or label of a step.
        phase: Name,
        /// Which of them, counted from 1.
        number: u32,
        /// How long after its begin.
        after: Span,
    },
    /// Within a phase: the fault is over when that is, if not before.
    During {
        /// Key or label of a step.
        phase: Name,
        /// Which of them, counted from 1.
        number: u32,
    },
}

impl When {
    /// Whether it begins with the run.
    pub fn is_always(&self) -> bool {
        *self == Self::Always
    }

    /// The phase that it waits for, and its number.
    pub const fn phase(&self) -> Option<(&Name, u32)> {
        match self {
            Self::Always | Self::At(_) => None,
            Self::Step { phase, number, .. } | Self::During { phase, number } => {
                Some((phase, *number))
            }
        }
    }

    /// The key that names the phase in a plan.
    pub(super) const fn phase_key(&self) -> Option<&'static str> {
        match self {
            Self::Always | Self::At(_) => None,
            Self::Step { .. } => Some("step"),
            Self::During { .. } => Some("during"),
        }
    }
}

/// As it is written.
#[derive(Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    { "required": ["at_s"] }, { "required": ["step"] }, { "required": ["during"] }
]))]
struct Fields {
    /// So long after the begin of the run, s.
    #[serde(default, with = "number::DurationOrZero", skip_serializing_if = "Option::is_none")]
    at_s: Option<Span>,
    /// After the begin of this step, by its key or label.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    step: Option<Name>,
    /// From the begin to the end of this step, by its key or label.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    during: Option<Name>,
    /// Which of them, counted from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    number: Option<u32>,
    /// How long after the begin of the step, s.
    #[serde(default, with = "number::DurationOrZero", skip_serializing_if = "Option::is_none")]
    after_s: Option<Span>,
}

impl TryFrom<Fields> for When {
    type Error = String;

    fn try_from(fields: Fields) -> Result<Self, String> {
        if fields.number == Some(0) {
            return Err("`number` is 0, expected 1 for the first".to_owned());
        }
        let number = fields.number.unwrap_or(1);
        match fields {
            Fields { at_s: Some(at), step: None, during: None, number: None, after_s: None } => {
                Ok(Self::At(at))
            }
            Fields { at_s: None, step: Some(phase), during: None, after_s, .. } => {
                Ok(Self::Step { phase, number, after: after_s.unwrap_or(Span::ZERO) })
            }
            Fields { at_s: None, step: None, during: Some(phase), after_s: None, .. } => {
                Ok(Self::During { phase, number })
            }
            _ => Err("`when` needs one of `at_s`, `step` and `during`; `number` goes with the last two, \
                      `after_s` with `step`"
                .to_owned()),
        }
    }
}

impl From<When> for Fields {
    fn from(when: When) -> Self {
        let default = Self::default();
        let counted = |number: u32| (number != 1).then_some(number);
        match when {
            When::Always => default,
            When::At(at) => Self { at_s: Some(at), ..default },
            When::Step { phase, number, after } => Self {
                step: Some(phase),
                number: counted(number),
                after_s: (after != Span::ZERO).then_some(after),
                ..default
            },
            When::During { phase, number } => {
                Self { during: Some(phase), number: counted(number), ..default }
            }
        }
    }
}
