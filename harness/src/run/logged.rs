//! The entries of a bus log, as what a node says.

use crate::plan::replayed::Logged;
use bus_log::{Channel, Direction, Entry, LogError, Payload};
use record::figures;
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::device::Transmit;
use wire::time::Span;

/// Converts a log, from its first entry on, without error frames. An entry that is earlier than the one before it counts
/// as of that time; the note says how many there are.
///
/// # Errors
///
/// When it cannot be read to its end.
pub fn logged(
    entries: impl IntoIterator<Item = Result<Entry, LogError>>,
) -> Result<(Vec<Logged>, Option<String>), LogError> {
    let mut log = Vec::new();
    let (mut origin, mut latest, mut last) = (None, Span::ZERO, Span::ZERO);
    let (mut earlier, mut by) = (0_u64, Span::ZERO);
    let mut channels: BTreeMap<Channel, Arc<str>> = BTreeMap::new();
    for entry in entries {
        let entry = entry?;
        let what = match entry.payload {
            Payload::Frame(frame) => Transmit::Frame(frame),
            Payload::Serial(packet) => Transmit::Bytes(packet),
            Payload::Error(_) => continue,
        };
        let at = entry.at.since(*origin.get_or_insert(entry.at));
        if at < latest {
            earlier += 1;
            by = by.max(latest - at);
        }
        latest = latest.max(at);
        // The order of the log is kept: of several at one time each is a nanosecond later than the one before. The first is
        // later than the beginning of the plan, so that it belongs to the first step.
        last = at.max(last + Span::from_nanos(1));
        let channel =
            channels.entry(entry.channel).or_insert_with(|| entry.channel.as_str().into());
        let sent = entry.direction.map(|direction| direction == Direction::Tx);
        log.push(Logged { at: last, channel: Arc::clone(channel), what, sent });
    }
    let note = (earlier > 0).then(|| {
        let (entries, by) = (figures::counted(earlier, "entry", "entries"), by.as_secs_f64());
        let verb = if earlier == 1 { "is" } else { "are" };
        format!(
            "{entries} {verb} earlier than one before, by up to {by} s: they count as of its time"
        )
    });
    Ok((log, note))
}
