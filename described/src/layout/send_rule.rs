//! When a message is sent beside its period: on a change of its values, and faster for a while after one.

use schemars::JsonSchema;
use serde::Deserialize;
use wire::time::Span;

/// What makes a message be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SendKind {
    /// Its period alone.
    #[default]
    Cyclic,
    /// A signal that has another value than it was sent with.
    OnChange,
    /// A signal that takes a value other than its start value: a button that is pressed, and not one that is let go.
    OnEvent,
    /// Its period, and a change in between.
    CyclicAndOnChange,
}

/// When a message is sent, beside its period.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SendRule {
    /// What makes it be sent.
    pub kind: SendKind,
    /// The places of the signals whose change counts; of all where this is absent.
    pub signals: Option<Vec<usize>>,
    /// After a change it is sent so often again, this long after one another.
    pub fast: Option<(Span, u32)>,
    /// At least so long behind the one before, where a change has it sent.
    pub min_delay: Span,
}

impl SendRule {
    /// It has a period.
    pub const fn is_cyclic(&self) -> bool {
        matches!(self.kind, SendKind::Cyclic | SendKind::CyclicAndOnChange)
    }

    /// A change of this signal has it sent.
    pub fn looks_at(&self, signal: usize) -> bool {
        let all = || self.signals.as_ref().is_none_or(|signals| signals.contains(&signal));
        self.kind != SendKind::Cyclic && all()
    }
}
