//! A faulty CAN bus: frames of unwanted nodes, bit errors, and frames that get lost in a controller.

use super::CanBus;
use super::confinement::ErrorState;
use super::effect::{Effect, Passed};
use super::nodes::{Nodes, StateChange};
use crate::link::end_id::EndId;
use emulators::fault::{Switch, Switches};
use plan::faults::Chance;
use plan::faults::FaultKind;
use std::collections::BTreeSet;
use wire::can::{CanFrame, Id, StandardId};
use wire::time::{Span, Timestamp};

/// Most delayed frames; more are dropped and counted.
pub(crate) const HELD_MAX: usize = 256;
/// Most frames of other nodes that wait for the bus; the rest wait in their nodes.
const STRANGERS_WAITING_MAX: usize = 8;
/// After a destroyed bit: error flag (6), delimiter (8) and intermission (3). Flags of several nodes can follow each
/// other and take up to 6 bits more (ISO 11898-1); here they coincide.
const ERROR_FRAME_BITS: i64 = 6 + 8 + 3;
/// Waiting time of an error-passive node after its own frame (ISO 11898-1, suspend transmission).
const SUSPEND_BITS: i64 = 8;

#[derive(Debug, Clone)]
pub(super) struct Faulty {
    /// How many frames of a [stranger](EndId::STRANGER) wait.
    strangers_waiting: usize,
    layers: Switches<Layer, Chance>,
    nodes: Nodes,
    /// The frame on the bus will be destroyed.
    destroyed: bool,
    last_sender: Option<EndId>,
    /// End of the last frame.
    free_since: Timestamp,
    /// Delayed frames, and when each begins to wait for the bus.
    held: Vec<(Timestamp, EndId, CanFrame)>,
    /// Frames that are sent once more: no fault of a controller strikes them again.
    again: Vec<(EndId, CanFrame)>,
}

#[derive(Debug, Clone)]
struct Layer {
    /// Sender of the struck frames; `None` for all.
    from: Option<EndId>,
    /// Identifier of the struck frames; `None` for all.
    only: Option<Id>,
    /// The only receiver that loses what is lost; `None` for all.
    at: Option<EndId>,
    effect: Effect,
}

/// The nodes that lose a frame which the others receive, one bit each.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Missed(u64);

impl Missed {
    fn add(&mut self, node: EndId) {
        self.0 |= 1_u64.checked_shl(node.0.into()).unwrap_or(0);
    }

    pub(super) fn has(self, node: EndId) -> bool {
        self.0.checked_shr(node.0.into()).is_some_and(|nodes| nodes & 1 == 1)
    }
}

impl CanBus {
    /// Begins the fault `number`: it strikes frames of `from`, only those with the given identifier if there is one. What it
    /// loses, `at` alone loses if that is given. `nodes` are the nodes that count errors; frames that a fault makes are from `EndId::STRANGER`. Returns `false`, with
    /// nothing done, for a kind that no bus has.
    pub fn begin_fault(
        &mut self,
        now: Timestamp,
        fault: (usize, &FaultKind, Chance),
        (from, at, only): (Option<EndId>, Option<EndId>, Option<Id>),
        nodes: &[EndId],
    ) -> bool {
        let (number, kind, chance) = fault;
        let Some(effect) = Effect::of(now, kind, self.rates) else { return false };
        let (idle_since, bit) = (self.on_bus.is_none().then_some(now), self.rates.bit());
        let faulty = self.faulty.get_or_insert_with(|| {
            Box::new(Faulty {
                strangers_waiting: self.waiting.count(EndId::STRANGER),
                layers: Switches::default(),
                nodes: Nodes::new(nodes, idle_since, bit),
                destroyed: false,
                last_sender: None,
                free_since: now,
                held: Vec::new(),
                again: Vec::new(),
            })
        });
        faulty.layers.switch_on(number, Layer { from, only, at, effect }, chance);
        true
    }

    /// Ends the fault of this number; returns how many frames it struck or made. Error counters keep their values.
    pub fn end_fault(&mut self, now: Timestamp, number: usize) -> u64 {
        let Some(faulty) = &mut self.faulty else { return 0 };
        let layers = faulty.layers.numbered(number);
        // No later frame will come that they could wait for.
        let left = Vec::from_iter(layers.filter_map(|layer| layer.fault.effect.release()));
        let acted = faulty.layers.switch_off(number).map_or(0, |(acted, _)| acted);
        for (from, frame) in left {
            self.send_again(from, frame);
            if self.on_bus.is_none() {
                self.arbitrate(now);
            }
        }
        acted
    }

    /// Sends a frame that was on the bus already once more, as soon as the bus is free for it.
    fn send_again(&mut self, from: EndId, frame: CanFrame) {
        let Some(faulty) = &mut self.faulty else { return };
        faulty.again.push((from, frame));
        self.waiting.push_again(from, frame);
    }

    /// Takes a frame that a fault delays, and says so.
    pub(super) fn is_delayed(&mut self, now: Timestamp, from: EndId, frame: &CanFrame) -> bool {
        let Some(faulty) = &mut self.faulty else { return false };
        let mut by = Span::ZERO;
        for Switch { fault, acted, .. } in faulty.layers_of(from, frame) {
            let more = fault.effect.delays();
            *acted += u64::from(more > Span::ZERO);
            by += more;
        }
        if by > Span::ZERO {
            if faulty.held.len() < HELD_MAX {
                faulty.held.push((now + by, from, *frame));
            } else {
                self.dropped += 1;
            }
        }
        by > Span::ZERO
    }

    /// Draws anew which nodes lose a frame of `from` that has come through.
    pub fn lose(&mut self, from: EndId, frame: &CanFrame) {
        self.missed = Missed::default();
        let Some(faulty) = &mut self.faulty else { return };
        for Switch { fault, chance, acted, .. } in faulty.layers_of(from, frame) {
            let Some(node) = fault.at else { continue };
            if fault.effect.pass(from, &mut frame.clone(), chance, acted) == Passed::Lost {
                self.missed.add(node);
            }
        }
    }

    /// Whether a fault strikes the bus.
    pub fn is_struck(&self) -> bool {
        self.faulty.as_ref().is_some_and(|faulty| faulty.layers.iter().next().is_some())
    }

    /// Whether a change of a node's error state has not been taken yet.
    #[inline]
    pub fn has_state_change(&self) -> bool {
        self.faulty.as_ref().is_some_and(|faulty| faulty.nodes.has_change())
    }

    /// Takes the next change of a node's error state.
    pub fn state_change(&mut self) -> Option<StateChange> {
        self.faulty.as_mut()?.nodes.change()
    }

    /// Time of the next event other than the end of the frame on the bus.
    pub(super) fn next_faulty(&self) -> Timestamp {
        let Some(faulty) = &self.faulty else { return Timestamp::MAX };
        let made = faulty.layers.iter().map(|layer| layer.fault.effect.next_made());
        let held = faulty.held.iter().map(|(at, ..)| *at);
        made.chain(held).min().unwrap_or(Timestamp::MAX).min(faulty.nodes.recovers_at())
    }

    /// Takes a frame that is complete by `now`, on a bus with faults.
    #[cold]
    pub(super) fn arrived_faulty(&mut self, now: Timestamp) -> Option<(EndId, CanFrame)> {
        loop {
            let through_at = self.on_bus.as_ref().map_or(Timestamp::MAX, |(at, ..)| *at);
            let next = through_at.min(self.next_faulty());
            if next > now {
                return None;
            }
            let faulty = self.faulty.as_mut()?;
            if faulty.nodes.recovers_at() == next {
                faulty.nodes.idle_until(next);
                continue;
            }
            if let Some(place) = faulty.held.iter().position(|(at, ..)| *at == next) {
                let (_, from, frame) = faulty.held.remove(place);
                match self.may_send(next, from) {
                    true => self.wait(next, from, frame),
                    false => self.dropped += 1,
                }
                continue;
            }
            if let Some(layer) =
                faulty.layers.iter_mut().find(|layer| layer.fault.effect.next_made() == next)
            {
                let frame = layer.fault.effect.make(&self.taken, &mut layer.chance);
                // The babbler has one mailbox, and all others together have few.
                let waits = faulty.strangers_waiting >= STRANGERS_WAITING_MAX
                    || self.waiting.has(EndId::STRANGER, frame.id());
                if !waits {
                    layer.acted += 1;
                    self.send(next, EndId::STRANGER, frame);
                }
                continue;
            }
            let (at, from, frame) = self.on_bus.take()?;
            let through = self.settle(at, from, frame);
            self.arbitrate(at);
            if through.is_some() {
                return through;
            }
        }
    }

    /// What of a frame that was on the bus until `at` is received.
    fn settle(&mut self, at: Timestamp, from: EndId, frame: CanFrame) -> Option<(EndId, CanFrame)> {
        let faulty = self.faulty.as_mut()?;
        (faulty.last_sender, faulty.free_since) = (Some(from), at);
        let destroyed = std::mem::take(&mut faulty.destroyed);
        faulty.nodes.count(from, destroyed);
        if destroyed {
            if faulty.nodes.state(from) == ErrorState::Off {
                self.dropped += self.waiting.forget(from) as u64 + 1;
                faulty.again.retain(|(node, _)| *node != from);
            } else {
                // The node retries before its later frames.
                self.waiting.push_again(from, frame);
            }
            return None;
        }
        if from == EndId::STRANGER {
            return Some((from, frame));
        }
        // Other nodes on the bus acknowledge it (assumption), so it counts as sent.
        if faulty.nodes.nobody_hears(from) {
            self.dropped += 1;
            return None;
        }
        if let Some(place) = faulty.again.iter().position(|one| *one == (from, frame)) {
            faulty.again.remove(place);
            return Some((from, frame));
        }
        let (mut passing, mut again) = (frame, Vec::new());
        for layer in faulty.layers.iter_mut().filter(|layer| layer.fault.strikes(from, &frame)) {
            let Switch { fault, chance, acted, .. } = layer;
            match fault.effect.pass(from, &mut passing, chance, acted) {
                Passed::On => {}
                Passed::Lost => match fault.at {
                    Some(node) => self.missed.add(node),
                    None => return None,
                },
                Passed::Twice => again.push(passing),
                Passed::Before(late) => again.push(late),
            }
        }
        again.into_iter().for_each(|frame| self.send_again(from, frame));
        Some((from, passing))
    }
}

impl Layer {
    fn strikes(&self, from: EndId, frame: &CanFrame) -> bool {
        self.from.as_ref().is_none_or(|of| *of == from)
            && self.at != Some(from)
            && self.only.is_none_or(|only| only == frame.id())
    }
}

impl CanBus {
    /// Whether a node may send, on a bus with faults.
    pub(super) fn may_send(&mut self, now: Timestamp, from: EndId) -> bool {
        let Some(faulty) = &mut self.faulty else { return true };
        faulty.nodes.idle_until(now);
        faulty.nodes.state(from) != ErrorState::Off
    }

    /// Selects the next sender, on a bus with faults.
    #[cold]
    pub(super) fn arbitrate_faulty(&mut self, now: Timestamp) {
        let (rates, bit) = (self.rates, self.rates.bit());
        let Some(faulty) = &mut self.faulty else { return };
        faulty.nodes.idle_until(now);
        let suspended = |node: EndId| {
            faulty.last_sender == Some(node)
                && faulty.nodes.state(node) == ErrorState::Passive
                && now - faulty.free_since < bit * SUSPEND_BITS
        };
        if self.waiting.len() == 0 {
            faulty.nodes.idle_from(now);
            return;
        }
        let at_once = self.waiting.first(|node| !suspended(node));
        let place = at_once.unwrap_or(0);
        let wait = if at_once.is_some() { Span::ZERO } else { bit * SUSPEND_BITS };
        faulty.nodes.busy();
        let (from, frame) = self.waiting.at(place);
        if let Some(rival) = faulty.rival(&self.taken, from, &frame) {
            self.on_bus = Some((now + wait + rival.duration(rates), EndId::STRANGER, rival));
            return;
        }
        self.waiting.take(place);
        faulty.strangers_waiting -= usize::from(from == EndId::STRANGER);
        let bits = faulty.bits_until_error(from, &frame);
        faulty.destroyed = bits.is_some();
        let time = match bits {
            Some(bits) => frame.time_of(bits, rates) + bit * ERROR_FRAME_BITS,
            None => frame.duration(rates),
        };
        self.on_bus = Some((now + wait + time, from, frame));
    }
}

impl Faulty {
    /// A frame of this node waits from now on.
    pub(super) fn sent(&mut self, from: EndId) {
        self.strangers_waiting += usize::from(from == EndId::STRANGER);
    }

    /// The layers that strike this frame of a node.
    fn layers_of(
        &mut self,
        node: EndId,
        frame: &CanFrame,
    ) -> impl Iterator<Item = &mut Switch<Layer, Chance>> {
        let none = node == EndId::STRANGER;
        self.layers.iter_mut().filter(move |layer| !none && layer.fault.strikes(node, frame))
    }

    /// A frame of another node that wins against this one of `from`.
    fn rival(
        &mut self,
        taken: &BTreeSet<StandardId>,
        from: EndId,
        frame: &CanFrame,
    ) -> Option<CanFrame> {
        self.layers_of(from, frame).find_map(|Switch { fault, chance, acted, .. }| {
            let rival = fault.effect.rival(taken, chance);
            *acted += u64::from(rival.is_some());
            rival
        })
    }

    /// Number of bits after which the frame is destroyed; `None` if it is not.
    fn bits_until_error(&mut self, from: EndId, frame: &CanFrame) -> Option<u32> {
        self.layers_of(from, frame).find_map(|Switch { fault, chance, acted, .. }| {
            let bits = fault.effect.bits_until_error(frame, chance);
            *acted += u64::from(bits.is_some());
            bits
        })
    }
}

#[cfg(test)]
mod tests;
