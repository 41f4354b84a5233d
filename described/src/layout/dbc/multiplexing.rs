//! Which frames of a message carry a signal: plain multiplexing, and extended multiplexing with several levels and
//! ranges.

use super::syntax::{MessageLine, SignalLine, Syntax};
use std::ops::RangeInclusive;

/// The multiplexer of a signal.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Multiplexed {
    /// None: each frame carries the signal.
    Not,
    /// The signal at this position of the message's lines, with these numbers.
    By(usize, Vec<RangeInclusive<u64>>),
    /// A name that is not a multiplexer of the message, with the reason.
    ByNothing(String),
}

/// The multiplexer of each signal of the message.
///
/// In a message with one multiplexer the other signals have their numbers in their lines (`m1`), and `SG_MUL_VAL_`
/// adds to them. With several multiplexers only `SG_MUL_VAL_` assigns signals to them.
pub(super) fn multiplexed(syntax: &Syntax, message: &MessageLine) -> Vec<Multiplexed> {
    let mut multiplexers = message.signals.iter().filter(|signal| signal.multiplexes);
    let (first, second) = (multiplexers.next(), multiplexers.next());
    let all = message.signals.iter().map(|signal| match (first, second, signal.page) {
        (_, None, None) | (None, _, Some(_)) => Multiplexed::Not,
        (Some(only), None, Some(_)) if only.name == signal.name => Multiplexed::Not,
        (Some(only), None, Some(page)) => {
            let mut numbers = vec![page..=page];
            numbers.extend(ranges(syntax, message, signal, &only.name));
            by(message, &only.name, numbers)
        }
        (_, Some(_), None) if !signal.multiplexes => Multiplexed::Not,
        (_, Some(_), page) => match extended(syntax, message, signal) {
            Some(multiplexer) => {
                let mut numbers: Vec<_> = ranges(syntax, message, signal, multiplexer).collect();
                if numbers.is_empty() {
                    numbers.extend(page.map(|page| page..=page));
                }
                by(message, multiplexer, numbers)
            }
            // Unassigned. cantools treats it the same way.
            None => Multiplexed::Not,
        },
    });
    let all = all.collect();
    without_circles(message, all)
}

fn by(message: &MessageLine, name: &str, numbers: Vec<RangeInclusive<u64>>) -> Multiplexed {
    let is_it = |signal: &SignalLine| signal.name == name && signal.multiplexes;
    match message.signals.iter().position(is_it) {
        Some(place) => Multiplexed::By(place, numbers),
        None => Multiplexed::ByNothing(format!("`{name}` is no multiplexer (`M`) of the message")),
    }
}

/// The multiplexer that `SG_MUL_VAL_` names; the last one of several.
fn extended<'a>(syntax: &'a Syntax, message: &MessageLine, signal: &SignalLine) -> Option<&'a str> {
    let said = syntax.extended.get(&(message.id, signal.name.clone()))?;
    said.last().map(|(multiplexer, _)| multiplexer.as_str())
}

/// The ranges in `SG_MUL_VAL_` for the signal under that multiplexer.
fn ranges<'a>(
    syntax: &'a Syntax,
    message: &MessageLine,
    signal: &SignalLine,
    multiplexer: &'a str,
) -> impl Iterator<Item = RangeInclusive<u64>> + 'a {
    let said = syntax.extended.get(&(message.id, signal.name.clone())).into_iter().flatten();
    let of_it = said.filter(move |(name, _)| name == multiplexer);
    let ranges = of_it.flat_map(|(_, numbers)| numbers.iter());
    ranges.filter(|(first, last)| first <= last).map(|(first, last)| *first..=*last)
}

/// The multiplexers, without signals that are their own multiplexer through others.
fn without_circles(message: &MessageLine, all: Vec<Multiplexed>) -> Vec<Multiplexed> {
    let above = |place: &usize| match &all[*place] {
        Multiplexed::By(multiplexer, _) => Some(*multiplexer),
        _ => None,
    };
    let is_endless = |place: usize| {
        std::iter::successors(Some(place), above).nth(message.signals.len()).is_some()
    };
    let endless: Vec<bool> = (0..all.len()).map(is_endless).collect();
    let checked = all.iter().zip(endless).map(|(one, endless)| match endless {
        true => Multiplexed::ByNothing("its multiplexers multiplex one another".to_owned()),
        false => one.clone(),
    });
    checked.collect()
}
