//! Nodes whose part a log of their bus plays.

use crate::rig::{NodePart, Rig};
use crate::speakers::Speaker;
use described::{Layout, Medium, Sender};
use std::collections::BTreeSet;
use std::sync::Arc;
use wire::can::Id;
use wire::device::Transmit;
use wire::time::Span;

/// What a log has of one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Logged {
    /// When, since the log's first entry.
    pub at: Span,
    /// On which bus or line.
    pub channel: Arc<str>,
    /// What it was.
    pub what: Transmit,
}

/// What a node sends, as a log has it: when, at which of its ports, and what.
pub type Replayed = Arc<[(Span, u8, Transmit)]>;

/// The channel of a log that a line is: the one that is named, the one of the line's name, or the only one that carries
/// what the line does.
///
/// # Errors
///
/// The channels that there are, where none or several could be meant.
pub(crate) fn channel_of<'a>(
    log: &'a [Logged],
    line: &str,
    medium: Medium,
    named: Option<&str>,
) -> Result<&'a str, Vec<String>> {
    let fits = |one: &&Logged| matches!(one.what, Transmit::Frame(_)) == (medium == Medium::Can);
    let known: BTreeSet<&str> = log.iter().filter(fits).map(|one| &*one.channel).collect();
    let wanted = named.or_else(|| known.contains(line).then_some(line));
    let found = match (wanted, known.len()) {
        (Some(wanted), _) => known.get(wanted).copied(),
        (None, 1) => known.first().copied(),
        _ => None,
    };
    found.ok_or_else(|| known.into_iter().map(str::to_owned).collect())
}

/// What of `log` on `channel` is said by who sends as `sender` in `layout`; everything where no layout is known.
pub(crate) fn said_on<'a>(
    log: &'a [Logged],
    channel: &'a str,
    words: Option<(&Layout, Sender)>,
) -> impl Iterator<Item = (Span, Transmit)> + 'a {
    let ids: Option<BTreeSet<Id>> = words.map(|(layout, sender)| {
        let sent = layout.messages().iter().filter(|message| message.sender == sender);
        sent.filter_map(|message| message.can_id()).collect()
    });
    let is_said = move |what: &Transmit| match (what, &ids) {
        (Transmit::Frame(frame), Some(ids)) => ids.contains(&frame.id()),
        _ => true,
    };
    let of_channel = log.iter().filter(move |one| &*one.channel == channel);
    of_channel.filter(move |one| is_said(&one.what)).map(|one| (one.at, one.what))
}

impl Rig {
    /// The same with every node played by `log`: what a plan finds when it listens to the bench of the log. On a serial line,
    /// where a log does not say who spoke, it is the device.
    ///
    /// # Errors
    ///
    /// The line that is not in the log, and the channels that are.
    pub fn replayed_by(
        mut self,
        log: &[Logged],
        named: Option<&str>,
    ) -> Result<Self, (String, Vec<String>)> {
        let Self { lines, nodes, speakers, .. } = &mut self;
        for node in nodes {
            let mut said = Vec::new();
            for (port, line) in node.lines.iter().enumerate() {
                let Some(declared) = lines.get(*line) else { continue };
                let channel = channel_of(log, &declared.name, declared.medium, named)
                    .map_err(|known| (declared.name.clone(), known))?;
                let speaks = |one: &&Speaker| one.node == node.name && one.line == *line;
                let words = match (&node.part, speakers.iter().find(speaks)) {
                    (_, Some(speaker)) => Some((&speaker.layout, speaker.sender)),
                    (NodePart::Tester(layout, sender), None) => Some((layout, *sender)),
                    _ => None,
                };
                let is_heard = words.is_some_and(|(_, sender)| {
                    declared.medium == Medium::Can || sender == Sender::Device
                });
                let port = u8::try_from(port).unwrap_or(u8::MAX);
                let of_line = said_on(log, channel, words).filter(|_| is_heard);
                said.extend(of_line.map(|(at, what)| (at, port, what)));
            }
            said.sort_by_key(|(at, ..)| *at);
            node.part = NodePart::Replayed(said.into());
        }
        Ok(self)
    }
}
