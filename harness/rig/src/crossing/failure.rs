//! Failures of a crossing.

use super::Toward;
use std::io;

/// Something did not come out as it was sent.
#[derive(Debug, thiserror::Error)]
#[error("failed to carry {what} across {medium}: {how}")]
pub struct CrossingFailure {
    /// Such as `bytes from the gyro`.
    what: String,
    /// A pty or an interface.
    medium: String,
    how: How,
}

#[derive(Debug, thiserror::Error)]
pub enum How {
    #[error("it cannot be written to: {0}")]
    Write(io::Error),
    /// The kernel accepted only a part.
    #[error("it took {taken} of {length} bytes")]
    Full { taken: usize, length: usize },
    #[error("it cannot be read: {0}")]
    Read(io::Error),
    /// Not all of it came out in time.
    #[error("{heard} of {sent} came out within {limit_s} s")]
    Late {
        /// What had come out by then: `nothing` or a number of bytes.
        heard: String,
        sent: String,
        /// Wall-clock time, s.
        limit_s: f64,
    },
    /// Something else came out.
    #[error("{sent} went in and {heard} came out; does another program use it?")]
    Changed { sent: String, heard: String },
}

impl CrossingFailure {
    /// A failure of bytes or frames (`goods`) on `line`.
    pub fn new(goods: &str, line: &str, toward: Toward, medium: &str, how: How) -> Self {
        let way = match toward {
            Toward::Device => "to",
            Toward::Host => "from",
        };
        Self { what: format!("{goods} {way} the {line}"), medium: medium.to_owned(), how }
    }

    pub const fn how(&self) -> &How {
        &self.how
    }
}
