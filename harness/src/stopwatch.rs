//! The one reader of the wall clock in a simulated run: how long it took, which judges nothing.

use std::time::Instant;

/// Runs since it was started.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// From now on.
    #[expect(clippy::disallowed_methods, reason = "tells people how long a run took, nothing else")]
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// How long it has run, s.
    pub fn elapsed_s(self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}
