//! How long messages take on a bus, and how often they can be sent.

use described::{Layout, Message};
use wire::can::Id;
use wire::time::Span;

/// Candidate periods of messages for which the DBC states none: the first that leaves room on the bus is used.
/// Assumption: the first is the usual one of status messages.
const PERIODS: [Span; 3] =
    [Span::from_millis(100), Span::from_millis(1_000), Span::from_millis(10_000)];

/// Maximum bus load of all messages, so that each arrives on time.
pub(super) const LOAD_MAX: f64 = 0.5;

/// Bit rate of the emulated device's bus, bit/s.
const BIT_RATE: f64 = 500e3;

/// Longest frames of eight bytes, with all stuff bits and the interframe gap: identifiers of 11 and of 29 bits. Zeros,
/// the signals' start values, need nearly as many bits.
const BITS_STANDARD: f64 = 135.0;
const BITS_EXTENDED: f64 = 160.0;

/// Longest CAN FD frame with 64 bytes, if the file does not state a faster data rate.
const BITS_FD: f64 = 730.0;

/// Returns the period of a message. A multi-packet message takes 50 ms per packet; without a period in the file, twice
/// that is assumed.
pub(super) fn period(message: &Message, assumed: Span) -> Span {
    message.period.unwrap_or_else(|| match message.frames() {
        1 => assumed,
        frames => assumed.max(Span::from_millis(100) * frames),
    })
}

fn bits(message: &Message) -> f64 {
    let each = match message.can_id() {
        _ if message.is_fd() => BITS_FD,
        Some(Id::Extended(_)) => BITS_EXTENDED,
        _ => BITS_STANDARD,
    };
    each * message.frames() as f64
}

/// Returns the bus load of these messages, with this period for messages whose file states no period.
pub(super) fn load<'a>(messages: impl Iterator<Item = &'a Message>, assumed: Span) -> f64 {
    let bits_per_s = messages.map(|message| bits(message) / period(message, assumed).as_secs_f64());
    bits_per_s.sum::<f64>() / BIT_RATE
}

/// The longest waits of messages for the bus if all are due at once: for a frame in progress, and for those of higher
/// priority.
pub(super) struct Waits(Vec<(Option<Id>, f64)>);

impl Waits {
    pub(super) fn of(layout: &Layout) -> Self {
        let mut sums: Vec<_> =
            layout.messages().iter().map(|message| (message.can_id(), bits(message))).collect();
        sums.sort_by_key(|(id, _)| *id);
        let mut sum = BITS_FD;
        for (_, bits) in &mut sums {
            sum += *bits;
            *bits = sum;
        }
        Self(sums)
    }

    /// Returns that of a message, in seconds.
    pub(super) fn wait_s(&self, message: &Message) -> f64 {
        let better = self.0.partition_point(|(id, _)| *id < message.can_id());
        let last = better.checked_sub(1).and_then(|last| self.0.get(last));
        last.map_or(BITS_FD, |(_, bits)| *bits) / BIT_RATE
    }
}

/// Returns the period of messages whose file states no period.
pub(super) fn assumed_period(layout: &Layout) -> Span {
    let [usual, .., longest] = PERIODS;
    let is_light = |period: &Span| load(layout.messages().iter(), *period) <= LOAD_MAX;
    let is_hopeless = !is_light(&longest);
    if is_hopeless { usual } else { PERIODS.into_iter().find(is_light).unwrap_or(longest) }
}
