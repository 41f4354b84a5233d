//! The groups of a file, and the places of their values.

use super::super::error::{Defect, LogError};
use super::blocks::{Block, Source};
use super::field::{Clock, Field};
use super::frames::{Data, Frames};
use super::{
    BLOCK_HEAD_BYTES, CG_BUS_EVENT, CG_REMOTE_MASTER, CG_VARIABLE, CN_FIXED, CN_MASTER, CN_MOST,
    CN_VARIABLE, Kind,
};
use std::io::{Read, Seek};

/// Limits for the groups and channels of a file: one with every message of a large DBC has thousands of groups.
pub(super) const GROUPS_MAX: usize = 65_536;
pub(super) const CHANNELS_MAX: usize = 262_144;
const RECORD_BYTES_MAX: usize = 16 * 1024;
/// Most data groups with frames: each has its own buffer.
const STREAMS_MAX: usize = 256;
/// Most levels of nested structures.
pub(super) const DEPTH_MAX: u32 = 3;

#[derive(Debug)]
pub(super) struct DataGroup {
    pub(super) data: u64,
    /// Length of the record number before each record.
    pub(super) number_bytes: usize,
    pub(super) groups: Vec<Group>,
}

#[derive(Debug)]
pub(super) struct Group {
    pub(super) address: u64,
    pub(super) number: u64,
    pub(super) records: Records,
}

#[derive(Debug)]
pub(super) enum Records {
    Frames(usize, Box<Frames>),
    /// Data to which other records refer by offset.
    Variable,
    /// Something else, with the record length.
    Other(u64),
}

/// Reads the data groups of a file that have frames.
pub(super) fn all<R: Read + Seek>(
    source: &mut Source<R>,
    first: u64,
) -> Result<Vec<DataGroup>, LogError> {
    let (mut all, mut next, mut count, mut channels) = (Vec::new(), first, 0, 0);
    while next != 0 {
        let block = source.block(next, "##DG")?;
        let mut groups = Vec::new();
        let mut next_group = block.link(1);
        while next_group != 0 {
            let group = source.block(next_group, "##CG")?;
            groups.push(group_of(source, &group, &mut channels)?);
            bounded(source, next_group, groups.len() + count, GROUPS_MAX)?;
            next_group = group.link(0);
        }
        // A data group without channel groups also counts.
        count += groups.len() + 1;
        bounded(source, next, count, 2 * GROUPS_MAX)?;
        let number_bytes = usize::from(block.u8(0));
        if !matches!(number_bytes, 0 | 1 | 2 | 4 | 8) || (number_bytes == 0 && groups.len() > 1) {
            let found = format!("{number_bytes} bytes for {} groups", groups.len());
            let defect = Defect::new("record numbers of 0, 1, 2, 4 or 8 bytes", found.as_bytes());
            return Err(source.malformed(next, defect));
        }
        if groups.iter().any(|group| matches!(group.records, Records::Frames(..))) {
            all.push(DataGroup { data: block.link(2), number_bytes, groups });
            bounded(source, next, all.len(), STREAMS_MAX)?;
        }
        next = block.link(0);
    }
    Ok(all)
}

/// Refuses more groups or channels than `most`.
pub(super) fn bounded<R: Read + Seek>(
    source: &Source<R>,
    address: u64,
    count: usize,
    most: usize,
) -> Result<(), LogError> {
    // A cycle of links has more than fit into the file.
    let room = source.length() / BLOCK_HEAD_BYTES as u64;
    let most = most.min(usize::try_from(room).unwrap_or(usize::MAX));
    if count <= most {
        return Ok(());
    }
    let found = format!("more than {most}");
    Err(source
        .malformed(address, Defect::new("a file with fewer groups or channels", found.as_bytes())))
}

fn group_of<R: Read + Seek>(
    source: &mut Source<R>,
    block: &Block,
    channels: &mut usize,
) -> Result<Group, LogError> {
    let (address, number, flags) = (block.address, block.u64(0), block.u16(16));
    let bytes = u64::from(block.u32(24)) + u64::from(block.u32(28));
    if flags & CG_VARIABLE != 0 {
        return Ok(Group { address, number, records: Records::Variable });
    }
    let mut records = Records::Other(bytes);
    if flags & CG_BUS_EVENT != 0 {
        if flags & CG_REMOTE_MASTER != 0 {
            let expected =
                "frames with their times (column-oriented frames of MDF 4.2 are not read)";
            let defect = Defect::new(expected, b"a group without times");
            return Err(source.malformed(address, defect));
        }
        let mut found = Found::default();
        found.take(source, block.link(1), DEPTH_MAX, channels)?;
        if let Some(frames) = found.frames().map_err(|defect| source.malformed(address, defect))? {
            let length = usize::try_from(bytes).ok().filter(|length| *length <= RECORD_BYTES_MAX);
            let Some(length) = length.filter(|length| frames.end() <= *length) else {
                let defect = Defect::new(
                    "records of at most 16384 bytes with all their values",
                    format!("{bytes} bytes").as_bytes(),
                );
                return Err(source.malformed(address, defect));
            };
            records = Records::Frames(length, Box::new(frames));
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
    /// Takes the channels from that one on, and their components.
    fn take<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
        first: u64,
        depth: u32,
        channels: &mut usize,
    ) -> Result<(), LogError> {
        let mut next = first;
        while next != 0 {
            *channels += 1;
            bounded(source, next, *channels, CHANNELS_MAX)?;
            let channel = source.block(next, "##CN")?;
            let name = source.text(channel.link(2))?;
            self.channel(source, &channel, &name)?;
            // The components of an array (`CA`) have no names.
            let parts = channel.link(1);
            if parts != 0 && depth > 0 && source.any_block(parts)?.mark() == b"##CN" {
                self.take(source, parts, depth - 1, channels)?;
            }
            next = channel.link(0);
        }
        Ok(())
    }

    fn channel<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
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
                    let defect = Defect::new("data bytes in the file", found.as_bytes());
                    return Err(source.malformed(channel.address, defect));
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
            return Err(Defect::new("a channel `ID`", kind.name().as_bytes()));
        }
        if kind == Kind::Data && self.data.is_none() {
            return Err(Defect::new("a channel `DataBytes`", kind.name().as_bytes()));
        }
        let data = self.data.filter(|_| kind == Kind::Data);
        let flags = [edl, brs, esi];
        Ok(Some(Frames { kind, clock, channel, id, ide, code, length, direction, flags, data }))
    }
}

/// Offset and factor of a conversion (`CC` block), which must be absent or linear.
fn linear<R: Read + Seek>(source: &mut Source<R>, address: u64) -> Result<(f64, f64), LogError> {
    if address == 0 {
        return Ok((0.0, 1.0));
    }
    let block = source.block(address, "##CC")?;
    match block.u8(0) {
        0 => Ok((0.0, 1.0)),
        1 => Ok((block.f64(24), block.f64(32))),
        other => {
            let found = format!("conversion {other}");
            let defect = Defect::new("a time with a linear conversion", found.as_bytes());
            Err(source.malformed(address, defect))
        }
    }
}
