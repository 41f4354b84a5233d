//! Groups and channels of a file.

use super::super::super::error::{Defect, LogError};
use super::super::blocks::{Block, Source};
use super::super::chain::column_oriented;
use super::super::groups::{CHANNELS_MAX, DEPTH_MAX, GROUPS_MAX, bounded};
use super::super::{CG_REMOTE_MASTER, CG_VARIABLE, CN_MASTER, CN_VIRTUAL_MASTER};
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
    pub(super) address: u64,
    /// Address of its data.
    pub(super) data: u64,
    /// Length of the record number before each record, and the group's own number.
    pub(super) number_bytes: usize,
    pub(super) number: u64,
    /// Bytes of values in a record, and of the invalidation bits after them.
    pub(super) value_bytes: u64,
    pub(super) invalid_bytes: u64,
    /// Numbers and record lengths of all groups among these records, by number; no length if their records state it.
    pub(super) others: Arc<[(u64, Option<u64>)]>,
}

/// A channel of a group.
#[derive(Debug)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// Unit of its values in the file; empty without a unit.
    pub unit: String,
    /// Whether it is the time of the group's records, in seconds.
    pub is_time: bool,
    pub(super) address: u64,
}

/// Reads all groups from that data group on, with their channels.
pub(super) fn all<R: Read + Seek>(
    source: &mut Source<R>,
    first: u64,
) -> Result<Vec<Group>, LogError> {
    let (mut all, mut next, mut blocks, mut channels) = (Vec::<Group>::new(), first, 0, 0);
    while next != 0 {
        let block = source.block(next, "##DG")?;
        let number_bytes = usize::from(block.u8(0));
        let begin = all.len();
        let mut next_group = block.link(1);
        let mut lengths = Vec::new();
        while next_group != 0 {
            let group = source.block(next_group, "##CG")?;
            let one = group_of(source, &group, &block, &mut channels)?;
            let is_variable = group.u16(16) & CG_VARIABLE != 0;
            lengths
                .push((one.number, (!is_variable).then_some(one.value_bytes + one.invalid_bytes)));
            blocks += 1;
            bounded(source, next_group, blocks, GROUPS_MAX)?;
            // Records of variable length are values of channels of other groups.
            if !is_variable {
                all.push(one);
            }
            next_group = group.link(0);
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
        for group in &mut all[begin..] {
            group.others = Arc::clone(&others);
        }
        // A data group without channel groups also counts, as links may form a cycle.
        blocks += 1;
        bounded(source, next, blocks, 2 * GROUPS_MAX)?;
        next = block.link(0);
    }
    Ok(all)
}

fn group_of<R: Read + Seek>(
    source: &mut Source<R>,
    block: &Block,
    data_group: &Block,
    count: &mut usize,
) -> Result<Group, LogError> {
    if block.u16(16) & CG_REMOTE_MASTER != 0 {
        return Err(source.malformed(block.address, column_oriented(b"a group without times")));
    }
    let mut channels = Vec::new();
    take(source, block.link(1), DEPTH_MAX, count, &mut channels)?;
    Ok(Group {
        name: source.whole_text(block.link(2))?,
        channels,
        records: block.u64(8),
        address: block.address,
        data: data_group.link(2),
        number_bytes: usize::from(data_group.u8(0)),
        number: block.u64(0),
        value_bytes: u64::from(block.u32(24)),
        invalid_bytes: u64::from(block.u32(28)),
        others: Arc::default(),
    })
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
