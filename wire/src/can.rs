//! CAN frames, classic and FD (ISO 11898-1:2015).

mod bits;
mod rates;
mod written;

pub use embedded_can::{ExtendedId, Id, StandardId};
pub use rates::BitRates;

use core::fmt;

/// Maximum data length of a classic frame.
pub const DATA_BYTES_MAX: usize = 8;

/// Maximum data length of a CAN FD frame.
pub const FD_BYTES_MAX: usize = 64;

/// Data lengths of a CAN FD frame by data length code (ISO 11898-1).
pub const FD_LENGTHS: [u8; 16] =
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, FD_BYTES_MAX as u8];

/// The smallest data length of a CAN FD frame for `bytes` bytes; `None` above [`FD_BYTES_MAX`].
pub fn fd_length(bytes: usize) -> Option<usize> {
    FD_LENGTHS.into_iter().map(usize::from).find(|length| *length >= bytes)
}

/// Bit rate of the base's bus, bits per second. Assumption: the usual rate of machine control (CiA 301 lists 500
/// kbit/s).
pub const BIT_RATE: u32 = 500_000;

/// An identifier as text: `0x` and three digits, or eight of an extended one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hex(pub Id);

impl fmt::Display for Hex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Id::Standard(id) => write!(f, "0x{:03x}", id.as_raw()),
            Id::Extended(id) => write!(f, "0x{:08x}", id.as_raw()),
        }
    }
}

/// A frame: an identifier with up to eight data bytes, a remote request for as many, or up to 64 bytes with CAN FD.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct CanFrame {
    id: Id,
    kind: Kind,
    length: u8,
    data: [u8; FD_BYTES_MAX],
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Data,
    Remote,
    Fd(FdFlags),
}

/// Flags of a CAN FD frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FdFlags {
    /// The data phase uses the faster rate (BRS).
    pub bit_rate_switch: bool,
    /// The sender is error-passive (ESI).
    pub error_state: bool,
}

/// `CANFD_BRS` and `CANFD_ESI` (linux/can.h).
const BRS: u8 = 0x01;
const ESI: u8 = 0x02;

impl FdFlags {
    /// From the flags of `struct canfd_frame`; other flags are ignored.
    pub const fn from_bits(bits: u8) -> Self {
        Self { bit_rate_switch: bits & BRS != 0, error_state: bits & ESI != 0 }
    }

    /// As the flags of `struct canfd_frame`.
    pub const fn bits(self) -> u8 {
        (if self.bit_rate_switch { BRS } else { 0 }) | (if self.error_state { ESI } else { 0 })
    }
}

impl CanFrame {
    /// A classic data frame; `None` if `data` is longer than [`DATA_BYTES_MAX`].
    pub fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        (data.len() <= DATA_BYTES_MAX).then(|| Self::of(id.into(), Kind::Data, data))
    }

    /// A CAN FD frame; `None` if no such frame has data of that [length](FD_LENGTHS).
    pub fn fd(id: impl Into<Id>, flags: FdFlags, data: &[u8]) -> Option<Self> {
        let has_code = FD_LENGTHS.iter().any(|length| usize::from(*length) == data.len());
        has_code.then(|| Self::of(id.into(), Kind::Fd(flags), data))
    }

    /// A classic data frame with all eight bytes.
    pub fn full(id: impl Into<Id>, data: [u8; DATA_BYTES_MAX]) -> Self {
        Self::of(id.into(), Kind::Data, &data)
    }

    /// `data` has at most [`FD_BYTES_MAX`] bytes.
    fn of(id: Id, kind: Kind, data: &[u8]) -> Self {
        let mut bytes = [0; FD_BYTES_MAX];
        bytes[..data.len()].copy_from_slice(data);
        Self { id, kind, length: data.len() as u8, data: bytes }
    }

    /// A frame of the same identifier and kind; `None` if such a frame cannot have data of that length.
    pub fn with_data(&self, data: &[u8]) -> Option<Self> {
        match self.kind {
            Kind::Fd(flags) => Self::fd(self.id, flags, data),
            Kind::Data | Kind::Remote => Self::new(self.id, data),
        }
    }

    /// A frame of the same identifier, kind and length with these first bytes, as many as it has; the others are zero.
    #[inline]
    pub fn with_first(&self, data: [u8; DATA_BYTES_MAX]) -> Self {
        let behind = u64::BITS - u8::BITS * u32::from(self.length.min(DATA_BYTES_MAX as u8));
        let kept = u64::from_le_bytes(data) & u64::MAX.checked_shr(behind).unwrap_or(0);
        let mut bytes = [0; FD_BYTES_MAX];
        bytes[..DATA_BYTES_MAX].copy_from_slice(&kept.to_le_bytes());
        Self { id: self.id, kind: self.kind, length: self.length, data: bytes }
    }

    /// The identifier.
    pub const fn id(&self) -> Id {
        self.id
    }

    /// The data; empty for a remote request.
    pub fn data(&self) -> &[u8] {
        if self.is_remote() { &[] } else { &self.data[..usize::from(self.length)] }
    }

    /// Length of the data in bytes; for a remote request, the requested length.
    pub const fn length(&self) -> usize {
        self.length as usize
    }

    /// A remote request.
    pub const fn is_remote(&self) -> bool {
        matches!(self.kind, Kind::Remote)
    }

    /// Flags of a CAN FD frame; `None` for a classic frame.
    pub const fn fd_flags(&self) -> Option<FdFlags> {
        match self.kind {
            Kind::Fd(flags) => Some(flags),
            Kind::Data | Kind::Remote => None,
        }
    }
}

impl fmt::Debug for CanFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "CanFrame({:?}, ", self.id)?;
        match self.kind {
            Kind::Data => write!(f, "{:02x?})", self.data()),
            Kind::Remote => write!(f, "remote {})", self.length),
            Kind::Fd(flags) => write!(f, "{flags:?}, {:02x?})", self.data()),
        }
    }
}

impl embedded_can::Frame for CanFrame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        Self::new(id, data)
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        let frame = Self::of(id.into(), Kind::Remote, &[]);
        (dlc <= DATA_BYTES_MAX).then_some(Self { length: dlc as u8, ..frame })
    }

    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }

    fn is_remote_frame(&self) -> bool {
        self.is_remote()
    }

    fn id(&self) -> Id {
        self.id
    }

    /// The data length code; above eight it differs from the length.
    fn dlc(&self) -> usize {
        FD_LENGTHS.iter().position(|length| *length == self.length).unwrap_or_default()
    }

    fn data(&self) -> &[u8] {
        self.data()
    }
}

/// Flag in the word of an identifier: extended (`CAN_EFF_FLAG` of `linux/can.h`).
pub const EXTENDED_FLAG: u32 = 1 << 31;
/// Flag of a remote request (`CAN_RTR_FLAG`).
pub const REMOTE_FLAG: u32 = 1 << 30;
/// In the flags of `struct canfd_frame`: a CAN FD frame (`CANFD_FDF`).
pub const FD_FLAG: u8 = 0x04;

/// The identifier as a word of `linux/can.h`.
pub fn word(id: Id) -> u32 {
    match id {
        Id::Standard(id) => u32::from(id.as_raw()),
        Id::Extended(id) => id.as_raw() | EXTENDED_FLAG,
    }
}

/// The identifier `raw`, of 29 bits if `extended` and of 11 otherwise; `None` if it has more.
pub fn identifier(raw: u32, extended: bool) -> Option<Id> {
    if extended {
        ExtendedId::new(raw).map(Id::Extended)
    } else {
        u16::try_from(raw).ok().and_then(StandardId::new).map(Id::Standard)
    }
}

impl CanFrame {
    /// Identifier and kind as a word of `linux/can.h`.
    pub fn word(&self) -> u32 {
        word(self.id) | if self.is_remote() { REMOTE_FLAG } else { 0 }
    }

    /// Decodes a frame in the form of a raw socket: an identifier word, a length, and at least as many bytes. Other
    /// bits of the identifier are ignored. With `fd` flags it is a CAN FD frame; `None` if such a frame cannot have
    /// that length.
    pub fn of_word(word: u32, fd: Option<FdFlags>, length: usize, data: &[u8]) -> Option<Self> {
        let extended = word & EXTENDED_FLAG != 0;
        let most =
            if extended { ExtendedId::MAX.as_raw() } else { u32::from(StandardId::MAX.as_raw()) };
        let id = identifier(word & most, extended)?;
        match fd {
            Some(flags) => Self::fd(id, flags, data.get(..length)?),
            None if word & REMOTE_FLAG != 0 => embedded_can::Frame::new_remote(id, length),
            None => Self::new(id, data.get(..length)?),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{CanFrame, ExtendedId, FD_LENGTHS, FdFlags, Id, StandardId};
    use embedded_can::Frame as _;
    use proptest::prelude::*;

    fn any_id() -> impl Strategy<Value = Id> {
        prop_oneof![
            (0u16..=0x7ff).prop_map(|raw| Id::Standard(StandardId::new(raw).unwrap())),
            (0u32..=0x1fff_ffff).prop_map(|raw| Id::Extended(ExtendedId::new(raw).unwrap())),
        ]
    }

    pub(super) fn any_frame() -> impl Strategy<Value = CanFrame> {
        let data = |length: usize| prop::collection::vec(any::<u8>(), length);
        prop_oneof![
            (any_id(), (0..=8usize).prop_flat_map(data))
                .prop_map(|(id, data)| CanFrame::new(id, &data).unwrap()),
            (any_id(), 0..=8usize)
                .prop_map(|(id, length)| CanFrame::new_remote(id, length).unwrap()),
            (any_id(), 0..4u8, prop::sample::select(FD_LENGTHS.to_vec()))
                .prop_flat_map(move |(id, flags, length)| (
                    Just(id),
                    Just(flags),
                    data(length.into())
                ))
                .prop_map(|(id, flags, data)| {
                    CanFrame::fd(id, FdFlags::from_bits(flags), &data).unwrap()
                }),
        ]
    }

    proptest! {
        #[test]
        fn a_frame_comes_back(frame in any_frame()) {
            let bytes = postcard::to_allocvec(&frame).unwrap();
            prop_assert_eq!(postcard::from_bytes::<CanFrame>(&bytes).unwrap(), frame);
            let more = [frame.data(), &[7; 8]].concat();
            prop_assert_eq!(CanFrame::of_word(frame.word(), frame.fd_flags(), frame.length(), &more), Some(frame));
            if !frame.is_remote() {
                prop_assert_eq!(frame.with_data(frame.data()), Some(frame));
            }
        }

        #[test]
        fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
            if let Ok(frame) = postcard::from_bytes::<CanFrame>(&bytes) {
                let again = postcard::to_allocvec(&frame).unwrap();
                prop_assert_eq!(postcard::from_bytes::<CanFrame>(&again).unwrap(), frame);
            }
        }
    }

    #[test]
    fn nine_bytes_are_no_frame() {
        assert!(CanFrame::new(StandardId::MAX, &[0; 9]).is_none());
    }

    #[test]
    fn only_sixteen_lengths_are_fd() {
        let fd =
            |length: usize| CanFrame::fd(StandardId::ZERO, FdFlags::default(), &[0; 65][..length]);
        let frames = || (0..=65).filter_map(fd);
        assert!(frames().map(|frame| frame.data().len()).eq(FD_LENGTHS.map(usize::from)));
        assert!(frames().map(|frame| frame.dlc()).eq(0..16));
        assert_eq!([super::fd_length(9), super::fd_length(65)], [Some(12), None]);
    }

    #[test]
    fn flags_come_back() {
        for bits in 0..4 {
            assert_eq!(FdFlags::from_bits(bits).bits(), bits);
        }
        assert_eq!(FdFlags::from_bits(0xfc), FdFlags::default());
    }
}
