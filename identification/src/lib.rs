//! Models of a gyro and of a drive, and how measured data change them.
//!
//! Nothing here reads a file or a clock, and nothing depends on the source of the data.

#![expect(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "what is not a number must take the other branch"
)]
#![expect(clippy::needless_range_loop, reason = "loops go over several columns at once")]

mod assemble;
mod candidates;
mod clipping;
pub mod compensation;
mod corrections;
pub mod dataset;
mod done;
mod error;
pub mod experiment;
pub mod finding;
mod fit;
pub mod identify;
mod judge;
mod late;
mod linear;
pub mod model;
mod noise;
mod options;
pub mod outcome;
mod outliers;
mod problem;
mod robust;
mod rounding;
mod select;
mod set_right;
mod settling;
mod signal;
mod significance;
mod still;
pub mod units;
mod unreferenced;
mod untold;
