//! J1939: fields of a 29-bit identifier, and the frames of the transport protocol (SAE J1939-21).

use crate::can::{CanFrame, DATA_BYTES_MAX, ExtendedId, Id};

/// The global address.
pub const GLOBAL: u8 = 255;
/// The null address; in a file it stands for any sender.
pub const NULL: u8 = 254;
/// The longest message: 255 packets.
pub const BYTES_MAX: usize = 255 * PACKET_BYTES;
/// Message bytes in one packet.
pub const PACKET_BYTES: usize = 7;

/// Group of the frames that start and end a transport (TP.CM).
const CONNECTION: u32 = 0xEC00;
/// Group of a transport's packets (TP.DT).
const DATA: u32 = 0xEB00;
/// Priority of the transport's own frames.
const TRANSPORT_PRIORITY: u8 = 7;
/// From this value of the byte on a group is a broadcast, and the next byte belongs to its number.
const BROADCAST_FROM: u32 = 240;

/// Fields of an identifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identifier {
    /// 0 to 7; lower values win arbitration.
    pub priority: u8,
    /// Number of the parameter group, 18 bits. Its low byte is zero if the group has a destination.
    pub group: u32,
    /// Destination address; [`GLOBAL`] for a broadcast group.
    pub destination: u8,
    /// Source address.
    pub source: u8,
}

impl From<ExtendedId> for Identifier {
    fn from(id: ExtendedId) -> Self {
        let raw = id.as_raw();
        let [_, _, specific, source] = raw.to_be_bytes();
        let whole = (raw >> 8) & 0x3_FFFF;
        let is_broadcast = (whole >> 8) & 0xFF >= BROADCAST_FROM;
        let (group, destination) =
            if is_broadcast { (whole, GLOBAL) } else { (whole & !0xFF, specific) };
        Self { priority: (raw >> 26) as u8, group, destination, source }
    }
}

impl Identifier {
    /// The identifier with these fields.
    pub fn id(self) -> ExtendedId {
        let is_broadcast = (self.group >> 8) & 0xFF >= BROADCAST_FROM;
        let specific = if is_broadcast { 0 } else { u32::from(self.destination) };
        let group = (self.group & 0x3_FFFF) | specific;
        let raw = u32::from(self.priority & 7) << 26 | group << 8 | u32::from(self.source);
        ExtendedId::new(raw).unwrap_or(ExtendedId::MAX)
    }

    /// True if a frame with the identifier `heard` belongs to the group that a file lists with this identifier: the
    /// priority is ignored, and a null source or a null or global destination in the file matches every address. What is sent
    /// to the global address is for every node.
    pub fn means(self, heard: Self) -> bool {
        self.group == heard.group
            && (self.source == NULL || self.source == heard.source)
            && (self.destination >= NULL || [self.destination, GLOBAL].contains(&heard.destination))
    }
}

/// True if frames with this identifier belong to the transport protocol.
pub const fn is_transport(identifier: Identifier) -> bool {
    identifier.group == CONNECTION || identifier.group == DATA
}

/// A frame of the transport protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transport {
    /// TP.CM_RTS: request to send.
    RequestToSend {
        /// The message to be sent.
        extent: Extent,
        /// Maximum number of packets per answer.
        at_once: u8,
    },
    /// TP.CM_CTS: clear to send.
    ClearToSend {
        /// Number of packets; zero means wait.
        packets: u8,
        /// Number of the first packet to send.
        next: u8,
        /// The group of the message.
        group: u32,
    },
    /// TP.CM_EndOfMsgACK: all of the message arrived.
    Acknowledge(Extent),
    /// TP.CM_BAM: announces a broadcast message.
    Announce(Extent),
    /// TP.Conn_Abort: the transport ends.
    Abort {
        /// Numbered as in table 7 of SAE J1939-21.
        reason: u8,
        /// The group of the message.
        group: u32,
    },
    /// TP.DT: a packet.
    Data {
        /// Counts from 1.
        number: u8,
        /// The part of the message in this packet.
        bytes: [u8; PACKET_BYTES],
    },
}

/// Group and length of a message that is sent in packets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Number of the group.
    pub group: u32,
    /// Total number of bytes.
    pub bytes: u16,
}

impl Extent {
    /// Number of packets needed.
    pub fn packets(self) -> u8 {
        u8::try_from(usize::from(self.bytes).div_ceil(PACKET_BYTES)).unwrap_or(u8::MAX)
    }
}

/// Reason of [`Transport::Abort`]: the peer did not answer in time.
pub const TIMED_OUT: u8 = 3;

impl Transport {
    /// Decodes a frame of the transport protocol; `None` for any other frame.
    pub fn decode(frame: &CanFrame) -> Option<(Identifier, Self)> {
        let Id::Extended(id) = frame.id() else { return None };
        let from = Identifier::from(id);
        if !is_transport(from) {
            return None;
        }
        let data: [u8; DATA_BYTES_MAX] = frame.data().try_into().ok()?;
        let [first, a, b, c, d, low, middle, high] = data;
        if from.group == DATA {
            let bytes = [a, b, c, d, low, middle, high];
            return (first > 0).then_some((from, Self::Data { number: first, bytes }));
        }
        let group = u32::from_le_bytes([low, middle, high, 0]) & 0x3_FFFF;
        let extent = Extent { group, bytes: u16::from_le_bytes([a, b]) };
        let is_whole = (DATA_BYTES_MAX + 1..=BYTES_MAX).contains(&usize::from(extent.bytes))
            && extent.packets() == c;
        let said = match first {
            16 if is_whole && d > 0 => Self::RequestToSend { extent, at_once: d },
            17 => Self::ClearToSend { packets: a, next: b, group },
            19 if is_whole => Self::Acknowledge(extent),
            32 if is_whole => Self::Announce(extent),
            255 => Self::Abort { reason: a, group },
            _ => return None,
        };
        Some((from, said))
    }

    /// Encodes the frame from `source` to `destination`.
    pub fn encode(self, source: u8, destination: u8) -> CanFrame {
        let of = |first: u8, [a, b, c, d]: [u8; 4], group: u32| {
            let [low, middle, high, _] = group.to_le_bytes();
            [first, a, b, c, d, low, middle, high]
        };
        let about = |first: u8, extent: Extent, last: u8| {
            let [low, high] = extent.bytes.to_le_bytes();
            of(first, [low, high, extent.packets(), last], extent.group)
        };
        let data = match self {
            Self::RequestToSend { extent, at_once } => about(16, extent, at_once),
            Self::ClearToSend { packets, next, group } => of(17, [packets, next, 255, 255], group),
            Self::Acknowledge(extent) => about(19, extent, 255),
            Self::Announce(extent) => about(32, extent, 255),
            Self::Abort { reason, group } => of(255, [reason, 255, 255, 255], group),
            Self::Data { number, bytes: [a, b, c, d, e, f, g] } => [number, a, b, c, d, e, f, g],
        };
        let group = if matches!(self, Self::Data { .. }) { DATA } else { CONNECTION };
        let id = Identifier { priority: TRANSPORT_PRIORITY, group, destination, source }.id();
        CanFrame::full(id, data)
    }
}

/// Packet `number` (from 1) of a message, padded as the standard requires.
pub fn packet(message: &[u8], number: u8) -> Transport {
    let from = usize::from(number.saturating_sub(1)) * PACKET_BYTES;
    let mut bytes = [0xFF; PACKET_BYTES];
    for (byte, own) in bytes.iter_mut().zip(message.iter().skip(from)) {
        *byte = *own;
    }
    Transport::Data { number, bytes }
}

#[cfg(test)]
mod tests {
    use super::{GLOBAL, Identifier, NULL, Transport, packet};
    use crate::can::{CanFrame, ExtendedId};
    use proptest::prelude::*;

    /// Engine temperature 1 (SPN 110): group 65262 from the engine, address 0, as in J1939-71.
    #[test]
    fn an_identifier_is_taken_apart() {
        let said = Identifier::from(ExtendedId::new(0x18FE_EE00).unwrap());
        let engine = Identifier { priority: 6, group: 65262, destination: GLOBAL, source: 0 };
        assert_eq!(said, engine);
        // A request (group 59904) from the diagnostic tool to the engine.
        let said = Identifier::from(ExtendedId::new(0x18EA_00F9).unwrap());
        assert_eq!(said, Identifier { priority: 6, group: 59904, destination: 0, source: 249 });
        let to = |destination| Identifier { destination, ..said };
        assert!(said.means(to(0)) && said.means(to(GLOBAL)) && !said.means(to(5)));
        assert!(to(GLOBAL).means(to(5)) && to(NULL).means(to(5)));
        let anybody = Identifier { priority: 3, source: NULL, ..engine };
        assert!(anybody.means(engine) && !engine.means(anybody));
    }

    proptest! {
        #[test]
        fn every_identifier_comes_back(raw in 0..=0x1FFF_FFFFu32) {
            let id = ExtendedId::new(raw).unwrap();
            prop_assert_eq!(Identifier::from(id).id(), id);
        }

        #[test]
        fn no_frame_is_too_much(raw: u32, data in prop::collection::vec(any::<u8>(), 0..=8)) {
            let raw = raw & 0x1FFF_FFFF;
            for group in [raw, 0x1CEC_FF00 | raw & 0xFF, 0x1CEB_FF00 | raw & 0xFF] {
                let frame = CanFrame::new(ExtendedId::new(group).unwrap(), &data).unwrap();
                if let Some((from, said)) = Transport::decode(&frame) {
                    // Unused parts of a frame are padded, so it need not be identical.
                    let again = said.encode(from.source, from.destination);
                    prop_assert_eq!(Transport::decode(&again).map(|(_, again)| again), Some(said));
                }
            }
        }
    }

    #[test]
    fn the_last_packet_is_filled_up() {
        let message = [1, 2, 3, 4, 5, 6, 7, 8, 9];
        let Transport::Data { bytes, .. } = packet(&message, 2) else { unreachable!() };
        assert_eq!(bytes, [8, 9, 255, 255, 255, 255, 255]);
    }
}
