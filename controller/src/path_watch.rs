//! Does the base go as far as it is told?
//!
//! The base follows the velocities that it is sent, so that what they add up to and what its odometer says differ by
//! little: an odometer that stands still, or jumps, shows in that difference.

use wire::time::Timestamp;
use wire::units::{Length, Speed};

/// At rest both may differ by this. Assumption: a third of the paper's 10 cm square.
const APART_MAX: Length = Length::from_m(0.03);
/// And by this share of the path. Assumption.
const APART_SHARE_MAX: f64 = 0.01;
/// On the way the base lags behind by this as well. Assumption: 0.15 s at its top speed of 0.78 m/s.
const LAG_MAX: Length = Length::from_m(0.12);

/// Watches one drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct PathWatch {
    /// Where the odometer stood at the beginning.
    from: Length,
    told: Length,
    last: Option<(Timestamp, Speed)>,
}

impl PathWatch {
    /// A drive that begins where the odometer says `from`.
    pub(crate) fn new(from: Length) -> Self {
        Self { from, ..Self::default() }
    }

    /// The base is told to drive at `speed` from `now` on.
    pub(crate) fn tell(&mut self, now: Timestamp, speed: Speed) {
        if let Some((since, before)) = self.last.replace((now, speed)) {
            self.told += before * (now - since);
        }
    }

    /// A base on its way says `displacement`: can that be?
    pub(crate) fn could_be_on_the_way(&self, displacement: Length) -> bool {
        self.apart(displacement) <= self.apart_max() + LAG_MAX
    }

    /// A base at rest says `displacement`: can that be?
    pub(crate) fn could_be_there(&self, displacement: Length) -> bool {
        self.apart(displacement) <= self.apart_max()
    }

    fn apart(&self, displacement: Length) -> Length {
        (displacement - self.from - self.told).abs()
    }

    fn apart_max(&self) -> Length {
        APART_MAX + self.told.abs() * APART_SHARE_MAX
    }
}

#[cfg(test)]
mod tests {
    use super::{Length, PathWatch, Speed, Timestamp};
    use wire::time::Span;

    /// Told to drive at 0.4 m/s for `seconds`; how far the odometer got is for the caller to say.
    fn driven(seconds: i64) -> PathWatch {
        let mut watch = PathWatch::new(Length::from_m(7.0));
        for millis in (0..seconds * 1_000).step_by(25) {
            let now = Timestamp::ZERO + Span::from_millis(millis);
            watch.tell(now, Speed::from_m_per_s(0.4));
        }
        watch.tell(Timestamp::ZERO + Span::from_secs(seconds), Speed::ZERO);
        watch
    }

    #[test]
    fn an_odometer_that_stood_still_or_jumped_shows() {
        let watch = driven(10);
        let at = |m: f64| Length::from_m(7.0 + m);
        assert!(watch.could_be_there(at(4.0)) && watch.could_be_there(at(3.94)));
        assert!(!watch.could_be_there(at(3.9)) && !watch.could_be_there(at(4.5)));
        assert!(watch.could_be_on_the_way(at(3.9)) && !watch.could_be_on_the_way(at(3.6)));
    }
}
