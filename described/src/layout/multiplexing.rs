//! Multiplexing: which signals of a message a frame carries.

use super::selection::Selection;
use super::signal::Signal;

/// True if the frame with these multiplexer numbers, by position, carries the signal at this position.
pub(super) fn carries(
    signals: &[Signal],
    signal: usize,
    number: &dyn Fn(usize) -> Option<u64>,
) -> bool {
    needs(signals, signal)
        .all(|selection| number(selection.multiplexer).is_some_and(|number| selection.has(number)))
}

/// The selections required for a signal to be carried, from its own upwards.
pub(super) fn needs(signals: &[Signal], signal: usize) -> impl Iterator<Item = &Selection> {
    let above = |signal: usize| signals.get(signal)?.carried.selection();
    std::iter::successors(above(signal), move |selection| above(selection.multiplexer))
}

/// The positions of two signals with a common bit, the first before the second.
pub(super) fn overlap(signals: &[Signal]) -> Option<(usize, usize)> {
    signals.iter().enumerate().find_map(|(second, signal)| {
        let clashes =
            |first: &usize| signals[*first].overlaps(signal) && !exclude(signals, *first, second);
        Some(((0..second).find(clashes)?, second))
    })
}

/// True if no frame carries both: they need different numbers of one multiplexer.
fn exclude(signals: &[Signal], one: usize, another: usize) -> bool {
    needs(signals, one).any(|selection| {
        let same = |other: &&Selection| other.multiplexer == selection.multiplexer;
        needs(signals, another).find(same).is_some_and(|other| !other.meets(selection))
    })
}
