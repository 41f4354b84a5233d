//! Bus logs before other people's programs: what is written here is read there, and the other way round.
//!
//! A program that is not there is no reason to fail: the test says `skipped: ...` and how to get it.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod can_utils;
mod python;
mod rows;
