//! How drive and steering follow the commanded rates.
//!
//! A servo of finite gain works against friction, and friction varies along the way: bearings, teeth, the floor. If
//! friction differs from what the servo expects, the speed is off by that difference over the gain, at any speed
//! (`drive_noise_m_per_s`). The error is held for [`NOISE_HELD`] and then redrawn. It never reverses a drive: at low
//! speed it is limited to the commanded rate, so that the drive sticks or runs twice as fast.
//!
//! Below some speed the servo does not overcome static friction at all (`drive_stiction_m_per_s`): a drive with a
//! lower command does not start, and one that slows down below it stops at once. The encoders sit on the motors and
//! see all of this.

use super::ramp::Ramp;
use wire::time::Span;

/// Hold time of the noise of a rate (assumption: the response time of such a servo).
pub(super) const NOISE_HELD: Span = Span::from_millis(100);

/// One axis; SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Servo {
    /// Slowest rate that it sustains.
    pub(super) slowest: f64,
    /// Excess of the rate over the commanded one until the next draw; negative if slower.
    pub(super) faster: f64,
}

impl Servo {
    /// The first time at which its response to `commanded` changes.
    pub(super) fn changes_after(self, commanded: &Ramp) -> Option<Span> {
        let levels = [self.slowest, self.faster.abs()].into_iter().filter(|level| *level > 0.0);
        levels.filter_map(|level| commanded.passes(level)).min()
    }

    /// Its response to `commanded` while that is about `rate`.
    pub(super) fn follow(self, commanded: &Ramp, rate: f64) -> Ramp {
        if self == Self::default() || commanded.is_at_rest() {
            *commanded
        } else if rate.abs() < self.slowest {
            Ramp::default()
        } else if rate.abs() < self.faster.abs() {
            if self.faster > 0.0 { commanded.scaled(2.0) } else { Ramp::default() }
        } else {
            commanded.raised(self.faster.copysign(self.faster * rate))
        }
    }
}
