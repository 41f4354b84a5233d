//! What a silence of the gyro's line was: short enough for its neighbours to bridge it, a delay of the line, or a loss.

use crate::config::INTERPOLATED_MAX;
use wire::gyro::Sequence;
use wire::time::{Span, Timestamp};
use wire::units::Angle;

/// Samples by which the number due in a silence is uncertain. Assumption: no sample arrives 50 ms later than the others.
const UNSURE: u16 = 5;

/// The last silence, for an estimator that bridges it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Silences {
    /// Tell them apart; otherwise each one is a loss.
    carries: bool,
    /// Heading at the start of a silence that is being bridged.
    before: Option<Angle>,
    /// When a bridge ended.
    bridged_to: Option<Timestamp>,
}

/// A silence that ends with a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Silence {
    pub(crate) lasted: Span,
    pub(crate) period: Span,
}

impl Silences {
    pub(crate) const fn carry(&mut self, carries: bool) {
        self.carries = carries;
    }

    pub(crate) const fn carries(&self) -> bool {
        self.carries
    }

    /// The heading is bridged from `heading` on.
    pub(crate) fn begins(&mut self, heading: Angle) {
        self.before.get_or_insert(heading);
    }

    /// A silence ends at `now`. Returns the heading before it if it was bridged and its samples are `known`. If they are
    /// not `numbered`, those that arrive at the same time may be its own.
    pub(crate) fn ends(&mut self, now: Timestamp, known: bool, numbered: bool) -> Option<Angle> {
        let before = self.before.take();
        let unknown = before.is_some() && !known;
        if unknown || (known && !numbered) {
            self.bridged_to = Some(now);
        }
        before.filter(|_| known)
    }

    /// True if a sample that arrives at `now` was taken before the end of a bridge: those that waited on the line arrive
    /// all at once.
    pub(crate) fn is_overtaken(&mut self, now: Timestamp, period: Span) -> bool {
        let Some(bridged_to) = self.bridged_to else { return false };
        let overtaken = now - bridged_to < period / 2;
        if !overtaken {
            self.bridged_to = None;
        }
        overtaken
    }

    /// True if the rotation during the silence follows from samples: from its neighbours, or from those on their way.
    pub(crate) fn is_known(
        &self,
        silence: Silence,
        before: Option<Sequence>,
        after: Option<Sequence>,
    ) -> bool {
        self.carries && (silence.is_short() || silence.is_delay(before, after))
    }
}

impl Silence {
    /// Samples that were due during it.
    pub(crate) fn due(self) -> u16 {
        let periods = libm::round(self.lasted.as_secs_f64() / self.period.as_secs_f64());
        (periods - 1.0).clamp(0.0, f64::from(u16::MAX)) as u16
    }

    /// Samples lost in it: as many as were due, or by the numbers of its neighbours, which wrap, nearly as many.
    pub(crate) fn lost(self, before: Option<Sequence>, after: Option<Sequence>) -> u64 {
        let due = i64::from(self.due());
        let (Some(before), Some(after)) = (before, after) else { return due.unsigned_abs() };
        let (lost, modulus) =
            (i64::from(after.lost_since(before)), i64::from(after.modulus.max(1)));
        let wraps = (due - lost + modulus / 2).div_euclid(modulus).max(0);
        (lost + wraps * modulus).unsigned_abs()
    }

    fn is_short(self) -> bool {
        self.lasted <= INTERPOLATED_MAX
    }

    /// True if the numbers show most of its samples as not lost: they must be on their way. Numbers wrap: had all been
    /// lost, the number would follow from the samples due.
    fn is_delay(self, before: Option<Sequence>, after: Option<Sequence>) -> bool {
        let (Some(before), Some(after)) = (before, after) else { return false };
        let (lost, modulus) = (after.lost_since(before), after.modulus.max(1));
        let apart = (self.due() % modulus).abs_diff(lost);
        let all_lost = apart.min(modulus - apart) <= UNSURE;
        !all_lost && self.period * i64::from(lost) * 2 < self.lasted
    }
}

#[cfg(test)]
mod tests {
    use super::{Angle, Sequence, Silence, Silences, Span, Timestamp};

    const PERIOD: Span = Span::from_millis(10);

    fn is_known(lasted_ms: i64, lost: u16) -> bool {
        let mut silences = Silences::default();
        silences.carry(true);
        let number = |value: u16| Some(Sequence { value: value as u8, modulus: 256 });
        let silence = Silence { lasted: Span::from_millis(lasted_ms), period: PERIOD };
        silences.is_known(silence, number(200), number(201 + lost))
    }

    #[test]
    fn a_delay_shows_by_numbers_that_go_on() {
        for (lasted_ms, lost, known) in [
            (240, 23, true),
            (260, 25, false),
            (260, 0, true),
            (2_500, 249, false),
            (2_510, 0, true),
            // All 256 or none: unknown.
            (2_570, 0, false),
            (2_700, 0, true),
            (2_700, 13, false),
            (5_000, 0, true),
            (5_130, 0, false),
            (9_000, 0, true),
            (9_000, 131, false),
        ] {
            assert_eq!(is_known(lasted_ms, lost), known, "{lasted_ms} ms, {lost} lost");
        }
    }

    #[test]
    fn what_was_lost_is_counted_by_time_and_numbers() {
        let number = |value: u8| Some(Sequence { value, modulus: 256 });
        let lost = |lasted_ms, before, after| {
            Silence { lasted: Span::from_millis(lasted_ms), period: PERIOD }.lost(before, after)
        };
        assert_eq!(lost(500, None, None), 49);
        for (lasted_ms, between, expected) in [
            (500, 49, 49),
            (500, 47, 47),
            (500, 0, 0),
            (2_700, 13, 269),
            (2_570, 0, 256),
            (7_800, 10, 778),
        ] {
            let after = number(201u8.wrapping_add(between));
            assert_eq!(lost(lasted_ms, number(200), after), expected, "{lasted_ms} ms, {between}");
        }
    }

    #[test]
    fn what_waited_during_a_bridge_is_overtaken() {
        let mut silences = Silences::default();
        let at = |ms| Timestamp::ZERO + Span::from_millis(ms);
        assert!(!silences.is_overtaken(at(0), PERIOD));
        silences.begins(Angle::ZERO);
        assert_eq!(silences.ends(at(400), false, true), None);
        assert!(silences.is_overtaken(at(400), PERIOD) && silences.is_overtaken(at(403), PERIOD));
        assert!(!silences.is_overtaken(at(410), PERIOD) && !silences.is_overtaken(at(411), PERIOD));
        silences.begins(Angle::from_deg(3.0));
        assert_eq!(silences.ends(at(500), true, true), Some(Angle::from_deg(3.0)));
        assert!(!silences.is_overtaken(at(500), PERIOD), "they are taken, not bridged");
        assert_eq!(silences.ends(at(700), true, false), None);
        assert!(silences.is_overtaken(at(700), PERIOD), "the neighbours bridged them");
    }
}
