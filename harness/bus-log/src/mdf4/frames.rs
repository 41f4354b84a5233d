//! Decodes frames in the records of a group.

use super::super::entry::{Channel, Direction, Entry, ErrorFrame, Payload};
use super::super::error::Defect;
use super::super::numbers;
use super::Kind;
use super::field::{Clock, Field};
use embedded_can::Frame as _;
use wire::can::{self, CanFrame, DATA_BYTES_MAX, EXTENDED_FLAG, FD_BYTES_MAX, FD_LENGTHS, FdFlags};
use wire::time::Timestamp;

#[derive(Debug)]
pub(super) struct Frames {
    pub(super) kind: Kind,
    pub(super) clock: Clock,
    pub(super) channel: Option<Field>,
    pub(super) id: Option<Field>,
    pub(super) ide: Option<Field>,
    pub(super) code: Option<Field>,
    pub(super) length: Option<Field>,
    pub(super) direction: Option<Field>,
    /// `EDL`, `BRS` and `ESI`.
    pub(super) flags: [Option<Field>; 3],
    /// Only for data frames.
    pub(super) data: Option<Data>,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Data {
    Fixed(Field),
    /// Elsewhere: the record has their offset in the data at that address, or in the group there.
    Variable(Field, u64),
}

impl Frames {
    pub(super) fn end(&self) -> usize {
        let fields = [self.channel, self.id, self.ide, self.code, self.length, self.direction];
        let data = self.data.map(|data| match data {
            Data::Fixed(field) | Data::Variable(field, _) => field,
        });
        let all = fields.into_iter().chain(self.flags).chain([data, Some(self.clock.field)]);
        all.flatten().map(|field| field.end()).max().unwrap_or(0)
    }

    /// The entry of a record. `variable` holds its data bytes if they are not in it.
    pub(super) fn entry(
        &self,
        began: i64,
        record: &[u8],
        variable: Option<&[u8]>,
    ) -> Result<Entry, Defect> {
        let at = self.clock.nanos(record).and_then(|nanos| i64::try_from(nanos).ok());
        let at = at.and_then(|nanos| began.checked_add(nanos));
        let at = at.ok_or_else(|| {
            let found = format!("{:02x?}", self.clock.field.bytes(record));
            Defect::new("a time before 2262", found)
        })?;
        let number = |field: Option<Field>| field.map(|field| field.number(record));
        let channel = number(self.channel)
            .map_or(Some(Channel::CAN0), of_bus)
            .ok_or_else(|| Defect::new("a bus of at most 32 bits", b"another"))?;
        let direction = number(self.direction).and_then(|way| usize::try_from(way).ok());
        let direction = direction.and_then(|way| Direction::ALL.get(way)).copied();
        let (direction, payload) = match self.kind {
            Kind::Error => (None, Payload::Error(ErrorFrame::BUS_ERROR)),
            Kind::Data | Kind::Remote => (direction, self.frame(record, variable)?),
        };
        Ok(Entry { at: Timestamp::from_nanos(at), channel, direction, payload })
    }

    fn frame(&self, record: &[u8], variable: Option<&[u8]>) -> Result<Payload, Defect> {
        let number = |field: Option<Field>| field.map(|field| field.number(record));
        let is = |field: Option<Field>| number(field).is_some_and(|number| number != 0);
        let raw = number(self.id).unwrap_or(0);
        let bad_id = || {
            let found = format!("{raw:X}");
            Defect::new("an identifier of 11 bits, or of 29", found)
        };
        let raw = u32::try_from(raw).map_err(|_| bad_id())?;
        // Without `IDE`, bit 31 marks an extended identifier.
        let is_extended = self.ide.map_or(raw & EXTENDED_FLAG != 0, |ide| is(Some(ide)));
        let id = can::identifier(raw & !EXTENDED_FLAG, is_extended).ok_or_else(bad_id)?;
        let code = number(self.code).unwrap_or(0);
        let by_code = || FD_LENGTHS.get(code as usize).map(|length| u64::from(*length));
        let length = number(self.length).filter(|_| self.kind == Kind::Data).or_else(by_code);
        let length = length.filter(|length| *length <= FD_BYTES_MAX as u64).unwrap_or(u64::MAX);
        let bad_length = || {
            let found = format!("DLC {code}, length {length}");
            Defect::new("a length that such a frame can have", found)
        };
        if self.kind == Kind::Remote {
            let length = usize::try_from(length.min(DATA_BYTES_MAX as u64)).unwrap_or(0);
            return CanFrame::new_remote(id, length).map(Payload::Frame).ok_or_else(bad_length);
        }
        let [edl, brs, esi] = self.flags;
        let given = match self.data {
            Some(Data::Fixed(field)) => field.bytes(record),
            _ => variable.unwrap_or_default(),
        };
        let length = usize::try_from(length).map_err(|_| bad_length())?;
        let data = given.get(..length).ok_or_else(bad_length)?;
        let frame = if is(edl) || length > DATA_BYTES_MAX {
            let flags = FdFlags { bit_rate_switch: is(brs), error_state: is(esi) };
            CanFrame::fd(id, flags, data)
        } else {
            CanFrame::new(id, data)
        };
        frame.map(Payload::Frame).ok_or_else(bad_length)
    }
}

/// The channel of a bus number; zero is not a number of the standard.
fn of_bus(number: u64) -> Option<Channel> {
    match u32::try_from(number).ok()? {
        0 => Channel::new("can"),
        number => numbers::channel(number),
    }
}
