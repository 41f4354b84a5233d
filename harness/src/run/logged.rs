//! The entries of a bus log, as what a node says.

use crate::plan::replayed::Logged;
use bus_log::{Channel, Direction, Entry, LogError, Payload};
use record::figures;
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

/// Converts a log, without error frames, in the order of the times: a logger of several channels may write one after the other.
/// `origin` says, by the time of the earliest entry, from which time on the entries count. The note says how many were earlier
/// than one before.
///
/// # Errors
///
/// When it cannot be read to its end.
pub fn logged(
    entries: impl IntoIterator<Item = Result<Entry, LogError>>,
    origin: impl FnOnce(Timestamp) -> Timestamp,
) -> Result<(Vec<Logged>, Option<String>), LogError> {
    let mut log = Vec::new();
    let (mut latest, mut earlier, mut by) = (None, 0_u64, Span::ZERO);
    let mut channels: BTreeMap<Channel, Arc<str>> = BTreeMap::new();
    for entry in entries {
        let entry = entry?;
        let what = match entry.payload {
            Payload::Frame(frame) => Transmit::Frame(frame),
            Payload::Serial(packet) => Transmit::Bytes(packet),
            Payload::Error(_) => continue,
        };
        let latest = latest.get_or_insert(entry.at);
        if entry.at < *latest {
            earlier += 1;
            by = by.max(latest.since(entry.at));
        }
        *latest = (*latest).max(entry.at);
        let channel =
            channels.entry(entry.channel).or_insert_with(|| entry.channel.as_str().into());
        let sent = entry.direction.map(|direction| direction == Direction::Tx);
        let logged = Logged { at: Span::ZERO, channel: Arc::clone(channel), what, sent };
        log.push((entry.at, logged));
    }
    log.sort_by_key(|(at, _)| *at);
    let earliest = log.first().map_or(Timestamp::ZERO, |(at, _)| *at);
    let (origin, mut last) = (origin(earliest), Span::ZERO);
    let log = log.into_iter().map(|(at, logged)| {
        // Of several at one time each is a nanosecond later than the one before, in the order of the log. The first is later
        // than the beginning of the plan, so that it belongs to the first step.
        last = at.since(origin).max(last + Span::from_nanos(1));
        Logged { at: last, ..logged }
    });
    let log = log.collect();
    let note = (earlier > 0).then(|| {
        let (entries, by) = (figures::counted(earlier, "entry", "entries"), by.as_secs_f64());
        let verb = if earlier == 1 { "is" } else { "are" };
        format!("{entries} {verb} earlier than one before, by up to {by} s: all are in the order of their times")
    });
    Ok((log, note))
}
