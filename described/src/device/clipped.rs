//! Values that a device could not send, because the range of their signal ends before them.

use super::Device;
use crate::layout::Signal;

/// A signal with values beyond its range.
#[derive(Debug, Clone, Copy)]
pub struct Clipped<'a> {
    /// The name of its message.
    pub message: &'a str,
    /// The signal.
    pub signal: &'a Signal,
    /// Number of values that were sent as the nearer end of the range.
    pub count: u64,
    /// The value farthest from the range, in the signal's unit.
    pub farthest: f64,
}

impl Device {
    /// The signals of which values were clipped to the range. Values that round to one in range are not.
    pub fn clipped(&self) -> impl Iterator<Item = Clipped<'_>> {
        self.senders.iter().zip(&self.description.model.sent).flat_map(|(sending, sent)| {
            let message = &self.description.layout().messages()[sent.message];
            sending.clipped.all().into_iter().map(|(place, count, farthest)| {
                let signal = &message.signals[place];
                Clipped { message: &message.name, signal, count, farthest }
            })
        })
    }
}

/// The counts of one message: only its signals with such values.
#[derive(Debug, Clone, Default)]
pub(super) struct Counts(Vec<Count>);

#[derive(Debug, Clone)]
struct Count {
    place: usize,
    count: u64,
    farthest: f64,
    /// Distance of the farthest value from the range.
    excess: f64,
}

impl Counts {
    /// Counts a `value` of the signal at this place that is sent as `inside`.
    #[cold]
    pub(super) fn add(&mut self, place: usize, value: f64, inside: f64) {
        let excess = (value - inside).abs();
        match self.0.iter_mut().find(|known| known.place == place) {
            None => self.0.push(Count { place, count: 1, farthest: value, excess }),
            Some(known) => {
                known.count += 1;
                if excess > known.excess {
                    (known.farthest, known.excess) = (value, excess);
                }
            }
        }
    }

    /// The place, the count and the farthest value of each signal, in the order of the message.
    pub(super) fn all(&self) -> Vec<(usize, u64, f64)> {
        let all = self.0.iter().map(|known| (known.place, known.count, known.farthest));
        let mut all: Vec<_> = all.collect();
        all.sort_unstable_by_key(|(place, ..)| *place);
        all
    }
}
