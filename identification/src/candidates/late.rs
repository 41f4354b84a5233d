//! How late what is measured comes, at first sight.

use crate::late::{self, Stretch};
use crate::problem::{Aggregate, Block, Channels};

/// The delay (negative: a lead), s, at which the moved rotation leaves least of the readings of `block`; `None` if no delay
/// takes away much.
pub(super) fn delay(block: &Block, channels: &Channels) -> Option<f64> {
    if block.aggregate != Aggregate::Row {
        return None;
    }
    let of = |range: &std::ops::Range<usize>| Stretch {
        times: &channels.time[range.clone()],
        truth: &channels.rotation[range.clone()],
        readings: Vec::new(),
    };
    let mut stretches: Vec<Stretch<'_>> = channels.segments.iter().map(of).collect();
    let mut stretch = 0;
    for (&row, &error) in block.rows.iter().zip(&block.residual) {
        while channels.segments.get(stretch)?.end <= row {
            stretch += 1;
        }
        let at = row - channels.segments[stretch].start;
        stretches[stretch].readings.push((at, error + channels.rotation[row]));
    }
    late::delay(&stretches, channels.interval())
}
