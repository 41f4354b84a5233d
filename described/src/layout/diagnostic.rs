//! The frames of an ISO-TP channel as messages without signals, so that faults, periods and records can name them.

use super::message::Carrier;
use super::{Layout, Medium, Message, Sender};
use crate::isotp::IsoTp;
use wire::can::{FdFlags, Id};

/// Names of the messages.
const REQUEST: &str = "UdsRequest";
const RESPONSE: &str = "UdsResponse";
const FUNCTIONAL: &str = "UdsFunctional";

impl Layout {
    /// A CAN layout without messages.
    pub fn empty() -> Self {
        Self::new(Medium::Can, Vec::new())
    }

    /// The layout with the frames of a channel whose server is the device: `UdsRequest`, `UdsResponse` and
    /// `UdsFunctional`.
    ///
    /// # Errors
    /// With the key of the channel and a readable message, if another message has the identifier or the name.
    pub fn with_isotp(self, channel: &IsoTp) -> Result<Self, (&'static str, String)> {
        if self.medium != Medium::Can {
            return Err(("request_id", "ISO-TP is a protocol of CAN".to_owned()));
        }
        let mut messages = self.messages.to_vec();
        let request = Some((REQUEST, Sender::Host, channel.request, "request_id"));
        let response = Some((RESPONSE, Sender::Device, channel.response, "response_id"));
        let functional =
            channel.functional.map(|id| (FUNCTIONAL, Sender::Host, id, "functional_id"));
        for (name, sender, id, key) in [request, response, functional].into_iter().flatten() {
            if let Some(other) = messages.iter().find(|one| one.can_id() == Some(id)) {
                return Err((key, format!("`{}` has the same identifier", other.name)));
            }
            if messages.iter().any(|one| one.name == name) {
                return Err((key, format!("a message has the name `{name}` already")));
            }
            messages.push(message(name, sender, id, channel.fd.is_some()));
        }
        let (medium, notes) = (self.medium, self.notes.to_vec());
        Ok(Self::new(medium, messages).noting(notes))
    }

    /// The layout without messages on this channel: a DBC describes them as if each frame stood for itself.
    #[must_use]
    pub fn without_frames_of(self, channel: &IsoTp) -> Self {
        let is_of_channel =
            |id: Id| id == channel.response || channel.requests().any(|one| one == id);
        let kept = self.messages.iter().filter(|one| !one.can_id().is_some_and(is_of_channel));
        Self::new(self.medium, kept.cloned().collect()).noting(self.notes.to_vec())
    }

    /// What a tester sends beside these servers on one bus: the messages of this layout, in which it is a device, and requests
    /// to each of the servers.
    ///
    /// # Errors
    /// Two servers that are asked with one identifier in different ways.
    pub fn asking(self, servers: &[(&str, &Self)]) -> Result<Self, String> {
        let of = |layout: &Self| {
            let requests = layout.messages.iter().filter(|one| is_request(one));
            Self::new(Medium::Can, requests.cloned().collect())
        };
        let layouts: Vec<Self> = servers.iter().map(|(_, layout)| of(layout)).collect();
        let nodes = servers.iter().map(|(node, _)| *node);
        let requests = Self::of_host(&Vec::from_iter(nodes.zip(&layouts)))?;
        let is_new =
            |one: &&Message| requests.messages.iter().all(|new| new.can_id() != one.can_id());
        let mut messages: Vec<Message> = self.messages.iter().filter(is_new).cloned().collect();
        messages.extend(
            requests.messages.iter().map(|one| Message { sender: Sender::Device, ..one.clone() }),
        );
        Ok(Self::new(self.medium, messages).noting(self.notes.to_vec()))
    }

    /// Whether a client asks on its channel with this identifier.
    pub fn is_asked_by(&self, id: Id) -> bool {
        self.messages.iter().any(|one| is_request(one) && one.can_id() == Some(id))
    }
}

fn is_request(message: &Message) -> bool {
    [REQUEST, FUNCTIONAL].contains(&&*message.name)
}

fn message(name: &str, sender: Sender, id: Id, fd: bool) -> Message {
    let fd = fd.then_some(FdFlags { bit_rate_switch: true, error_state: false });
    Message {
        doc: "A frame of diagnostics (ISO-TP)".to_owned(),
        carrier: Carrier::Frame { id, length: 0, fd },
        ..Message::of_frame(name, sender, (id, 0), Vec::new())
    }
}
