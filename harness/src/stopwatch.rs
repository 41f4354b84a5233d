//! The only reader of the wall clock in a simulated run: measures its duration, which no verdict uses.

use std::time::Instant;

/// Measures time since its start.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts the stopwatch.
    #[expect(clippy::disallowed_methods, reason = "tells people how long a run took, nothing else")]
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Elapsed time, s.
    pub fn elapsed_s(self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}
