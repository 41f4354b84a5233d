//! The six messages of the command set, each with its CAN identifier, register and length.

use crate::can::{Id, StandardId};

crate::tabled! {
    /// A message of the command set, without its content.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Message {
        /// [`Request::SetVelocity`](super::Request::SetVelocity).
        SetVelocity = row(0x101, 0x1F00, 4),
        /// [`Request::SetAcceleration`](super::Request::SetAcceleration).
        SetAcceleration = row(0x102, 0x1F08, 4),
        /// [`Request::WritePose`](super::Request::WritePose).
        WritePose = row(0x103, 0x1F10, 8),
        /// [`Request::Stop`](super::Request::Stop).
        Stop = row(0x104, 0x1F18, 1),
        /// [`Reply::Motion`](super::Reply::Motion).
        Motion = row(0x181, 0xE000, 8),
        /// [`Reply::Pose`](super::Reply::Pose).
        Pose = row(0x182, 0xE008, 8),
    }
    /// In the table, in the order of the CAN identifiers.
    fn row() -> Row
}

/// One row of the table: CAN identifier, serial register, payload bytes.
struct Row {
    can_id: StandardId,
    register: u16,
    payload_bytes: u8,
}

/// A row; does not compile if `can_id` has more than 11 bits.
const fn row(can_id: u16, register: u16, payload_bytes: u8) -> Row {
    match StandardId::new(can_id) {
        Some(can_id) => Row { can_id, register, payload_bytes },
        None => panic!("a standard identifier has 11 bits"),
    }
}

impl Message {
    /// CAN identifier of the message.
    pub const fn can_id(self) -> StandardId {
        self.row().can_id
    }

    /// Address of the message's first byte on the serial line.
    pub const fn register(self) -> u16 {
        self.row().register
    }

    /// Payload length in bytes, on either transport.
    pub const fn payload_bytes(self) -> usize {
        self.row().payload_bytes as usize
    }

    /// Sent by the base; the others are sent by the host.
    pub const fn is_reply(self) -> bool {
        matches!(self, Self::Motion | Self::Pose)
    }

    /// The message with this identifier; `None` for any other and for every extended one.
    pub fn from_can_id(id: Id) -> Option<Self> {
        Self::ALL.into_iter().find(|message| Id::Standard(message.can_id()) == id)
    }

    /// The message that begins at this register.
    pub fn from_register(register: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|message| message.register() == register)
    }
}

#[cfg(test)]
mod tests {
    use super::Message;
    use crate::can::{ExtendedId, Id};

    #[test]
    fn each_message_is_found_by_its_identifier_and_by_its_register() {
        for message in Message::ALL {
            assert_eq!(Message::from_can_id(Id::Standard(message.can_id())), Some(message));
            assert_eq!(Message::from_register(message.register()), Some(message));
            let extended = ExtendedId::new(message.can_id().as_raw().into()).unwrap();
            assert_eq!(Message::from_can_id(Id::Extended(extended)), None);
        }
        assert_eq!(Message::from_register(0x1F01), None);
    }

    #[test]
    fn no_two_registers_overlap() {
        for (index, one) in Message::ALL.into_iter().enumerate() {
            let end = usize::from(one.register()) + one.payload_bytes();
            for other in &Message::ALL[index + 1..] {
                assert!(end <= usize::from(other.register()), "{one:?} runs into {other:?}");
            }
        }
    }
}
