//! Groups and channels of a file.

use super::super::super::error::LogError;
use super::super::blocks::{Block, Source};
use super::super::unsorted::{Lengths, is_variable, lengths};
use super::super::walk::{self, DEPTH_MAX};
use super::super::{CG_REMOTE_MASTER, CN_MASTER, CN_VIRTUAL_MASTER};
use std::collections::HashMap;
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
    /// Those of all groups among these records.
    pub(super) lengths: Lengths,
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
pub(super) fn all(source: &mut Source<'_>, first: u64) -> Result<Vec<Group>, LogError> {
    let (mut all, mut channels) = (Vec::<Group>::new(), 0);
    // Groups whose times are in that one, in the order of the file.
    let mut columns: Vec<(u64, Group)> = Vec::new();
    walk::data_groups(source, first, |source, block, groups| {
        let lengths = lengths(&groups);
        // Records of variable length are values of channels of other groups.
        for block_of_group in groups.iter().filter(|group| !is_variable(group)) {
            let group = group_of(source, block_of_group, block, &lengths, &mut channels)?;
            match block_of_group.u16(16) & CG_REMOTE_MASTER {
                0 => all.push(group),
                _ => columns.push((block_of_group.link(6), group)),
            }
        }
        Ok(())
    })?;
    join(source, &mut all, columns)?;
    Ok(all)
}

/// Adds channels that are stored by themselves to the groups that have their times.
fn join(
    source: &Source<'_>,
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
            return source.bad(address, "a group with as many times", found);
        };
        let parts = group.parts.len();
        group.parts.extend(column.parts);
        group
            .channels
            .extend(column.channels.into_iter().map(|channel| Channel { part: parts, ..channel }));
    }
    Ok(())
}

fn group_of(
    source: &mut Source<'_>,
    block: &Block,
    data_group: &Block,
    lengths: &Lengths,
    count: &mut usize,
) -> Result<Group, LogError> {
    let mut channels = Vec::new();
    walk::channels(source, block.link(1), DEPTH_MAX, count, &mut |source, channel| {
        channels.push(channel_of(source, channel)?);
        Ok(())
    })?;
    let part = Part {
        address: block.address,
        data: data_group.link(2),
        number_bytes: usize::from(data_group.u8(0)),
        number: block.u64(0),
        value_bytes: u64::from(block.u32(24)),
        invalid_bytes: u64::from(block.u32(28)),
        lengths: Arc::clone(lengths),
    };
    let name = source.text(block.link(2))?;
    Ok(Group { name, channels, records: block.u64(8), parts: vec![part] })
}

fn channel_of(source: &mut Source<'_>, channel: &Block) -> Result<Channel, LogError> {
    let is_master = matches!(channel.u8(0), CN_MASTER | CN_VIRTUAL_MASTER);
    let mut unit = source.text(channel.link(6))?;
    let conversion = channel.link(4);
    if unit.is_empty() && conversion != 0 {
        let conversion = source.block(conversion, "##CC")?;
        unit = source.text(conversion.link(1))?;
    }
    Ok(Channel {
        name: source.text(channel.link(2))?,
        unit,
        is_time: is_master && channel.u8(1) == SYNC_TIME,
        address: channel.address,
        part: 0,
    })
}
