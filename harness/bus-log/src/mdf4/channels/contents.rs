//! Groups and channels of a file.

use super::super::super::error::{Defect, LogError};
use super::super::blocks::{Block, Source};
use super::super::groups::{CHANNELS_MAX, DEPTH_MAX, GROUPS_MAX, bounded};
use super::super::{CG_REMOTE_MASTER, CG_VARIABLE, CN_MASTER, CN_VIRTUAL_MASTER};
use std::collections::HashMap;
use std::io::{Read, Seek};
use std::sync::Arc;

/// The master channel is a time.
const SYNC_TIME: u8 = 1;

/// A group of channels with common times.
#[derive(Debug)]
pub struct Group {
    /// Its name in the file; empty if unnamed.
    pub name: String,
    /// Its channels; components follow their structures.
    pub channels: Vec<Channel>,
    /// Number of records according to the file.
    pub records: u64,
    /// Where its values are: in one place, or, in column-oriented storage, in one for the time and one for each channel.
    pub(super) parts: Vec<Part>,
}

/// Records with the values of some channels of a group.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) address: u64,
    pub(super) data: u64,
    /// Length of the record number before each record, and the own number.
    pub(super) number_bytes: usize,
    pub(super) number: u64,
    /// Bytes of values in a record, and of the invalidation bits after them.
    pub(super) value_bytes: u64,
    pub(super) invalid_bytes: u64,
    /// Numbers and record lengths of all groups among these records, by number; no length if their records state it.
    pub(super) others: Arc<[(u64, Option<u64>)]>,
}

#[derive(Debug)]
pub struct Channel {
    pub name: String,
    /// Unit of its values in the file; empty without a unit.
    pub unit: String,
    /// Whether it is the time of the group's records, in seconds.
    pub is_time: bool,
    pub(super) address: u64,
    /// Index of the part with its values.
    pub(super) part: usize,
}

/// Reads all groups from that data group on, with their channels.
pub(super) fn all<R: Read + Seek>(
    source: &mut Source<R>,
    first: u64,
) -> Result<Vec<Group>, LogError> {
    let (mut all, mut next, mut blocks, mut channels) = (Vec::<Group>::new(), first, 0, 0);
    // Groups whose times are in that one, in the order of the file.
    let mut columns: Vec<(u64, Group)> = Vec::new();
    while next != 0 {
        let block = source.block(next, "##DG")?;
        let number_bytes = usize::from(block.u8(0));
        let mut groups = Vec::new();
        let mut next_group = block.link(1);
        let mut lengths = Vec::new();
        while next_group != 0 {
            let group = source.block(next_group, "##CG")?;
            let at = std::mem::replace(&mut next_group, group.link(0));
            let is_variable = group.u16(16) & CG_VARIABLE != 0;
            let bytes = u64::from(group.u32(24)) + u64::from(group.u32(28));
            lengths.push((group.u64(0), (!is_variable).then_some(bytes)));
            blocks += 1;
            bounded(source, at, blocks, GROUPS_MAX)?;
            // Records of variable length are values of channels of other groups.
            if !is_variable {
                groups.push(group);
            }
        }
        let is_known = matches!(number_bytes, 0 | 1 | 2 | 4 | 8);
        if !is_known || (number_bytes == 0 && lengths.len() > 1) {
            let found = format!("{number_bytes} bytes for {} groups", lengths.len());
            let defect = Defect::new("record numbers of 0, 1, 2, 4 or 8 bytes", found.as_bytes());
            return Err(source.malformed(next, defect));
        }
        lengths.sort_by_key(|(number, _)| *number);
        lengths.dedup_by_key(|(number, _)| *number);
        let others: Arc<[_]> = lengths.into();
        for block_of_group in groups {
            let group = group_of(source, &block_of_group, &block, &others, &mut channels)?;
            match block_of_group.u16(16) & CG_REMOTE_MASTER {
                0 => all.push(group),
                _ => columns.push((block_of_group.link(6), group)),
            }
        }
        // A data group without channel groups also counts, as links may form a cycle.
        blocks += 1;
        bounded(source, next, blocks, 2 * GROUPS_MAX)?;
        next = block.link(0);
    }
    join(source, &mut all, columns)?;
    Ok(all)
}

/// Adds channels that are stored by themselves to the groups that have their times.
fn join<R: Read + Seek>(
    source: &Source<R>,
    all: &mut [Group],
    columns: Vec<(u64, Group)>,
) -> Result<(), LogError> {
    let addresses = all.iter().enumerate().filter_map(|(index, group)| {
        let part = group.parts.first()?;
        Some((part.address, index))
    });
    let addresses: HashMap<u64, usize> = addresses.collect();
    for (master, column) in columns {
        let address = column.parts.first().map_or(0, |part| part.address);
        let group = addresses.get(&master).and_then(|index| all.get_mut(*index));
        let Some(group) = group.filter(|group| group.records == column.records) else {
            let found = format!("{} records with the times at {master}", column.records);
            let defect = Defect::new("a group with as many times", found.as_bytes());
            return Err(source.malformed(address, defect));
        };
        let parts = group.parts.len();
        group.parts.extend(column.parts);
        group
            .channels
            .extend(column.channels.into_iter().map(|channel| Channel { part: parts, ..channel }));
    }
    Ok(())
}

fn group_of<R: Read + Seek>(
    source: &mut Source<R>,
    block: &Block,
    data_group: &Block,
    others: &Arc<[(u64, Option<u64>)]>,
    count: &mut usize,
) -> Result<Group, LogError> {
    let mut channels = Vec::new();
    take(source, block.link(1), DEPTH_MAX, count, &mut channels)?;
    let part = Part {
        address: block.address,
        data: data_group.link(2),
        number_bytes: usize::from(data_group.u8(0)),
        number: block.u64(0),
        value_bytes: u64::from(block.u32(24)),
        invalid_bytes: u64::from(block.u32(28)),
        others: Arc::clone(others),
    };
    let name = source.whole_text(block.link(2))?;
    Ok(Group { name, channels, records: block.u64(8), parts: vec![part] })
}

/// Takes the channels from that one on, and their components.
fn take<R: Read + Seek>(
    source: &mut Source<R>,
    first: u64,
    depth: u32,
    count: &mut usize,
    channels: &mut Vec<Channel>,
) -> Result<(), LogError> {
    let mut next = first;
    while next != 0 {
        *count += 1;
        bounded(source, next, *count, CHANNELS_MAX)?;
        let channel = source.block(next, "##CN")?;
        let is_master = matches!(channel.u8(0), CN_MASTER | CN_VIRTUAL_MASTER);
        let mut unit = source.whole_text(channel.link(6))?;
        let conversion = channel.link(4);
        if unit.is_empty() && conversion != 0 {
            let conversion = source.block(conversion, "##CC")?;
            unit = source.whole_text(conversion.link(1))?;
        }
        channels.push(Channel {
            name: source.whole_text(channel.link(2))?,
            unit,
            is_time: is_master && channel.u8(1) == SYNC_TIME,
            address: next,
            part: 0,
        });
        let parts = channel.link(1);
        // The components of an array (`CA`) have no names.
        if parts != 0 && depth > 0 && source.any_block(parts)?.mark() == b"##CN" {
            take(source, parts, depth - 1, count, channels)?;
        }
        next = channel.link(0);
    }
    Ok(())
}
