//! Walks the groups and channels of a file.

use super::super::error::LogError;
use super::BLOCK_HEAD_BYTES;
use super::blocks::{Block, Source};

/// Limits for the groups and channels of a file: one with every message of a large DBC has thousands of groups.
const GROUPS_MAX: usize = 65_536;
const CHANNELS_MAX: usize = 262_144;
/// Most levels of nested structures.
pub(super) const DEPTH_MAX: u32 = 3;

/// What takes each channel.
type EachChannel<'e> = &'e mut dyn FnMut(&mut Source<'_>, &Block) -> Result<(), LogError>;

/// Passes on each data group from that one on, with its channel groups.
pub(super) fn data_groups(
    source: &mut Source<'_>,
    first: u64,
    mut each: impl FnMut(&mut Source<'_>, &Block, Vec<Block>) -> Result<(), LogError>,
) -> Result<(), LogError> {
    let (mut next, mut count) = (first, 0);
    while next != 0 {
        let block = source.block(next, "##DG")?;
        let mut groups = Vec::new();
        let mut next_group = block.link(1);
        while next_group != 0 {
            let group = source.block(next_group, "##CG")?;
            count += 1;
            bounded(source, next_group, count, GROUPS_MAX)?;
            next_group = group.link(0);
            groups.push(group);
        }
        // A data group without channel groups also counts.
        count += 1;
        bounded(source, next, count, 2 * GROUPS_MAX)?;
        let number_bytes = block.u8(0);
        if !matches!(number_bytes, 0 | 1 | 2 | 4 | 8) || (number_bytes == 0 && groups.len() > 1) {
            let found = format!("{number_bytes} bytes for {} groups", groups.len());
            return source.bad(next, "record numbers of 0, 1, 2, 4 or 8 bytes", found);
        }
        each(source, &block, groups)?;
        next = block.link(0);
    }
    Ok(())
}

/// Passes on each channel from that one on; components follow their structures.
pub(super) fn channels(
    source: &mut Source<'_>,
    first: u64,
    depth: u32,
    count: &mut usize,
    each: EachChannel<'_>,
) -> Result<(), LogError> {
    let mut next = first;
    while next != 0 {
        *count += 1;
        bounded(source, next, *count, CHANNELS_MAX)?;
        let channel = source.block(next, "##CN")?;
        each(source, &channel)?;
        // The components of an array (`CA`) have no names.
        let parts = channel.link(1);
        if parts != 0 && depth > 0 && source.any_block(parts)?.mark() == b"##CN" {
            channels(source, parts, depth - 1, count, each)?;
        }
        next = channel.link(0);
    }
    Ok(())
}

/// Refuses more groups or channels than `most`.
pub(super) fn bounded(
    source: &Source<'_>,
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
    source.bad(address, "a file with fewer groups or channels", found)
}
