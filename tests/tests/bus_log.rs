//! Exchange of bus logs with independent programs: they read what we write, and we read what they write.
//!
//! A missing program is not a failure: the test prints `skipped: ...` and how to install it.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod can_utils;
mod python;
mod rows;
