//! The lease on a bench that people share.

use super::failure::Failure;
use super::progress::Screen;
use crate::who::user;
use harness::stopwatch::Stopwatch;
use live::lease::{Holder, Lease, Leased, folder};
use live::unix_time::unix_s;
use plan::bench_file::BenchFile;
use std::time::Duration;

/// How often one that another holds is asked for again.
const ASK_AGAIN: Duration = Duration::from_millis(200);
/// Kept of the command line.
const COMMAND_CHARS_MAX: usize = 200;

fn holder() -> Holder {
    let words: Vec<_> = std::env::args_os().skip(1).collect();
    let words: Vec<_> = words.iter().map(|word| word.to_string_lossy()).collect();
    let command = format!("hil {}", words.join(" "));
    Holder {
        who: user().unwrap_or_else(|| format!("user {}", rustix::process::getuid().as_raw())),
        pid: std::process::id(),
        since_unix_s: unix_s().unwrap_or_default(),
        command: command.chars().take(COMMAND_CHARS_MAX).collect(),
    }
}

/// Takes the lease on the bench of that name; waits up to that time if another user holds it. `None`, with a notice, if
/// this machine has no folder for leases.
///
/// # Errors
///
/// If another user still holds it then, or `stopped` is true.
#[expect(clippy::disallowed_methods, reason = "a bench that others use is waited for in real time")]
pub(super) fn take(
    (name, bench): (&str, &BenchFile),
    wait_s: u32,
    stopped: &dyn Fn() -> bool,
    screen: &Screen,
) -> Result<Option<Lease>, Failure> {
    let (folder, leased) = (folder(), Leased::of(name, bench));
    let stopwatch = Stopwatch::start();
    let mut is_told = false;
    loop {
        let taken = match Lease::take(&folder, &leased, &holder()) {
            Ok(Ok(lease)) => return Ok(Some(lease)),
            Ok(Err(taken)) => taken.told(unix_s().unwrap_or_default()),
            Err(error) => {
                tracing::warn!(
                    "others may use the bench {name} meanwhile, it has no lease: {error}"
                );
                return Ok(None);
            }
        };
        if stopped() || stopwatch.elapsed_s() >= f64::from(wait_s) {
            let help = match wait_s {
                0 => "add --wait SECONDS to wait for it".to_owned(),
                _ => format!("--wait {wait_s} was not long enough"),
            };
            return Err(Failure::arguments(format!("the bench {name} is in use: {taken}"), help));
        }
        if !is_told {
            screen.note(&format!("waiting for the bench {name}: {taken}"));
            is_told = true;
        }
        std::thread::sleep(ASK_AGAIN);
    }
}
