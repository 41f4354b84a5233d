//! The groups of a file, and the places of their values.

use super::super::error::{Defect, LogError};
use super::blocks::{Block, Source};
use super::field::{Clock, Field};
use super::frames::{Data, Frames};
use super::unsorted::{Lengths, is_variable, lengths};
use super::walk::{self, DEPTH_MAX};
use super::{CG_BUS_EVENT, CG_REMOTE_MASTER, CN_FIXED, CN_MASTER, CN_MOST, CN_VARIABLE, Kind};

pub(super) const RECORD_BYTES_MAX: usize = 16 * 1024;
/// Most data groups with frames: each has its own buffer.
const STREAMS_MAX: usize = 256;

#[derive(Debug)]
pub(super) struct DataGroup {
    pub(super) data: u64,
    /// Length of the record number before each record.
    pub(super) number_bytes: usize,
    pub(super) lengths: Lengths,
    /// In the order of the lengths.
    pub(super) groups: Vec<Group>,
}

#[derive(Debug)]
pub(super) struct Group {
    pub(super) address: u64,
    number: u64,
    pub(super) records: Records,
}

#[derive(Debug)]
pub(super) enum Records {
    Frames(Box<Frames>),
    /// Data to which other records refer by offset.
    Variable,
    /// Something else.
    Other,
}

/// Reads the data groups of a file that have frames. Returns whether others have data, too.
pub(super) fn all(source: &mut Source<'_>, first: u64) -> Result<(Vec<DataGroup>, bool), LogError> {
    let (mut all, mut has_others, mut channels) = (Vec::new(), false, 0);
    walk::data_groups(source, first, |source, block, groups| {
        let lengths = lengths(&groups);
        let groups = groups.iter().map(|group| group_of(source, group, &mut channels));
        let mut groups: Vec<Group> = groups.collect::<Result<_, _>>()?;
        groups.sort_by_key(|group| group.number);
        groups.dedup_by_key(|group| group.number);
        if groups.iter().any(|group| matches!(group.records, Records::Frames(_))) {
            let number_bytes = usize::from(block.u8(0));
            all.push(DataGroup { data: block.link(2), number_bytes, lengths, groups });
            walk::bounded(source, block.address, all.len(), STREAMS_MAX)?;
        } else {
            has_others |= block.link(2) != 0;
        }
        Ok(())
    })?;
    Ok((all, has_others))
}

fn group_of(
    source: &mut Source<'_>,
    block: &Block,
    channels: &mut usize,
) -> Result<Group, LogError> {
    let (address, number, flags) = (block.address, block.u64(0), block.u16(16));
    if is_variable(block) {
        return Ok(Group { address, number, records: Records::Variable });
    }
    let mut records = Records::Other;
    if flags & CG_BUS_EVENT != 0 {
        if flags & CG_REMOTE_MASTER != 0 {
            let expected =
                "frames with their times (column-oriented frames of MDF 4.2 are not read)";
            return source.bad(address, expected, b"a group without times");
        }
        let mut found = Found::default();
        walk::channels(source, block.link(1), DEPTH_MAX, channels, &mut |source, channel| {
            let name = source.text(channel.link(2))?;
            found.channel(source, channel, &name)
        })?;
        if let Some(frames) = found.frames().map_err(|defect| source.malformed(address, defect))? {
            let bytes = u64::from(block.u32(24)) + u64::from(block.u32(28));
            if bytes > RECORD_BYTES_MAX as u64 || bytes < frames.end() as u64 {
                let expected = "records of at most 16384 bytes with all their values";
                return source.bad(address, expected, format!("{bytes} bytes"));
            }
            records = Records::Frames(Box::new(frames));
        }
    }
    Ok(Group { address, number, records })
}

/// The relevant channels of a group.
#[derive(Default)]
struct Found {
    clock: Option<Clock>,
    kind: Option<Kind>,
    data: Option<Data>,
    fields: [Option<Field>; NAMES.len()],
}

/// Channels by the last part of their names.
const NAMES: [&str; 9] =
    ["BusChannel", "ID", "IDE", "DLC", "DataLength", "Dir", "EDL", "BRS", "ESI"];

impl Found {
    fn channel(
        &mut self,
        source: &mut Source<'_>,
        channel: &Block,
        name: &str,
    ) -> Result<(), LogError> {
        let field = Field::of(channel);
        let field = field.map_err(|defect| source.malformed(channel.address, defect));
        let kind = channel.u8(0);
        if kind == CN_MASTER {
            let (offset, factor) = linear(source, channel.link(4))?;
            self.clock = Some(Clock { field: field?, offset, factor });
            return Ok(());
        }
        let Some((group, name)) = name.rsplit_once('.') else { return Ok(()) };
        let group = group.rsplit('.').next().unwrap_or_default();
        let Some(group) = Kind::ALL.into_iter().find(|kind| kind.name() == group) else {
            return Ok(());
        };
        self.kind = Some(group);
        if name == "DataBytes" {
            let at = channel.link(5);
            self.data = Some(match kind {
                CN_FIXED | CN_MOST => Data::Fixed(field?),
                CN_VARIABLE if at != 0 => Data::Variable(Field::place_of(channel), at),
                other => {
                    let found = format!("a channel of type {other}");
                    return source.bad(channel.address, "data bytes in the file", found);
                }
            });
        } else if let Some(place) = NAMES.iter().position(|known| *known == name)
            && matches!(kind, CN_FIXED | CN_MOST)
        {
            self.fields[place] = Some(field?);
        }
        Ok(())
    }

    fn frames(self) -> Result<Option<Frames>, Defect> {
        let Some(kind) = self.kind else { return Ok(None) };
        let clock = self.clock.ok_or_else(|| Defect::new("a master channel of time", b""))?;
        let [channel, id, ide, code, length, direction, edl, brs, esi] = self.fields;
        if kind != Kind::Error && id.is_none() {
            return Err(Defect::new("a channel `ID`", kind.name()));
        }
        if kind == Kind::Data && self.data.is_none() {
            return Err(Defect::new("a channel `DataBytes`", kind.name()));
        }
        let data = self.data.filter(|_| kind == Kind::Data);
        let flags = [edl, brs, esi];
        Ok(Some(Frames { kind, clock, channel, id, ide, code, length, direction, flags, data }))
    }
}

/// Offset and factor of a conversion (`CC` block), which must be absent or linear.
fn linear(source: &mut Source<'_>, address: u64) -> Result<(f64, f64), LogError> {
    if address == 0 {
        return Ok((0.0, 1.0));
    }
    let block = source.block(address, "##CC")?;
    match block.u8(0) {
        0 => Ok((0.0, 1.0)),
        1 => Ok((block.f64(24), block.f64(32))),
        other => {
            source.bad(address, "a time with a linear conversion", format!("conversion {other}"))
        }
    }
}
