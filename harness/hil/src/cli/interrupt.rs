//! Ctrl-C and a request to terminate: the first ends the run in order, the second at once.

use super::failure::Failure;
use super::progress::Screen;
use harness::stopwatch::Stopwatch;
use record::outcome::Outcome;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A signal so soon after the first is the same request: `timeout -s INT` sends one to us, and one to our process group.
/// Assumption: nobody presses two keys in this time.
const SAME_REQUEST_S: f64 = 0.2;

/// Tells whether the user wants the run to end.
#[derive(Debug, Clone)]
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Takes over the signals; once per process.
    pub(super) fn install(screen: &Screen) -> Result<Self, Failure> {
        let what = "stopping in order; once more to leave at once";
        Self::install_saying(screen, what)
    }

    /// Takes over the signals, with another message.
    pub(super) fn install_saying(screen: &Screen, what: &'static str) -> Result<Self, Failure> {
        let requested = Arc::new(AtomicBool::new(false));
        let (flag, screen) = (Arc::clone(&requested), screen.clone());
        let mut first: Option<Stopwatch> = None;
        ctrlc::set_handler(move || {
            if !flag.swap(true, Ordering::Relaxed) {
                first = Some(Stopwatch::start());
                screen.note(what);
            } else if first.is_none_or(|first| first.elapsed_s() > SAME_REQUEST_S) {
                leave_at_once();
            }
        })
        .map_err(Failure::signals)?;
        Ok(Self(requested))
    }

    /// Requests the end from a key with the same meaning.
    pub(super) fn request(&self) {
        if self.0.swap(true, Ordering::Relaxed) {
            leave_at_once();
        }
    }

    /// Set once the end is requested.
    pub(super) fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0)
    }

    pub(super) fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Restores the terminal, ends what this process has started, and leaves.
fn leave_at_once() -> ! {
    live::process::kill_all();
    super::watch::terminal::give_back_at_once();
    std::process::exit(i32::from(Outcome::Aborted.exit_status()));
}
