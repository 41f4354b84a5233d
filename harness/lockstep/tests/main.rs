//! Programs in virtual time, one subject a file.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod can;
mod common;
mod hour;
mod odd;
mod other_machine;
mod serial;
mod static_ends;
mod static_programs;
mod talks;
mod waits;
mod wall_clock;
