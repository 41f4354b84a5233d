//! Sending a message beside its period: on a change of its values, and with a faster period for a while after it.

use described_file::SendKind;
use wire::time::Span;

/// Conditions for sending a message, beside its period.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SendRule {
    /// The kind of condition.
    pub kind: SendKind,
    /// The positions of the signals whose changes count; `None` for all.
    pub signals: Option<Vec<usize>>,
    /// Repetitions after a change: the time between them, and their number.
    pub fast: Option<(Span, u32)>,
    /// Minimum time after the preceding message, if a change triggers it.
    pub min_delay: Span,
}

impl SendRule {
    /// True if it has a period.
    pub const fn is_cyclic(&self) -> bool {
        matches!(self.kind, SendKind::Cyclic | SendKind::CyclicAndOnChange)
    }

    /// True if a change of this signal triggers the message.
    pub fn looks_at(&self, signal: usize) -> bool {
        let all = || self.signals.as_ref().is_none_or(|signals| signals.contains(&signal));
        self.kind != SendKind::Cyclic && all()
    }
}
