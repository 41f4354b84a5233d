//! Nodes that are replayed from a log of their bus.

use crate::identifiers::Identifiers;
use crate::rig::{NodePart, Replayed, Rig, RigLine, RigNode};
use crate::speakers::Speaker;
use described::{Decoder, IsoTp, Layout, Medium, Sender};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use wire::can::Id;
use wire::device::Transmit;
use wire::time::Span;

/// An entry of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Logged {
    /// Time since the log's first entry.
    pub at: Span,
    /// The bus or line.
    pub channel: Arc<str>,
    /// The frame or bytes.
    pub what: Transmit,
    /// Whether who wrote the log had sent it; `None` if the log does not say.
    pub sent: Option<bool>,
}

/// Selects traffic on a line.
#[derive(Clone, Copy)]
pub(crate) enum Words<'a> {
    /// All traffic, if the senders are unknown.
    All,
    /// The messages of this sender in the layout, and these identifiers. On a serial line, where bytes name no sender, a log
    /// was written by who talks to the device: all is the device's that it does not say to have been sent.
    Of(&'a Layout, Sender, &'a [Id]),
    /// These entries of the log.
    These(&'a BTreeSet<usize>),
    /// No traffic.
    None,
}

/// The note on a serial line of which a log holds nothing.
pub fn of_unheard(line: &str) -> String {
    format!("the log holds nothing of the serial line {line}")
}

/// The channel of a log that is stated for a line.
pub type Named<'a> = &'a dyn Fn(&str) -> Option<&'a str>;

/// Finds the channels of lines in a log.
#[derive(Clone, Copy)]
pub(crate) struct Channels<'a, 'n> {
    pub(crate) log: &'a [Logged],
    pub(crate) named: Named<'n>,
    /// Which lines the log may be of. One of several lines of a kind is not taken for the only channel of a log: that may be
    /// another's.
    pub(crate) lines: &'a [RigLine],
}

impl<'a> Channels<'a, '_> {
    /// The traffic of a node on these lines, which are in the order of its ports; `None` for a line that is not one of the
    /// rig's own.
    ///
    /// # Errors
    /// The line that is missing in the log, and the channels that could be it.
    pub(crate) fn part<'b>(
        self,
        lines: impl Iterator<Item = Option<(&'b RigLine, Words<'b>)>>,
    ) -> Result<Replayed, (String, Vec<String>)> {
        let mut said = Vec::new();
        for (port, at) in lines.enumerate() {
            let Some((line, words)) = at else { continue };
            let channel = self.of(line).map_err(|known| (line.name.clone(), known))?;
            let port = u8::try_from(port).unwrap_or(u8::MAX);
            said.extend(said_on(self.log, channel, words).map(|(at, what)| (at, port, what)));
        }
        said.sort_by_key(|(at, ..)| *at);
        Ok(said.into())
    }

    /// The channel for a line: the channel given by name, the one with the line's name, or the only one with the line's kind
    /// of traffic, if there is no other line of that kind.
    ///
    /// # Errors
    /// The channels with that kind of traffic, if several are possible or the named one is not among them.
    fn of(self, line: &RigLine) -> Result<&'a str, Vec<String>> {
        let is_can = line.medium == Medium::Can;
        let fits = |one: &&Logged| matches!(one.what, Transmit::Frame(_)) == is_can;
        let known: BTreeSet<&str> = self.log.iter().filter(fits).map(|one| &*one.channel).collect();
        let named = (self.named)(&line.name);
        let wanted = named.or_else(|| known.contains(&*line.name).then_some(&*line.name));
        let others = self.lines.iter().filter(|one| one.name != line.name);
        let is_alone = others.filter(|one| (one.medium == Medium::Can) == is_can).count() == 0;
        let found = match wanted {
            Some(wanted) => known.get(wanted).copied(),
            None if known.len() == 1 && is_alone => known.first().copied(),
            None => None,
        };
        found.ok_or_else(|| known.into_iter().map(str::to_owned).collect())
    }
}

/// The entries of `log` on `channel` that `words` selects.
fn said_on<'a>(
    log: &'a [Logged],
    channel: &'a str,
    words: Words<'a>,
) -> impl Iterator<Item = (Span, Transmit)> + 'a {
    let of_node = match words {
        Words::Of(layout, sender, _) => Some(layout.decoder_for(sender)),
        Words::All | Words::None | Words::These(_) => None,
    };
    let is_any = matches!(words, Words::All);
    let more = if let Words::Of(_, _, more) = words { more } else { &[] };
    let is_said = move |place: usize, one: &Logged| match (&one.what, &of_node) {
        (Transmit::Frame(frame), Some(of_node)) => {
            of_node.takes(frame.id()) || more.contains(&frame.id())
        }
        (Transmit::Bytes(_), Some(of_node)) => {
            let is_of_device = of_node.sender() == Some(Sender::Device);
            one.sent.unwrap_or(false) != is_of_device
        }
        (_, None) => is_any || matches!(words, Words::These(these) if these.contains(&place)),
    };
    let of_channel = log.iter().enumerate().filter(move |(_, one)| &*one.channel == channel);
    of_channel.filter(move |(place, one)| is_said(*place, one)).map(|(_, one)| (one.at, one.what))
}

/// The identifiers of diagnostic requests on each line.
fn requests_on(lines: &[RigLine], nodes: &[RigNode]) -> Vec<Vec<Id>> {
    let on = |place: usize| {
        let asked = nodes.iter().filter(move |node| node.lines.first() == Some(&place));
        asked.filter_map(|node| node.isotp.as_ref()).flat_map(IsoTp::requests).collect()
    };
    (0..lines.len()).map(on).collect()
}

/// The messages of a line, and which of them a node sends.
fn words_of<'a>(
    speakers: &'a [Speaker],
    node: &'a RigNode,
    line: usize,
) -> Option<(&'a Layout, Sender)> {
    let mut speakers = speakers.iter();
    match (&node.part, speakers.find(|one| one.node == node.name && one.line == line)) {
        (_, Some(speaker)) => Some((&speaker.layout, speaker.sender)),
        (NodePart::Tester(layout, sender), None) => Some((layout, *sender)),
        _ => None,
    }
}

/// The entries of a log that each of several devices on one serial line said.
type Shares = BTreeMap<String, BTreeSet<usize>>;

/// The devices on this line.
fn devices_on(speakers: &[Speaker], line: usize) -> Vec<&Speaker> {
    let on_line = speakers.iter().filter(|one| one.line == line);
    on_line.filter(|one| one.sender == Sender::Device).collect()
}

/// Divides what several `devices` said on one serial line, of which a log knows only that it is no request. An answer is that of
/// the device in whose file it is, and of several with the same one that of the device that was asked last. What is no answer
/// goes with the one that follows it, or to the device that was asked.
fn shares(log: &[Logged], channel: &str, devices: &[&Speaker]) -> Shares {
    let decoders = |sender| devices.iter().map(move |one| one.layout.decoder_for(sender));
    let mut requests: Vec<_> = decoders(Sender::Host).collect();
    let mut answers: Vec<_> = decoders(Sender::Device).collect();
    let mut shares = vec![BTreeSet::new(); devices.len()];
    let (mut asked, mut waiting) = (Vec::new(), BTreeSet::new());
    for (place, one) in log.iter().enumerate().filter(|(_, one)| &*one.channel == channel) {
        let Transmit::Bytes(packet) = &one.what else { continue };
        let bytes = packet.as_slice();
        if one.sent == Some(true) {
            shares[asked.first().copied().unwrap_or(0)].append(&mut waiting);
            let is_asked = |requests: &mut Decoder| {
                let mut is_asked = false;
                requests.bytes(bytes, &mut |_| is_asked = true);
                is_asked
            };
            let now: Vec<usize> =
                (0..devices.len()).filter(|device| is_asked(&mut requests[*device])).collect();
            asked = if now.is_empty() { asked } else { now };
            answers.iter_mut().for_each(|one| one.overhear(bytes));
            continue;
        }
        waiting.insert(place);
        let mut said = Vec::new();
        for (device, answers) in answers.iter_mut().enumerate() {
            answers.bytes(bytes, &mut |_| said.push(device));
        }
        if let Some(first) = said.first() {
            let whose = said.iter().find(|device| asked.contains(device)).unwrap_or(first);
            shares[*whose].append(&mut waiting);
        }
    }
    shares[asked.first().copied().unwrap_or(0)].append(&mut waiting);
    devices.iter().map(|one| one.node.clone()).zip(shares).collect()
}

impl Rig {
    /// Whether a node sends on a serial line what the device there receives.
    pub fn is_host(&self, node: &RigNode, line: usize) -> bool {
        let line_of_rig = line.checked_sub(self.robot_lines());
        let declared = line_of_rig.and_then(|line| self.lines.get(line));
        declared.is_some_and(|line| line.medium != Medium::Can)
            && words_of(&self.speakers, node, line)
                .is_some_and(|(_, sender)| sender == Sender::Host)
    }

    /// The rig with every node replayed from `log`, as a plan finds it when it listens to the bench of the log. `named`
    /// states the channel of a line, if it is stated. A log without any bytes leaves the nodes of a serial line silent, and
    /// the rig's notes say so.
    ///
    /// # Errors
    /// The line that is missing in the log, and the channels in it.
    pub fn replayed_by(
        mut self,
        log: &[Logged],
        named: Named<'_>,
    ) -> Result<Self, (String, Vec<String>)> {
        let of_robot = self.robot_lines();
        let Self { lines, nodes, speakers, notes, foreign, .. } = &mut self;
        let channels = Channels { log, named, lines };
        let has_bytes = log.iter().any(|one| matches!(one.what, Transmit::Bytes(_)));
        let is_unheard = |line: &RigLine| {
            line.medium != Medium::Can && !has_bytes && named(&line.name).is_none()
        };
        let requests = requests_on(lines, nodes);
        let unheard = lines.iter().filter(|line| is_unheard(line));
        notes.extend(unheard.map(|line| of_unheard(&line.name)));
        for (place, line) in lines.iter().enumerate().filter(|(_, line)| line.medium == Medium::Can)
        {
            let Ok(channel) = channels.of(line) else { continue };
            let words = nodes.iter().filter_map(|node| words_of(speakers, node, place));
            let decoders: Vec<_> =
                words.map(|(layout, sender)| layout.decoder_for(sender)).collect();
            let (mut unknown, mut fd) = (Identifiers::default(), 0_u64);
            for one in log.iter().filter(|one| &*one.channel == channel) {
                let Transmit::Frame(frame) = &one.what else { continue };
                fd += u64::from(frame.fd_flags().is_some());
                let is_request = || requests.get(place).is_some_and(|of| of.contains(&frame.id()));
                if decoders.iter().all(|one| !one.takes(frame.id())) && !is_request() {
                    unknown.count(frame.id());
                    foreign.entry(line.name.clone()).or_default().push(one.at);
                }
            }
            if fd > 0 && line.data_bit_rate.is_none() {
                let frames = if fd == 1 { "frame" } else { "frames" };
                notes.push(format!(
                    "{} is a classic bus by the rig, and has {fd} CAN FD {frames} in the log",
                    line.name
                ));
            }
            if !unknown.is_empty() {
                let line = &line.name;
                notes.push(format!(
                    "frames of {line} left out that no node of the rig sends: {unknown}"
                ));
            }
        }
        let shared = lines.iter().enumerate().filter(|(_, line)| line.medium != Medium::Can);
        let shared: BTreeMap<usize, Shares> = shared
            .filter_map(|(place, line)| {
                let devices = devices_on(speakers, of_robot + place);
                let channel = channels.of(line).ok().filter(|_| devices.len() > 1)?;
                Some((of_robot + place, shares(log, channel, &devices)))
            })
            .collect();
        for node in nodes {
            let is_tester = matches!(node.part, NodePart::Tester(..));
            let words = |line: &usize| {
                let declared = lines.get(*line).filter(|line| !is_unheard(line))?;
                let words = words_of(speakers, node, *line);
                let more = requests.get(*line).filter(|_| is_tester).map_or(&[][..], Vec::as_slice);
                let share = shared.get(line).and_then(|shares| shares.get(&node.name));
                let words = match share {
                    Some(share) => Some(Words::These(share)),
                    None => words.map(|(layout, sender)| Words::Of(layout, sender, more)),
                };
                Some((declared, words.unwrap_or(Words::None)))
            };
            let said = channels.part(node.lines.iter().map(words))?;
            node.part = NodePart::Replayed(said);
        }
        self.logged = Some(log.last().map_or(Span::ZERO, |last| last.at));
        Ok(self)
    }
}
