//! Skipped tests: a test whose machine lacks something reports the reason and the remedy, and is counted.
//!
//! The test runner captures the output of a passing test. These messages bypass it.

mod bus;
mod in_time;

pub use bus::{CAN_REQUIRED, Vcan0, how as in_guest};
pub use in_time::in_time;

use std::fmt::Display;
use std::io::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};

static SKIPPED: AtomicUsize = AtomicUsize::new(0);

/// Like [`skip`], but fails if the environment variable `required` is set.
///
/// # Panics
///
/// When it is set: a test must then fail instead of being skipped.
#[track_caller]
pub fn skip_unless(required: &str, why: impl Display, how: impl Display) {
    assert!(std::env::var_os(required).is_none(), "{why}; {how}");
    skip(why, how);
}

/// Reports that the calling test is skipped, `why`, and `how` it would run.
pub fn skip(why: impl Display, how: impl Display) {
    let count = SKIPPED.fetch_add(1, Ordering::Relaxed) + 1;
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    // A single write, so that lines of parallel tests do not mix.
    let line = line(test, &why, &how, count);
    // If stderr is closed, the message is lost.
    let _ = std::io::stderr().write_all(line.as_bytes());
}

fn line(test: &str, why: &dyn Display, how: &dyn Display, count: usize) -> String {
    format!("\nskipped: {test}: {why} ({how}); {count} skipped in this binary so far\n")
}

#[cfg(test)]
mod tests {
    use super::line;

    #[test]
    fn a_line_names_the_test_the_reason_the_way_and_the_count() {
        assert_eq!(
            line("a_base_on_can", &"no vcan0", &"in the guest", 3),
            "\nskipped: a_base_on_can: no vcan0 (in the guest); 3 skipped in this binary so far\n"
        );
    }
}
