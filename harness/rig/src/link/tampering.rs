//! Strikes one message of a node on its way to the line: as a whole, or its counter, its checksum or one of its
//! signals. Everything else passes unchanged.

use crate::link::end_id::EndId;
use described::{Layout, Message, Sender};
use emulators::fault::Switches;
use plan::faults::{Chance, FaultKind};
use wire::device::Transmit;

/// Target of a fault: a message of a layout, or one of its signals.
#[derive(Debug, Clone)]
pub struct Struck {
    pub layout: Layout,
    pub sender: Sender,
    pub message: usize,
    pub signal: Option<usize>,
}

#[derive(Debug, Clone, Default)]
pub struct Tampering {
    layers: Switches<Layer, Chance>,
}

#[derive(Debug, Clone)]
struct Layer {
    from: EndId,
    struck: Struck,
    effect: Effect,
}

#[derive(Debug, Clone)]
enum Effect {
    /// The message as it was when the fault began, or the first one after that.
    Frozen(Option<Transmit>),
    StuckCounter(Option<u64>),
    CounterAhead(u64),
    WrongChecksum(f64),
    StuckSignal(Option<f64>),
    Offset(f64),
    Value(f64),
}

impl Tampering {
    /// Begins the fault of this number on a message of `from`; a kind that no message has does nothing.
    pub fn begin(
        &mut self,
        (number, kind, chance): (usize, &FaultKind, Chance),
        from: EndId,
        struck: Struck,
    ) {
        if let Some(effect) = Effect::of(kind, &struck) {
            self.layers.switch_on(number, Layer { from, struck, effect }, chance);
        }
    }

    pub fn end(&mut self, number: usize) -> u64 {
        self.layers.switch_off(number).map_or(0, |(acted, _)| acted)
    }

    #[inline]
    pub const fn is_empty(&self) -> bool {
        self.layers.is_empty()
    }

    /// Changes what `from` sends if a fault strikes it.
    #[inline]
    pub fn pass(&mut self, from: EndId, what: &mut Transmit) {
        if !self.layers.is_empty() {
            self.change(from, what);
        }
    }

    #[cold]
    fn change(&mut self, from: EndId, what: &mut Transmit) {
        for layer in self.layers.iter_mut().filter(|layer| layer.fault.from == from) {
            let Layer { struck, effect, .. } = &mut layer.fault;
            let Struck { layout, sender, message, signal } = struck;
            if !layout.is_message(*message, *sender, what) {
                continue;
            }
            let of = &layout.messages()[*message];
            let changed = effect.change(what, (of, *signal), &mut layer.chance);
            if let Some(changed) = changed.filter(|changed| changed != what) {
                *what = changed;
                layer.acted += 1;
            }
        }
    }
}

impl Effect {
    fn of(kind: &FaultKind, struck: &Struck) -> Option<Self> {
        Some(match *kind {
            FaultKind::FrozenMessage { .. } => Self::Frozen(None),
            FaultKind::StuckCounter { .. } => Self::StuckCounter(None),
            FaultKind::CounterJump { ahead } => Self::CounterAhead(ahead as u64),
            FaultKind::WrongChecksum { wrong_percent } => {
                Self::WrongChecksum(wrong_percent / 100.0)
            }
            FaultKind::StuckSignal { .. } => Self::StuckSignal(None),
            FaultKind::SignalOffset { range_percent } => {
                let message = struck.layout.messages().get(struck.message)?;
                let signal = message.signals.get(struck.signal?)?;
                Self::Offset(range_percent / 100.0 * (signal.maximum - signal.minimum))
            }
            FaultKind::SignalValue { value } => Self::Value(value),
            _ => return None,
        })
    }

    fn change(
        &mut self,
        what: &Transmit,
        (message, signal): (&Message, Option<usize>),
        chance: &mut Chance,
    ) -> Option<Transmit> {
        match self {
            Self::Frozen(kept) => Some(*kept.get_or_insert(*what)),
            Self::StuckCounter(kept) => {
                let number = match *kept {
                    Some(number) => number,
                    None => *kept.insert(message.count(what)?),
                };
                message.with_count(what, number)
            }
            Self::CounterAhead(by) => message.with_count_ahead(what, *by),
            Self::WrongChecksum(share) => {
                chance.happens(*share).then(|| message.with_wrong_checksum(what)).flatten()
            }
            Self::StuckSignal(kept) => {
                let value = match *kept {
                    Some(value) => value,
                    None => *kept.insert(message.value(what, signal?)?),
                };
                message.with_value(what, signal?, value)
            }
            Self::Offset(by) => {
                let value = message.value(what, signal?)?;
                message.with_value(what, signal?, value + *by)
            }
            Self::Value(value) => message.with_value(what, signal?, *value),
        }
    }
}
