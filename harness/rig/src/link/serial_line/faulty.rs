//! A faulty serial line: layers that bytes pass before they are on the line.

use super::SerialLine;
use super::uart;
use crate::link::gilbert_elliott::GilbertElliott;
use emulators::fault::{Switch, Switches};
use plan::faults::Chance;
use plan::faults::FaultKind;
use wire::packet::{BYTES_MAX, Packet};
use wire::time::{Span, Timestamp};

/// Most bytes that one packet can become: each fault that inserts bytes can double it.
const GROWN_MAX: usize = 16 * BYTES_MAX;
/// Bits of a byte of 8N1.
const BITS_PER_BYTE: usize = 10;

/// Faults of a line, in the order in which bytes pass them.
pub(super) type Faulty = Switches<Effect, Chance>;

#[derive(Debug, Clone, Copy)]
pub(super) enum Effect {
    Drop(f64),
    Burst(GilbertElliott),
    Duplicate(f64),
    Disconnect,
    /// Until this time.
    Stall(Timestamp),
    Flip(f64),
    Insert(f64),
    /// Number of bits that the sender sends in the time of one.
    Drift(f64),
    Slip(f64),
    Repeat(f64),
    Split(f64, Span),
}

impl SerialLine {
    /// Begins the fault `number` of the line. Returns `false`, with nothing done, for a kind that no serial line has.
    pub fn begin_fault(
        &mut self,
        now: Timestamp,
        number: usize,
        kind: &FaultKind,
        chance: Chance,
    ) -> bool {
        let Some(effect) = Effect::of(now, kind) else { return false };
        if let Effect::Stall(until) = effect {
            // By then the packets under way wait in a buffer.
            self.under_way.iter_mut().for_each(|(at, _)| *at = until.max(*at));
        }
        let faulty = self.faulty.get_or_insert_default();
        if let (Some(stall), Effect::Stall(_)) = (faulty.switch_on(number, effect, chance), effect)
        {
            stall.acted = self.under_way.len() as u64;
        }
        true
    }

    /// Ends the fault of this number; returns its count: bytes, or packets for [`FaultKind::Stall`],
    /// [`FaultKind::FramingSlip`], [`FaultKind::Repeat`] and [`FaultKind::Split`].
    pub fn end_fault(&mut self, number: usize) -> u64 {
        let Some(faulty) = &mut self.faulty else { return 0 };
        let ended = faulty.switch_off(number);
        if faulty.is_empty() {
            self.faulty = None;
        }
        ended.map_or(0, |(acted, _)| acted)
    }

    /// Sends a packet through the layers.
    #[cold]
    pub(super) fn send_faulty(&mut self, now: Timestamp, packet: Packet) {
        let Some(faulty) = &mut self.faulty else { return };
        let mut bytes = packet.as_slice().to_vec();
        let (mut not_before, mut rate) = (now, 1.0);
        let (mut cut, mut late) = (usize::MAX, Span::ZERO);
        for layer in faulty.iter_mut() {
            match layer.fault {
                Effect::Stall(until) => {
                    not_before = not_before.max(until);
                    layer.acted += 1;
                }
                Effect::Drift(drift) => rate *= drift,
                Effect::Split(share, by) if bytes.len() > 1 && layer.chance.happens(share) => {
                    (cut, late) = (1 + layer.chance.below(bytes.len() - 1), by);
                    layer.acted += 1;
                }
                _ => {}
            }
            pass(layer, &mut bytes);
        }
        let rest = bytes.split_off(cut.min(bytes.len()));
        // Lost bytes have taken their time on the line, and so do inserted ones.
        let on_line = |bytes| Span::from_secs_f64(self.time_for(bytes).as_secs_f64() / rate);
        let last = self.busy_until.max(now) + on_line(packet.len().max(bytes.len() + rest.len()));
        let first = last - on_line(rest.len());
        self.busy_until = last;
        for (at, part) in [(first, bytes), (last + late, rest)] {
            for packet in part.chunks(BYTES_MAX).filter_map(Packet::from_slice) {
                self.queue(at.max(not_before), packet);
            }
        }
    }
}

/// Passes bytes through a layer.
fn pass(layer: &mut Switch<Effect, Chance>, bytes: &mut Vec<u8>) {
    let Switch { fault: effect, chance, acted, .. } = layer;
    match effect {
        Effect::Drop(loss) => thin(bytes, acted, || chance.happens(*loss)),
        Effect::Burst(channel) => thin(bytes, acted, || channel.loses(chance)),
        Effect::Disconnect => thin(bytes, acted, || true),
        Effect::Duplicate(share) => {
            grow(bytes, acted, |byte| chance.happens(*share).then_some(byte))
        }
        Effect::Insert(share) => {
            grow(bytes, acted, |_| chance.happens(*share).then(|| chance.below(256) as u8));
        }
        Effect::Flip(share) => {
            for byte in bytes {
                if chance.happens(*share) {
                    *byte ^= 1 << chance.below(8);
                    *acted += 1;
                }
            }
        }
        Effect::Drift(rate) => reread(bytes, acted, |sent| uart::read(sent, *rate, 0)),
        Effect::Slip(share) => {
            if chance.happens(*share) {
                let from = 1 + chance.below(BITS_PER_BYTE - 1);
                reread(bytes, acted, |sent| uart::read(sent, 1.0, from));
            }
        }
        Effect::Repeat(share) => {
            if 2 * bytes.len() <= GROWN_MAX && chance.happens(*share) {
                bytes.extend_from_within(..);
                *acted += 1;
            }
        }
        Effect::Stall(_) | Effect::Split(..) => {}
    }
}

fn thin(bytes: &mut Vec<u8>, acted: &mut u64, mut lost: impl FnMut() -> bool) {
    let before = bytes.len();
    bytes.retain(|_| !lost());
    *acted += (before - bytes.len()) as u64;
}

/// Inserts before each byte the one that `more` returns for it.
fn grow(bytes: &mut Vec<u8>, acted: &mut u64, mut more: impl FnMut(u8) -> Option<u8>) {
    let mut grown = Vec::with_capacity(bytes.len());
    for byte in bytes.iter().copied() {
        if grown.len() + 2 <= GROWN_MAX
            && let Some(extra) = more(byte)
        {
            grown.push(extra);
            *acted += 1;
        }
        grown.push(byte);
    }
    grown.truncate(GROWN_MAX);
    *bytes = grown;
}

/// Counts packets that are read differently than sent.
fn reread(bytes: &mut Vec<u8>, acted: &mut u64, read: impl Fn(&[u8]) -> Packet) {
    let heard: Vec<u8> =
        bytes.chunks(BYTES_MAX).flat_map(|sent| read(sent).as_slice().to_vec()).collect();
    *acted += u64::from(heard != *bytes);
    *bytes = heard;
}

impl Effect {
    fn of(now: Timestamp, kind: &FaultKind) -> Option<Self> {
        let share = |percent: f64| percent / 100.0;
        Some(match *kind {
            FaultKind::Drop { loss_percent } => Self::Drop(share(loss_percent)),
            FaultKind::BurstLoss { loss_percent, recover_percent, bad_percent, good_percent } => {
                let (p, r) = (loss_percent, recover_percent);
                Self::Burst(GilbertElliott::from_percent(p, r, bad_percent, good_percent))
            }
            FaultKind::Duplicate { duplicate_percent } => Self::Duplicate(share(duplicate_percent)),
            FaultKind::Disconnect { .. } => Self::Disconnect,
            FaultKind::Stall { for_s } => Self::Stall(now + Span::from_secs_f64(for_s)),
            FaultKind::Flip { flip_percent } => Self::Flip(share(flip_percent)),
            FaultKind::Insert { insert_percent } => Self::Insert(share(insert_percent)),
            FaultKind::BaudDrift { drift_percent } => Self::Drift(1.0 + share(drift_percent)),
            FaultKind::FramingSlip { slip_percent } => Self::Slip(share(slip_percent)),
            FaultKind::Repeat { repeat_percent } => Self::Repeat(share(repeat_percent)),
            FaultKind::Split { split_percent, late_s } => {
                Self::Split(share(split_percent), Span::from_secs_f64(late_s))
            }
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests;
