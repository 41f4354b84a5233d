//! Who says what on the lines of a rig: the messages that a plan can name.

use super::quantity::OfMessage;
use described::{Layout, Message, Sender, Signal};

/// The name of the only device of a plan that names no rig: in names of parameters, in bench files and as the target of
/// faults.
pub const DEVICE: &str = "device";

/// A node of which messages are known, on one line.
#[derive(Debug, Clone)]
pub struct Speaker {
    /// The node.
    pub node: String,
    /// The line, by its place in the rig.
    pub line: usize,
    /// Messages of the line, as far as a file has them.
    pub layout: Layout,
    /// Which of them are this node's.
    pub sender: Sender,
}

/// A signal of a message of a speaker, or the message, by their places.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct MessagePlace {
    /// Which speaker.
    pub speaker: usize,
    /// Which message of its layout.
    pub message: usize,
    /// Which signal of it; none where the message itself is meant.
    pub signal: Option<usize>,
}

/// Why a name leads nowhere: what is wrong, and the names that there are.
pub type Unknown = (String, Vec<String>);

impl Speaker {
    /// The messages that it sends.
    pub fn messages(&self) -> impl Iterator<Item = &Message> + Clone {
        self.layout.messages().iter().filter(|message| message.sender == self.sender)
    }

    fn is_sent(&self, message: usize) -> bool {
        self.layout.messages().get(message).is_some_and(|one| one.sender == self.sender)
    }

    fn find(&self, of: OfMessage<'_>) -> Result<(usize, Option<usize>), Unknown> {
        let whose = whose(&self.node);
        match of {
            OfMessage::Signal { name, .. } => match self.layout.sent_signal(self.sender, name) {
                Some((message, signal)) => Ok((message, Some(signal))),
                None if self.layout.signal(name).is_some() => Err((
                    format!("`{name}` is sent to {whose}, and not by it"),
                    self.messages()
                        .flat_map(|one| &one.signals)
                        .map(|one| one.name.clone())
                        .collect(),
                )),
                None => {
                    let whole = name.contains('.');
                    let names = self.messages().flat_map(|one| {
                        let named = move |signal: &Signal| match whole {
                            true => format!("{}.{}", one.name, signal.name),
                            false => signal.name.clone(),
                        };
                        one.signals.iter().map(named)
                    });
                    let several = names.clone().filter(|known| known == name).count() > 1;
                    let what = if several { "several signals" } else { "no signal" };
                    Err((format!("{what} `{name}` in the layout of {whose}"), names.collect()))
                }
            },
            OfMessage::Period { name, .. } => {
                let place = self.layout.find(name).filter(|place| self.is_sent(*place));
                place.map(|message| (message, None)).ok_or_else(|| {
                    (
                        format!("no message `{name}` that {whose} sends"),
                        self.messages().map(|one| one.name.clone()).collect(),
                    )
                })
            }
        }
    }
}

/// A node as a sentence names it.
pub(crate) fn whose(node: &str) -> String {
    if node == DEVICE { "the device".to_owned() } else { format!("`{node}`") }
}

/// What a name of messages leads to among `speakers`.
///
/// # Errors
///
/// What is wrong with the name, and which there are.
pub fn resolve(speakers: &[Speaker], of: OfMessage<'_>) -> Result<MessagePlace, Unknown> {
    let mut wrong = None;
    for (index, speaker) in speakers.iter().enumerate() {
        if speaker.node != of.node() {
            continue;
        }
        match speaker.find(of) {
            Ok((message, signal)) => return Ok(MessagePlace { speaker: index, message, signal }),
            Err(why) => wrong = wrong.or(Some(why)),
        }
    }
    Err(wrong.unwrap_or_else(|| {
        let mut nodes: Vec<String> = speakers.iter().map(|one| one.node.clone()).collect();
        nodes.dedup();
        (format!("no node `{}` whose messages are known", of.node()), nodes)
    }))
}

/// The signal at a place; none where a message is meant.
pub fn signal(speakers: &[Speaker], place: MessagePlace) -> Option<&Signal> {
    let message = speakers.get(place.speaker)?.layout.messages().get(place.message)?;
    message.signals.get(place.signal?)
}

/// The unit of a signal, or of a time between messages.
pub fn unit(speakers: &[Speaker], place: MessagePlace) -> String {
    signal(speakers, place).map_or_else(|| "s".to_owned(), unit_of)
}

/// A plain number is in `1`, where a layout leaves the unit out.
pub fn unit_of(signal: &Signal) -> String {
    if signal.unit.is_empty() { "1".to_owned() } else { signal.unit.clone() }
}
