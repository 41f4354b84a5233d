//! Effect of one fault on the frames of a bus.

use crate::link::end_id::EndId;
use crate::link::gilbert_elliott::GilbertElliott;
use plan::faults::Chance;
use plan::faults::FaultKind;
use std::collections::BTreeSet;
use wire::can::{BitRates, CanFrame, FD_BYTES_MAX, StandardId};
use wire::time::{Span, Timestamp};

/// Identifiers of frames that faults make: none belongs to a base ([`wire::base`]), nor to a message of a node on the bus.
/// The babbler's wins every arbitration.
const BABBLER: StandardId = StandardId::ZERO;
/// Identifiers that win against a base and its host.
const RIVALS: (u16, u16) = (0x001, 0x0ff);
/// Identifiers of other traffic, three in four of them with lower priority than a base.
const OTHERS: (u16, u16) = (0x200, 0x7ff);
const OTHERS_BELOW: f64 = 0.75;
/// Bits of the mean frame of other traffic: 0 to 8 bytes, equally likely, and 1.4 stuff bits, the mean over its
/// identifiers.
const MEAN_BITS: f64 = 47.0 + 8.0 * 4.0 + 1.4;

#[derive(Debug, Clone)]
pub(super) enum Effect {
    Drop(f64),
    Burst(GilbertElliott),
    Duplicate(f64),
    Disconnect,
    Delay(Span),
    /// Probability, and the waiting frame.
    Reorder(f64, Option<(EndId, CanFrame)>),
    Corrupt(f64),
    /// Period, and time of the next frame.
    Babble(Span, Timestamp),
    /// Mean time between two frames, s, and time of the next frame.
    Load(f64, Timestamp),
    BitErrors(f64),
    LoseArbitration(f64),
}

/// Fate of a frame that was complete on the bus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Passed {
    On,
    Lost,
    Twice,
    /// Received, and this frame, which was sent before it, is sent again.
    Before(CanFrame),
}

impl Effect {
    pub(super) fn of(now: Timestamp, kind: &FaultKind, rates: BitRates) -> Option<Self> {
        let share = |percent: f64| percent / 100.0;
        Some(match *kind {
            FaultKind::Drop { loss_percent } => Self::Drop(share(loss_percent)),
            FaultKind::BurstLoss { loss_percent, recover_percent, bad_percent, good_percent } => {
                let (p, r) = (loss_percent, recover_percent);
                Self::Burst(GilbertElliott::from_percent(p, r, bad_percent, good_percent))
            }
            FaultKind::Duplicate { duplicate_percent } => Self::Duplicate(share(duplicate_percent)),
            FaultKind::Disconnect { .. } => Self::Disconnect,
            FaultKind::Delay { by_s } => Self::Delay(Span::from_secs_f64(by_s)),
            FaultKind::Reorder { reorder_percent } => Self::Reorder(share(reorder_percent), None),
            FaultKind::Corrupt { corrupt_percent } => Self::Corrupt(share(corrupt_percent)),
            FaultKind::Babble { frames_per_s } => {
                Self::Babble(Span::from_secs_f64(1.0 / frames_per_s), now)
            }
            FaultKind::BusLoad { load_percent } => {
                Self::Load(MEAN_BITS / f64::from(rates.nominal) / share(load_percent), now)
            }
            FaultKind::BitErrors { bit_error_rate } => Self::BitErrors(bit_error_rate),
            FaultKind::LostArbitration { lose_percent } => {
                Self::LoseArbitration(share(lose_percent))
            }
            _ => return None,
        })
    }

    /// When the effect sends its next frame.
    pub(super) const fn next_made(&self) -> Timestamp {
        match self {
            Self::Babble(_, next) | Self::Load(_, next) => *next,
            _ => Timestamp::MAX,
        }
    }

    /// Makes the frame that is due; `taken` are the identifiers of messages.
    pub(super) fn make(&mut self, taken: &BTreeSet<StandardId>, chance: &mut Chance) -> CanFrame {
        match self {
            Self::Load(between_s, next) => {
                // Independent starts: exponentially distributed intervals.
                let wait_s = -*between_s * (1.0 - chance.uniform()).ln();
                *next += Span::from_secs_f64(wait_s).max(Span::from_nanos(1));
                let range = if chance.happens(OTHERS_BELOW) { OTHERS } else { RIVALS };
                let length = chance.below(9);
                other(range, taken, length, chance)
            }
            Self::Babble(period, next) => {
                *next += (*period).max(Span::from_nanos(1));
                CanFrame::full(BABBLER, [0; 8])
            }
            _ => CanFrame::full(BABBLER, [0; 8]),
        }
    }

    /// For how long a frame waits in its node before it waits for the bus.
    pub(super) const fn delays(&self) -> Span {
        match self {
            Self::Delay(by) => *by,
            _ => Span::ZERO,
        }
    }

    /// A frame that wins against one that is about to start.
    pub(super) fn rival(
        &mut self,
        taken: &BTreeSet<StandardId>,
        chance: &mut Chance,
    ) -> Option<CanFrame> {
        match self {
            Self::LoseArbitration(share) => {
                chance.happens(*share).then(|| other(RIVALS, taken, 8, chance))
            }
            _ => None,
        }
    }

    /// The bit of a frame that is read wrongly, counted from 1; `None` if the frame is good.
    pub(super) fn bits_until_error(
        &mut self,
        frame: &CanFrame,
        chance: &mut Chance,
    ) -> Option<u32> {
        let Self::BitErrors(rate) = self else { return None };
        let bits = frame.bits();
        // The first wrong bit: geometric distribution.
        let first = (1.0 - chance.uniform()).ln() / (1.0 - *rate).ln();
        (first < f64::from(bits)).then_some(first as u32 + 1)
    }

    /// Applies the effect to a complete frame of `from`.
    pub(super) fn pass(
        &mut self,
        from: EndId,
        frame: &mut CanFrame,
        chance: &mut Chance,
        acted: &mut u64,
    ) -> Passed {
        let passed = match self {
            Self::Drop(loss) if chance.happens(*loss) => Passed::Lost,
            Self::Burst(channel) => {
                if channel.loses(chance) {
                    Passed::Lost
                } else {
                    Passed::On
                }
            }
            Self::Disconnect => Passed::Lost,
            Self::Duplicate(share) if chance.happens(*share) => Passed::Twice,
            Self::Reorder(share, waiting) => match waiting.take_if(|(of, _)| *of == from) {
                Some((_, late)) => return Passed::Before(late),
                None if waiting.is_none() && chance.happens(*share) => {
                    *waiting = Some((from, *frame));
                    Passed::Lost
                }
                None => Passed::On,
            },
            Self::Corrupt(share) => {
                let changed = chance.happens(*share).then(|| corrupted(frame, chance)).flatten();
                if let Some(changed) = changed {
                    *frame = changed;
                    *acted += 1;
                }
                return Passed::On;
            }
            _ => Passed::On,
        };
        *acted += u64::from(passed != Passed::On);
        passed
    }

    /// Releases the waiting frame when the fault ends.
    pub(super) fn release(&mut self) -> Option<(EndId, CanFrame)> {
        match self {
            Self::Reorder(_, waiting) => waiting.take(),
            _ => None,
        }
    }
}

/// A frame of another node, with the next identifier that no message has.
fn other(
    (least, greatest): (u16, u16),
    taken: &BTreeSet<StandardId>,
    length: usize,
    chance: &mut Chance,
) -> CanFrame {
    let drawn = least + chance.below(usize::from(greatest - least) + 1) as u16;
    let data = [0x55; 8];
    // All are in range: an 11-bit identifier and at most eight bytes.
    (drawn..=greatest)
        .chain(least..drawn)
        .filter_map(StandardId::new)
        .find(|id| !taken.contains(id))
        .and_then(|id| CanFrame::new(id, data.get(..length)?))
        .unwrap_or_else(|| CanFrame::full(BABBLER, data))
}

/// The frame with one data bit inverted; `None` if it has no data.
fn corrupted(frame: &CanFrame, chance: &mut Chance) -> Option<CanFrame> {
    let mut data = [0; FD_BYTES_MAX];
    let length = frame.data().len();
    data.get_mut(..length)?.copy_from_slice(frame.data());
    let bit = chance.below(length * 8);
    *data.get_mut(..length)?.get_mut(bit / 8)? ^= 1 << (bit % 8);
    frame.with_data(&data[..length])
}
