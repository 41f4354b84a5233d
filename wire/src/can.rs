//! Classic CAN data frames.

pub use embedded_can::{ExtendedId, Id, StandardId};
use serde::{Deserialize, Serialize};

/// The most data a classic frame carries.
pub const DATA_BYTES_MAX: usize = 8;

/// Bits per second of the base's bus: assumption, the usual rate of machine control (CiA 301 lists 500 kbit/s).
pub const BIT_RATE: i64 = 500_000;

/// A classic CAN frame: an identifier and up to eight bytes, or a remote request for as many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CanFrame {
    id: Id,
    remote: bool,
    length: u8,
    data: [u8; DATA_BYTES_MAX],
}

impl CanFrame {
    /// A data frame; `None` when `data` is longer than [`DATA_BYTES_MAX`].
    pub fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let mut bytes = [0; DATA_BYTES_MAX];
        bytes.get_mut(..data.len())?.copy_from_slice(data);
        Some(Self { id: id.into(), remote: false, length: data.len() as u8, data: bytes })
    }

    /// A data frame with all eight bytes.
    pub fn full(id: impl Into<Id>, data: [u8; DATA_BYTES_MAX]) -> Self {
        Self { id: id.into(), remote: false, length: DATA_BYTES_MAX as u8, data }
    }

    /// The identifier.
    pub const fn id(&self) -> Id {
        self.id
    }

    /// The data; empty for a remote request.
    pub fn data(&self) -> &[u8] {
        if self.remote { &[] } else { &self.data[..usize::from(self.length)] }
    }

    /// A remote request.
    pub const fn is_remote(&self) -> bool {
        self.remote
    }

    /// Bits on the wire from start of frame to the end of the intermission, before bit stuffing:
    /// 47 for a standard and 67 for an extended identifier, and eight a data byte (ISO 11898-1).
    pub fn bits_unstuffed(&self) -> u32 {
        let overhead = match self.id {
            Id::Standard(_) => 47,
            Id::Extended(_) => 67,
        };
        overhead + 8 * self.data().len() as u32
    }
}

impl embedded_can::Frame for CanFrame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        Self::new(id, data)
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        (dlc <= DATA_BYTES_MAX).then(|| Self {
            id: id.into(),
            remote: true,
            length: dlc as u8,
            data: [0; DATA_BYTES_MAX],
        })
    }

    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }

    fn is_remote_frame(&self) -> bool {
        self.remote
    }

    fn id(&self) -> Id {
        self.id
    }

    fn dlc(&self) -> usize {
        usize::from(self.length)
    }

    fn data(&self) -> &[u8] {
        self.data()
    }
}

/// In the word of an identifier: it is extended (`CAN_EFF_FLAG` of `linux/can.h`).
pub const EXTENDED_FLAG: u32 = 1 << 31;
/// The frame is a remote request (`CAN_RTR_FLAG`).
pub const REMOTE_FLAG: u32 = 1 << 30;

/// The identifier as a word of `linux/can.h`.
pub fn word(id: Id) -> u32 {
    match id {
        Id::Standard(id) => u32::from(id.as_raw()),
        Id::Extended(id) => id.as_raw() | EXTENDED_FLAG,
    }
}

impl CanFrame {
    /// Identifier and kind as a word of `linux/can.h`.
    pub fn word(&self) -> u32 {
        word(self.id) | if self.remote { REMOTE_FLAG } else { 0 }
    }

    /// The frame of such a word, a length, and at least as many bytes, as a raw socket has it: further bits of the
    /// identifier are ignored. `None` where it is longer than a classic frame.
    pub fn of_word(word: u32, length: usize, data: &[u8]) -> Option<Self> {
        let id = if word & EXTENDED_FLAG != 0 {
            Id::Extended(ExtendedId::new(word & ExtendedId::MAX.as_raw())?)
        } else {
            Id::Standard(StandardId::new(word as u16 & StandardId::MAX.as_raw())?)
        };
        if word & REMOTE_FLAG != 0 {
            return <Self as embedded_can::Frame>::new_remote(id, length);
        }
        Self::new(id, data.get(..length).filter(|data| data.len() <= DATA_BYTES_MAX)?)
    }
}

/// The form in which a frame is recorded: the word of its identifier, the length and the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedFrame {
    id: u32,
    length: u8,
    data: [u8; DATA_BYTES_MAX],
}

impl From<CanFrame> for RecordedFrame {
    fn from(frame: CanFrame) -> Self {
        Self { id: frame.word(), length: frame.length, data: frame.data }
    }
}

impl RecordedFrame {
    /// The frame; `None` where the identifier or the length is out of range.
    pub fn frame(self) -> Option<CanFrame> {
        let raw = self.id & !(EXTENDED_FLAG | REMOTE_FLAG);
        let id = if self.id & EXTENDED_FLAG != 0 {
            Id::Extended(ExtendedId::new(raw)?)
        } else {
            Id::Standard(StandardId::new(u16::try_from(raw).ok()?)?)
        };
        (usize::from(self.length) <= DATA_BYTES_MAX).then_some(CanFrame {
            id,
            remote: self.id & REMOTE_FLAG != 0,
            length: self.length,
            data: self.data,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{CanFrame, ExtendedId, Id, RecordedFrame, StandardId};
    use embedded_can::Frame as _;
    use proptest::prelude::*;

    fn any_id() -> impl Strategy<Value = Id> {
        prop_oneof![
            (0u16..=0x7ff).prop_map(|raw| Id::Standard(StandardId::new(raw).unwrap())),
            (0u32..=0x1fff_ffff).prop_map(|raw| Id::Extended(ExtendedId::new(raw).unwrap())),
        ]
    }

    proptest! {
        #[test]
        fn a_recorded_frame_comes_back(id in any_id(), data in prop::collection::vec(any::<u8>(), 0..=8)) {
            let frame = CanFrame::new(id, &data).unwrap();
            prop_assert_eq!(RecordedFrame::from(frame).frame(), Some(frame));
            let remote = <CanFrame as embedded_can::Frame>::new_remote(id, data.len()).unwrap();
            prop_assert_eq!(RecordedFrame::from(remote).frame(), Some(remote));
            for frame in [frame, remote] {
                let back = CanFrame::of_word(frame.word(), frame.dlc(), &[frame.data(), &[7; 8]].concat());
                prop_assert_eq!(back, Some(frame));
            }
            prop_assert!(remote.data().is_empty());
            prop_assert_eq!(remote.dlc(), data.len());
        }
    }

    #[test]
    fn nine_bytes_are_no_frame() {
        assert!(CanFrame::new(StandardId::MAX, &[0; 9]).is_none());
    }
}
