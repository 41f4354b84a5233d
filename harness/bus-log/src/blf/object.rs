//! One object of a BLF file.

use super::super::entry::{Direction, Entry, ErrorFrame, Payload};
use super::super::error::Defect;
use super::super::numbers;
use super::{
    BRS, CAN_ERROR, CAN_ERROR_EXT, CAN_FD_ERROR_64, CAN_FD_MESSAGE, CAN_FD_MESSAGE_64, CAN_MESSAGE,
    CAN_MESSAGE2, EDL, ESI, EXTENDED, OBJECT_BASE_BYTES, OBJECT_HEAD_BYTES, REMOTE, SENT,
    TEN_MICROS,
};
use embedded_can::Frame as _;
use wire::can::{self, CanFrame, DATA_BYTES_MAX, FD_BYTES_MAX, FD_LENGTHS, FdFlags};
use wire::time::Timestamp;

/// Most bytes of an object that describe a frame: head, 40 bytes and the data.
pub(super) const OBJECT_BYTES_MAX: usize = 512;

/// Bytes of a `CAN_FD_MESSAGE_64` before its data.
const FD_64_BYTES: usize = 40;
/// Flags of a `CAN_FD_MESSAGE_64`.
const REMOTE_64: u32 = 1 << 4;
const EDL_64: u32 = 1 << 12;
const BRS_64: u32 = 1 << 13;
const ESI_64: u32 = 1 << 14;

/// Whether objects of that type belong to a CAN bus.
pub(super) const fn is_of_can(kind: u32) -> bool {
    matches!(
        kind,
        CAN_MESSAGE
            | CAN_MESSAGE2
            | CAN_FD_MESSAGE
            | CAN_FD_MESSAGE_64
            | CAN_ERROR
            | CAN_ERROR_EXT
            | CAN_FD_ERROR_64
    )
}

/// Bytes of an object, read by offset.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn at<const N: usize>(&self, place: usize) -> Result<[u8; N], Defect> {
        let rest = self.0.get(place..).unwrap_or_default();
        rest.first_chunk().copied().ok_or_else(|| {
            let found = format!("{} bytes behind its head", self.0.len());
            Defect::new("an object as long as its type is", found)
        })
    }

    fn u8(&self, place: usize) -> Result<u8, Defect> {
        self.at(place).map(|[byte]| byte)
    }

    fn u16(&self, place: usize) -> Result<u16, Defect> {
        self.at(place).map(u16::from_le_bytes)
    }

    fn u32(&self, place: usize) -> Result<u32, Defect> {
        self.at(place).map(u32::from_le_bytes)
    }
}

/// A frame, independent of the type of object.
struct Frame<'a> {
    id: u32,
    code: u8,
    is_remote: bool,
    fd: Option<FdFlags>,
    data: &'a [u8],
}

/// Parses an object with its head, up to [`OBJECT_BYTES_MAX`], of a measurement that began then, nanoseconds since 1970;
/// `None` for a frame that is still to be sent.
pub(super) fn parse(kind: u32, object: &[u8], began: i64) -> Result<Option<Entry>, Defect> {
    let whole = Bytes(object);
    let head_bytes = usize::from(whole.u16(4)?);
    let flags = whole.u32(OBJECT_BASE_BYTES)?;
    let time = whole.at(OBJECT_BASE_BYTES + 8).map(u64::from_le_bytes)?;
    let factor = if flags == TEN_MICROS { 10_000 } else { 1 };
    let since_begin = time.checked_mul(factor);
    let since_begin =
        since_begin.ok_or_else(|| Defect::new("a time before 2262", time.to_string()))?;
    let body = match object.get(head_bytes..) {
        Some(body) if head_bytes >= OBJECT_HEAD_BYTES => Bytes(body),
        _ => {
            let found = format!("{head_bytes} bytes");
            return Err(Defect::new("the head of an object", found));
        }
    };
    let number = match kind {
        CAN_FD_MESSAGE_64 | CAN_FD_ERROR_64 => u32::from(body.u8(0)?),
        _ => u32::from(body.u16(0)?),
    };
    let channel = numbers::channel(number)
        .ok_or_else(|| Defect::new("a channel from 1", number.to_string()))?;
    let (direction, payload) = match kind {
        CAN_MESSAGE | CAN_MESSAGE2 => classic(&body)?,
        CAN_FD_MESSAGE => fd(&body)?,
        CAN_FD_MESSAGE_64 => {
            let direction = Direction::ALL.get(usize::from(body.u8(34)?));
            let Some(direction) = direction else { return Ok(None) };
            (Some(*direction), fd_64(&body, head_bytes)?)
        }
        _ => (None, Payload::Error(ErrorFrame::BUS_ERROR)),
    };
    let at = began.checked_add_unsigned(since_begin).ok_or_else(|| {
        let found = format!("{since_begin} ns since the begin");
        Defect::new("a time before 2262", found)
    })?;
    Ok(Some(Entry { at: Timestamp::from_nanos(at), channel, direction, payload }))
}

const fn direction(flags: u8) -> Option<Direction> {
    Some(if flags & SENT == 0 { Direction::Rx } else { Direction::Tx })
}

/// channel 2, flags 1, data length code 1, identifier 4, data 8
fn classic(body: &Bytes<'_>) -> Result<(Option<Direction>, Payload), Defect> {
    let (flags, data) = (body.u8(2)?, body.at::<DATA_BYTES_MAX>(8)?);
    let (is_remote, fd) = (flags & REMOTE != 0, None);
    let frame = Frame { id: body.u32(4)?, code: body.u8(3)?, is_remote, fd, data: &data };
    Ok((direction(flags), frame.payload()?))
}

/// channel 2, flags 1, data length code 1, identifier 4, duration 4, bits 1, flags of FD 1, bytes of data 1, reserved
/// 5, data 64
fn fd(body: &Bytes<'_>) -> Result<(Option<Direction>, Payload), Defect> {
    let (flags, of_fd) = (body.u8(2)?, body.u8(13)?);
    let (bit_rate_switch, error_state) = (of_fd & BRS != 0, of_fd & ESI != 0);
    let frame = Frame {
        id: body.u32(4)?,
        code: body.u8(3)?,
        is_remote: flags & REMOTE != 0,
        fd: (of_fd & EDL != 0).then_some(FdFlags { bit_rate_switch, error_state }),
        data: &body.at::<FD_BYTES_MAX>(20)?[..usize::from(body.u8(14)?).min(FD_BYTES_MAX)],
    };
    Ok((direction(flags), frame.payload()?))
}

/// channel 1, data length code 1, bytes of data 1, tries 1, identifier 4, duration 4, flags 4, bit timing 8, times 8,
/// bits 2, direction 1, offset of further data 1, CRC 4, data
fn fd_64(body: &Bytes<'_>, head_bytes: usize) -> Result<Payload, Defect> {
    let flags = body.u32(12)?;
    let (bit_rate_switch, error_state) = (flags & BRS_64 != 0, flags & ESI_64 != 0);
    let _crc = body.u32(36)?;
    let end = match usize::from(body.u8(35)?) {
        0 => body.0.len(),
        more => more.saturating_sub(head_bytes).clamp(FD_64_BYTES, body.0.len()),
    };
    let data = body.0.get(FD_64_BYTES..end).unwrap_or_default();
    let frame = Frame {
        id: body.u32(4)?,
        code: body.u8(1)?,
        is_remote: flags & REMOTE_64 != 0,
        fd: (flags & EDL_64 != 0).then_some(FdFlags { bit_rate_switch, error_state }),
        data: &data[..data.len().min(usize::from(body.u8(2)?))],
    };
    frame.payload()
}

impl Frame<'_> {
    /// Data bytes missing for the length are zero, as in Vector's tools.
    fn payload(&self) -> Result<Payload, Defect> {
        let bad = |expected, number: u32| Defect::new(expected, format!("{number:X}"));
        let raw = self.id & !EXTENDED;
        let id = can::identifier(raw, self.id & EXTENDED != 0);
        let id = id.ok_or_else(|| bad("an identifier up to 7FF, or up to 1FFFFFFF", self.id))?;
        let code = usize::from(self.code);
        let length = FD_LENGTHS.get(code).map(|length| usize::from(*length));
        let bad_code = || bad("a data length code of 0 to F", u32::from(self.code));
        let length = length.ok_or_else(bad_code)?;
        let mut data = [0; FD_BYTES_MAX];
        let known = self.data.len().min(length);
        data[..known].copy_from_slice(&self.data[..known]);
        let classic = length.min(DATA_BYTES_MAX);
        let frame = match self.fd {
            Some(flags) => CanFrame::fd(id, flags, &data[..length]),
            None if self.is_remote => CanFrame::new_remote(id, classic),
            None => CanFrame::new(id, &data[..classic]),
        };
        frame.map(Payload::Frame).ok_or_else(bad_code)
    }
}
