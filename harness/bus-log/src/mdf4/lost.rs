//! The data of a file that was cut before the lists of their blocks.

use super::super::error::LogError;
use super::IDENTIFICATION_BYTES;
use super::blocks::Source;
use super::chain::Chain;
use super::groups::DataGroup;

/// The data of each group. Where the list of the blocks is lost, they are those that lie in the file, as far as it is
/// certain whose they are: if several groups have data, a block is of the one of whose records alone it has a whole
/// number. Such data end with the error that the file is cut.
///
/// # Errors
/// When the file cannot be read.
pub(super) fn chains(
    source: &mut Source<'_>,
    (groups, has_others): (&[DataGroup], bool),
    is_unfinished: bool,
) -> Result<Vec<Chain>, LogError> {
    let mut chains: Vec<_> =
        groups.iter().map(|group| Chain::new(group.data, is_unfinished)).collect();
    let held: Vec<usize> = (0..groups.len()).filter(|index| groups[*index].data != 0).collect();
    let is_lost = |index: &usize| source.any_block(groups[*index].data).is_err();
    let lost: Vec<usize> = held.iter().copied().filter(is_lost).collect();
    // Blocks of measured values may look like any.
    if lost.is_empty() || has_others {
        return Ok(chains);
    }
    let mut shares = vec![Vec::new(); groups.len()];
    let mut address = IDENTIFICATION_BYTES as u64;
    loop {
        let block = match source.any_block(address) {
            Ok(block) => block,
            Err(LogError::Malformed { .. }) => break,
            Err(error) => return Err(error),
        };
        if let Some(bytes) = block.record_bytes() {
            let mut owners =
                held.iter().filter(|index| held.len() == 1 || groups[**index].may_fill(bytes));
            match (owners.next(), owners.next()) {
                (Some(owner), None) => shares[*owner].push(address),
                (Some(_), Some(_)) => break,
                // The blocks of that file do not end with a record.
                (None, _) => return Ok(chains),
            }
        }
        let end = address.saturating_add(block.length);
        address = end.checked_next_multiple_of(8).unwrap_or(u64::MAX);
    }
    for index in lost {
        let blocks = std::mem::take(&mut shares[index]);
        chains[index] = Chain::without_list(groups[index].data, blocks, address);
    }
    Ok(chains)
}

impl DataGroup {
    /// Whether so many bytes may be whole records.
    fn may_fill(&self, bytes: u64) -> bool {
        match self.lengths[..] {
            [(_, Some(length))] if self.number_bytes == 0 => bytes.checked_rem(length) == Some(0),
            _ => true,
        }
    }
}
