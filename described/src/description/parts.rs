//! Parts that several sections have: times, and names of messages.

use crate::error::Mistake;
use crate::hint;
use crate::layout::{Layout, Message, Sender};
use crate::place::Place;
use wire::time::Span;

/// Shortest period of a message. Assumption: half the frame time of a bus of 1 Mbit/s.
pub(super) const PERIOD_S_MIN: f64 = 50e-6;

/// Longer than any run: a larger time is a typing mistake.
const TIME_S_MAX: f64 = 1e6;

pub(super) fn question(name: &str, layout: &Layout, place: &Place) -> Result<usize, Mistake> {
    let heard = |message: &&Message| message.sender == Sender::Host;
    layout.find(name).filter(|index| layout.messages()[*index].sender == Sender::Host).ok_or_else(
        || {
            let known = layout.messages().iter().filter(heard).map(|known| known.name.as_str());
            let known: Vec<&str> = known.collect();
            Mistake::new(place.clone(), format!("the device hears no message `{name}`"))
                .help(hint::proposal(name, &known))
        },
    )
}

/// Parses a time of a file.
pub(super) fn seconds(value: f64, least: f64, place: &Place) -> Result<Span, Mistake> {
    if (least..=TIME_S_MAX).contains(&value) {
        return Ok(Span::from_secs_f64(value));
    }
    Err(Mistake::new(place.clone(), format!("{value} s is not a time here"))
        .help(format!("from {least} s to {TIME_S_MAX} s")))
}
