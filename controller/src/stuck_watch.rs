//! Detects a gyro that repeats the same reading.
//!
//! A sensor's own noise keeps its counts moving. Each bias test counts how often two consecutive readings are equal;
//! from this share follows how many in a row can be equal by chance. The longest run of a test is compared with the
//! rest of it, which reveals a gyro that stuck during the test. A gyro without noise, or with counts coarser than its
//! noise, repeats itself when all is well: the watch is then off, and only the comparison with the odometry remains. If
//! such a gyro shows noise at a later rest, it was stuck throughout the test.

use wire::gyro::{GyroFormat, OutputMode};
use wire::time::Span;
use wire::units::AngularRate;

/// Probability that a run of equal readings starting at a given sample is a false alarm: at 100 Hz one in 30,000 h, at
/// 1000 Hz one in 3,000 h.
const FALSE_ALARM: f64 = 1e-10;
/// With a larger share of equal neighbours the noise is too small for the counts to show it.
const ALIKE_SHARE_MAX: f64 = 0.25;
/// Shorter runs never count, however fine the counts. Assumption: a twentieth of a second does no harm.
const SPAN_MIN: Span = Span::from_millis(50);
/// Minimum number of pairs in a test to compute the share.
const PAIRS_MIN: u32 = 50;
/// Minimum number of pairs at a later rest to tell noise from none: half of the 0.3 s in which a base settles, at 100 Hz.
const PAIRS_AT_REST_MIN: u32 = 15;

/// Counts equal neighbours, in a test and in a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StuckWatch {
    period: Span,
    /// Readings that differ by no more are equal: an angle rounds a constant rate up or down.
    alike: AngularRate,
    last: Option<AngularRate>,
    in_a_row: u32,
    /// Run length that counts as stuck; `None` before a test has shown the noise.
    too_many: Option<u32>,
    /// The last test showed no noise at all.
    silent: bool,
}

/// Neighbours of one bias test, or of one rest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Neighbours {
    pairs: u32,
    alike: u32,
    /// Equal pairs in a row: current and longest.
    row: u32,
    longest: u32,
}

impl StuckWatch {
    pub(crate) fn new(format: GyroFormat, mode: OutputMode) -> Self {
        let period = format.period();
        let alike = match mode {
            OutputMode::Rate => AngularRate::ZERO,
            // A format without angles never sends them.
            OutputMode::Increment | OutputMode::Integrated => {
                format.facts().angle_step.unwrap_or_default() * 1.5 / period
            }
        };
        Self { period, alike, last: None, in_a_row: 0, too_many: None, silent: false }
    }

    /// Takes a valid sample; returns true if it equals the previous one.
    pub(crate) fn sample(&mut self, rate: AngularRate) -> bool {
        let alike = self.last.is_some_and(|last| (rate - last).abs() <= self.alike);
        self.last = Some(rate);
        self.in_a_row = if alike { self.in_a_row.saturating_add(1) } else { 1 };
        alike
    }

    /// The readings have been equal for longer than noise allows.
    pub(crate) fn is_stuck(&self) -> bool {
        self.too_many.is_some_and(|too_many| self.in_a_row >= too_many)
    }

    /// Takes the neighbours of a finished bias test. Returns true if the readings were stuck during it.
    pub(crate) fn learn(&mut self, neighbours: Neighbours) -> bool {
        self.too_many = neighbours.too_many(self.period);
        self.silent = neighbours.beside_longest() < PAIRS_MIN && neighbours.longest >= PAIRS_MIN;
        // A run of readings has one pair less.
        self.too_many.is_some_and(|too_many| neighbours.longest + 1 >= too_many)
    }

    /// True if the last test showed no noise and this rest does: the readings were stuck throughout the test.
    pub(crate) fn was_stuck(&self, at_rest: Neighbours) -> bool {
        let alike = f64::from(at_rest.alike);
        let varies = alike <= f64::from(at_rest.pairs) * ALIKE_SHARE_MAX;
        self.silent && at_rest.pairs >= PAIRS_AT_REST_MIN && varies
    }

    /// Starts a new run.
    pub(crate) const fn restart(&mut self) {
        self.last = None;
        self.in_a_row = 0;
    }
}

impl Neighbours {
    pub(crate) fn add(&mut self, alike: bool) {
        self.pairs = self.pairs.saturating_add(1);
        self.alike = self.alike.saturating_add(u32::from(alike));
        self.row = if alike { self.row.saturating_add(1) } else { 0 };
        self.longest = self.longest.max(self.row);
    }

    /// Pairs outside the longest run.
    const fn beside_longest(self) -> u32 {
        self.pairs.saturating_sub(self.longest)
    }

    /// Uses the pairs outside the longest run, which may not be noise at all.
    fn too_many(self, period: Span) -> Option<u32> {
        let pairs = self.beside_longest();
        if pairs < PAIRS_MIN {
            return None;
        }
        let alike = f64::from(self.alike.saturating_sub(self.longest));
        // Two standard deviations above the count.
        let share = (alike + 2.0 * libm::sqrt(alike + 1.0)) / f64::from(pairs);
        if share > ALIKE_SHARE_MAX {
            return None;
        }
        // For normal noise, the likeliest count has sqrt 2 times the probability of two equal readings.
        let likeliest = share * core::f64::consts::SQRT_2;
        let by_chance = 1.0 + libm::log(FALSE_ALARM) / libm::log(likeliest);
        let shortest = SPAN_MIN.as_secs_f64() / period.as_secs_f64();
        Some(libm::ceil(by_chance.max(shortest)) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::{AngularRate, GyroFormat, Neighbours, OutputMode, StuckWatch};

    /// `alike` of `pairs`, evenly distributed.
    fn noise(pairs: u32, alike: u32) -> Neighbours {
        let mut neighbours = Neighbours::default();
        (0..pairs).for_each(|n| neighbours.add(n * alike / pairs != (n + 1) * alike / pairs));
        neighbours
    }

    fn learnt(pairs: u32, alike: u32) -> StuckWatch {
        let mut watch = StuckWatch::new(GyroFormat::Navigator, OutputMode::Rate);
        assert!(!watch.learn(noise(pairs, alike)));
        watch
    }

    fn alike_until_stuck(watch: &mut StuckWatch) -> Option<u32> {
        watch.restart();
        (1..1_000).find(|_| {
            watch.sample(AngularRate::from_deg_per_s(30.0));
            watch.is_stuck()
        })
    }

    #[test]
    fn the_noise_of_the_test_says_how_many_are_too_many() {
        // The Navigator's: 0.0138 deg/s of noise in counts of 0.00305 deg/s, 6.2 % of neighbours alike.
        assert_eq!(alike_until_stuck(&mut learnt(2_000, 125)), Some(12));
        assert_eq!(
            alike_until_stuck(&mut learnt(2_000, 0)),
            Some(5),
            "50 ms, however fine the counts"
        );
    }

    #[test]
    fn a_gyro_that_sticks_during_the_test_is_told_from_one_without_noise() {
        let mut watch = StuckWatch::new(GyroFormat::Navigator, OutputMode::Rate);
        for (alike, expected) in [(9, false), (11, true), (1_000, true)] {
            let mut test = noise(1_000, 62);
            (0..alike).for_each(|_| test.add(true));
            assert_eq!(watch.learn(test), expected, "{alike} alike pairs at the end");
        }
        assert!(!watch.learn(noise(2_000, 2_000)), "without noise");
    }

    #[test]
    fn without_noise_alike_readings_say_nothing() {
        assert_eq!(alike_until_stuck(&mut learnt(2_000, 2_000)), None);
        assert_eq!(alike_until_stuck(&mut learnt(10, 0)), None, "too short a test");
    }

    #[test]
    fn a_test_without_noise_is_doubted_at_a_rest_that_has_some() {
        let watch = learnt(2_000, 2_000);
        assert!(watch.was_stuck(noise(15, 1)), "the Navigator's noise");
        assert!(!watch.was_stuck(noise(14, 1)), "too few");
        assert!(!watch.was_stuck(noise(15, 11)), "it settles, and is as even as before");
        assert!(!learnt(2_000, 125).was_stuck(noise(15, 1)), "there was noise in the test as well");
        assert!(!learnt(10, 0).was_stuck(noise(15, 1)), "too short a test");
    }

    #[test]
    fn one_that_differs_begins_anew() {
        let mut watch = learnt(2_000, 125);
        for n in 0..1_000 {
            watch.sample(AngularRate::from_deg_per_s(if n % 12 == 0 { 1.0 } else { 2.0 }));
            assert!(!watch.is_stuck());
        }
    }
}
