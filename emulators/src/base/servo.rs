//! How drive and steering follow the commanded rate.
//!
//! A servo of finite gain works against friction, and friction varies on the way: bearings, teeth, the floor. Where friction
//! differs from what the servo expects, the speed is off by that difference over the gain, whatever the speed
//! (`drive_noise_m_per_s`). It is held for [`NOISE_HELD`] and drawn anew. It does not turn a drive round: at low speed it is
//! limited to the commanded rate, which lets the drive stick or go twice as fast.
//!
//! Below some speed the servo does not overcome static friction at all (`drive_stiction_m_per_s`): a drive that is commanded less
//! does not begin to move, and one that slows down below it stands at once. Encoders sit on the motors and see all of this.

use super::ramp::Ramp;
use wire::time::Span;

/// For so long the noise of a rate is held (assumption: the response time of such a servo).
pub(super) const NOISE_HELD: Span = Span::from_millis(100);

/// One axis; SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Servo {
    /// Slowest rate that is kept up.
    pub(super) slowest: f64,
    /// How much faster it goes than commanded, until the next draw; negative where it goes slower.
    pub(super) faster: f64,
}

impl Servo {
    /// The first time at which it follows `commanded` in another way than now.
    pub(super) fn changes_after(self, commanded: &Ramp) -> Option<Span> {
        let levels = [self.slowest, self.faster.abs()].into_iter().filter(|level| *level > 0.0);
        levels.filter_map(|level| commanded.passes(level)).min()
    }

    /// What it does under `commanded`, while that is about `rate`.
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
