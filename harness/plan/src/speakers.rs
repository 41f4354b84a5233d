//! The senders on the lines of a rig: the messages that a plan can name.

use super::name::Name;
use super::quantities::{PERIOD, SIGNAL};
use described::{Layout, Message, SDO_REQUEST, Sender, Signal};

/// The name of the only device of a plan without a rig, in parameter names, in bench files and as a target of faults.
pub const DEVICE: &str = "device";

/// A quantity taken from the messages of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OfMessage<'a> {
    /// Each value of this signal, `Signal` or `Message.Signal`, in the signal's unit.
    Signal {
        /// The node that sends it.
        node: &'a str,
        /// The signal.
        name: &'a str,
    },
    /// The time between consecutive messages, s.
    Period {
        /// The node that sends it.
        node: &'a str,
        /// The message.
        name: &'a str,
    },
}

impl<'a> OfMessage<'a> {
    pub(super) fn of(name: &'a str) -> Option<Self> {
        Self::written(name).filter(|one| Name::new(one.node()).is_some())
    }

    /// The node of a name that would be well-formed if a node could be called so.
    pub(super) fn misnamed(name: &'a str) -> Option<&'a str> {
        let node = Self::written(name)?.node();
        Name::new(node).is_none().then_some(node)
    }

    fn written(name: &'a str) -> Option<Self> {
        let (first, rest) = name.split_once('.')?;
        let one = match first {
            SIGNAL => Self::Signal { node: DEVICE, name: rest },
            PERIOD => match rest.split_once('.') {
                None => Self::Period { node: DEVICE, name: rest },
                Some((node, name)) => Self::Period { node, name },
            },
            node => Self::Signal { node, name: rest },
        };
        // The line, where it is named, may have hyphens.
        let (line, rest) = one.name().split_once('.').unwrap_or(("", one.name()));
        let is_line = line.is_empty() || is_identifier(line) || Name::new(line).is_some();
        (is_line && rest.split('.').all(is_identifier)).then_some(one)
    }

    /// The node that sends it.
    pub const fn node(&self) -> &'a str {
        match self {
            Self::Signal { node, .. } | Self::Period { node, .. } => node,
        }
    }

    /// The same of a signal or message with this name.
    const fn called(self, name: &'a str) -> Self {
        match self {
            Self::Signal { node, .. } => Self::Signal { node, name },
            Self::Period { node, .. } => Self::Period { node, name },
        }
    }

    /// The signal or the message.
    pub const fn name(&self) -> &'a str {
        match self {
            Self::Signal { name, .. } | Self::Period { name, .. } => name,
        }
    }
}

/// The syntax of message and signal names in DBCs: letters, digits and `_`; some begin with a digit.
fn is_identifier(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// A node with known messages, on one line.
#[derive(Debug, Clone)]
pub struct Speaker {
    /// The node.
    pub node: String,
    /// Index of the line in the rig.
    pub line: usize,
    /// The name of the line.
    pub line_name: String,
    /// The messages of the line, as far as a file describes them.
    pub layout: Layout,
    /// Which of them this node sends.
    pub sender: Sender,
}

/// A message of a speaker, or a signal of it, by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct MessagePlace {
    /// Index of the speaker.
    pub speaker: usize,
    /// Index of the message in its layout.
    pub message: usize,
    /// Index of the signal; `None` for the message itself.
    pub signal: Option<usize>,
}

/// An unknown name: the error, and the names that exist.
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
                    if names.clone().filter(|known| known == name).count() > 1 {
                        let of = |one: &&Message| one.signals.iter().any(|one| one.name == name);
                        let each = self.messages().filter(of);
                        let each = each.map(|one| format!("{}.{name}", one.name)).collect();
                        let message = format!("several signals `{name}` in the layout of {whose}");
                        return Err((message, each));
                    }
                    Err((format!("no signal `{name}` in the layout of {whose}"), names.collect()))
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

pub(crate) fn is_canopen(speaker: &Speaker) -> bool {
    speaker.sender == Sender::Device && speaker.layout.dictionary().is_some()
}

/// The CANopen devices, each with the name of the message that carries SDO requests to it.
pub fn canopen_devices(speakers: &[Speaker]) -> impl Iterator<Item = (usize, &Speaker, String)> {
    let devices = speakers.iter().enumerate().filter(|(_, known)| is_canopen(known));
    devices.map(|(place, device)| {
        let on_line =
            speakers.iter().filter(|known| is_canopen(known) && known.line == device.line);
        let request = match on_line.count() {
            1 => SDO_REQUEST.to_owned(),
            _ => format!("{}.{SDO_REQUEST}", device.node),
        };
        (place, device, request)
    })
}

/// The description of a node in a sentence.
pub(crate) fn whose(node: &str) -> String {
    if node == DEVICE { "the device".to_owned() } else { format!("`{node}`") }
}

/// Resolves a name of a message or signal among `speakers`. `LINE.` before it selects one of several lines of the node.
///
/// # Errors
/// The error, and the names that exist.
pub fn resolve(speakers: &[Speaker], of: OfMessage<'_>) -> Result<MessagePlace, Unknown> {
    let of_node = |one: &&(usize, &Speaker)| one.1.node == of.node();
    let all: Vec<(usize, &Speaker)> = speakers.iter().enumerate().collect();
    let line = of.name().split_once('.').filter(|(line, _)| {
        all.iter().filter(of_node).any(|(_, speaker)| speaker.line_name == *line)
    });
    let name = line.map_or_else(|| of.name(), |(_, name)| name);
    let is_meant = |one: &&(usize, &Speaker)| line.is_none_or(|(line, _)| one.1.line_name == line);
    let (mut found, mut wrong): (Vec<(&Speaker, MessagePlace)>, _) = (Vec::new(), None);
    for (index, speaker) in all.iter().filter(of_node).filter(is_meant) {
        match speaker.find(of.called(name)) {
            Ok((message, signal)) => {
                // A node may have several layouts on one line.
                if found.iter().all(|(known, _)| known.line != speaker.line) {
                    found.push((speaker, MessagePlace { speaker: *index, message, signal }));
                }
            }
            Err(why) => wrong = wrong.or(Some(why)),
        }
    }
    match found[..] {
        [(_, only)] => Ok(only),
        [] => Err(wrong.unwrap_or_else(|| {
            let mut nodes: Vec<String> = speakers.iter().map(|one| one.node.clone()).collect();
            nodes.dedup();
            (format!("no node `{}` whose messages are known", of.node()), nodes)
        })),
        _ => {
            let each = found.iter().map(|(speaker, _)| format!("{}.{name}", speaker.line_name));
            Err((format!("{} sends `{name}` on several lines", whose(of.node())), each.collect()))
        }
    }
}

/// A proposal to say which of several is meant, if any of the known names ends in the name.
pub(super) fn which(of: OfMessage<'_>, known: &[impl AsRef<str>]) -> Option<String> {
    let ending = format!(".{}", of.name());
    let owner = match of {
        OfMessage::Signal { node: DEVICE, .. } => SIGNAL.to_owned(),
        OfMessage::Signal { node, .. } => node.to_owned(),
        OfMessage::Period { node: DEVICE, .. } => PERIOD.to_owned(),
        OfMessage::Period { node, .. } => format!("{PERIOD}.{node}"),
    };
    let each = known.iter().map(AsRef::as_ref).filter(|known| known.ends_with(&ending));
    let each: Vec<String> = each.map(|known| format!("`{owner}.{known}`")).collect();
    (!each.is_empty()).then(|| format!("say which: {}", each.join(" or ")))
}

/// The signal at a place; `None` for a message.
pub fn signal(speakers: &[Speaker], place: MessagePlace) -> Option<&Signal> {
    let message = speakers.get(place.speaker)?.layout.messages().get(place.message)?;
    message.signals.get(place.signal?)
}

/// The unit of a signal, or of the time between messages.
pub fn unit(speakers: &[Speaker], place: MessagePlace) -> String {
    signal(speakers, place).map_or_else(|| "s".to_owned(), unit_of)
}

/// The unit of a signal; `1` if the layout states none.
pub fn unit_of(signal: &Signal) -> String {
    if signal.unit.is_empty() { "1".to_owned() } else { signal.unit.clone() }
}
