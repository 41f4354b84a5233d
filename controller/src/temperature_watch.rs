//! Checks that the gyro's reported temperature is credible.
//!
//! A coil in its housing takes half an hour to follow. The controller does not use a temperature outside the range of
//! the sensor, or one that moves faster than any housing permits; and while a gyro reports that it is warming up, its
//! temperature must rise sooner or later.
//!
//! A temperature that is frozen while the gyro is steady cannot be detected here: the noise of the sensor is unknown,
//! and a sensor without noise stands still for hours. It does harm only when the room temperature changes.

use wire::time::{Span, Timestamp};
use wire::units::Temperature;

/// Fastest change of the mean of a second, K/s. Assumption: fifty times the 20 K in 35 min of a warm-up.
const KELVIN_PER_S_MAX: f64 = 0.5;
/// Longest standstill of the temperature during warm-up. A gyro one kelvin from steady warms by 1 K in 35 min, a step
/// of a 0.1 K sensor in 3.5 min; assumption: nearly half as much again.
const STILL_MAX: Span = Span::from_secs(300);
/// The same before the first step: a cold gyro warms by 20 K in 35 min, by a step in 11 s. Assumption: six times that, in which
/// it warms by 0.6 K and its scale changes by 0.08 %. One that is switched on again nearly warm is doubtful until its first step.
const STILL_AT_FIRST: Span = Span::from_secs(60);
/// Each step of a warm-up takes longer than the one before, by at most a tenth; assumption: three times, and no less than this.
const LONGER: i64 = 3;
const STILL_MIN: Span = Span::from_secs(30);

/// Checks each mean of a second.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct TemperatureWatch {
    credible: Option<(Timestamp, Temperature)>,
    doubtful: Option<(Timestamp, Temperature)>,
    /// The last reported temperature, and since when it has stood still during warm-up.
    said: Option<(Timestamp, Temperature)>,
    /// How long it stood still before its last step.
    stood: Option<Span>,
    is_frozen: bool,
}

impl TemperatureWatch {
    /// True if the mean at `now` is credible. A second mean that agrees with a rejected one is accepted.
    pub(crate) fn believes(&mut self, now: Timestamp, mean: Temperature) -> bool {
        let told = (now, mean);
        let near = |before: Option<(Timestamp, Temperature)>| {
            before.is_some_and(|(at, last)| {
                let passed_s = (now - at).as_secs_f64().max(1.0);
                (mean - last).abs().celsius() <= KELVIN_PER_S_MAX * passed_s
            })
        };
        let believed = self.credible.is_none() || near(self.credible) || near(self.doubtful);
        if believed {
            (self.credible, self.doubtful) = (Some(told), None);
        } else {
            self.doubtful = Some(told);
        }
        believed
    }

    /// Takes the temperature of a sample.
    pub(crate) fn sample(&mut self, now: Timestamp, said: Temperature, warming_up: bool) {
        let same = self.said.is_some_and(|(_, last)| last == said);
        if !same || (!warming_up && !self.is_frozen) {
            if !same {
                self.stood = self.said.map(|(since, _)| now - since);
            }
            self.said = Some((now, said));
        }
        let most = self
            .stood
            .map_or(STILL_AT_FIRST, |stood| (stood * LONGER).max(STILL_MIN).min(STILL_MAX));
        self.is_frozen = same && self.said.is_some_and(|(since, _)| now - since > most);
    }

    /// True if the temperature stands still during warm-up; cleared when it moves.
    pub(crate) const fn is_frozen(&self) -> bool {
        self.is_frozen
    }
}

#[cfg(test)]
mod tests {
    use super::{Temperature, TemperatureWatch, Timestamp};

    fn at(s: u32) -> Timestamp {
        Timestamp::from_secs_f64(f64::from(s))
    }

    fn frozen_at(celsius: impl Fn(u32) -> f64, warming_up: impl Fn(u32) -> bool) -> Option<u32> {
        let mut watch = TemperatureWatch::default();
        (0..7_200).find(|&s| {
            watch.sample(at(s), Temperature::from_celsius(celsius(s)), warming_up(s));
            watch.is_frozen()
        })
    }

    #[test]
    fn a_warm_up_in_coarse_steps_is_no_freeze() {
        // 20 K in 35 min, the flag on until 1 K is left, steps of 0.1 K.
        let kelvin = |s: u32| 20.0 * (1.0 - (-f64::from(s) / 2_100.0).exp());
        let steps = |s| (kelvin(s) * 10.0).round() / 10.0;
        assert_eq!(frozen_at(steps, |s| kelvin(s) < 19.0), None);
        assert_eq!(frozen_at(|_| 22.0, |s| kelvin(s) < 19.0), Some(61));
        // It warmed by a step in 11 s, and then no more.
        let stands = frozen_at(|s| steps(s.min(100)), |s| kelvin(s) < 19.0);
        assert!(stands.is_some_and(|s| (110..140).contains(&s)), "{stands:?}");
        assert_eq!(frozen_at(|_| 22.0, |_| false), None, "steady: it may well be so");
    }

    #[test]
    fn a_freeze_is_not_over_when_the_flag_goes_out() {
        let mut watch = TemperatureWatch::default();
        for s in 0..1_000 {
            watch.sample(at(s), Temperature::from_celsius(22.0), s < 400);
        }
        assert!(watch.is_frozen());
        watch.sample(at(1_000), Temperature::from_celsius(22.1), false);
        assert!(!watch.is_frozen());
    }

    #[test]
    fn one_wild_mean_is_let_go_and_a_step_that_stays_is_not() {
        let mut watch = TemperatureWatch::default();
        let mut believes = |s, celsius| watch.believes(at(s), Temperature::from_celsius(celsius));
        assert!(believes(0, 25.0) && believes(1, 25.3));
        assert!(!believes(2, 31.0) && believes(3, 25.2));
        assert!(!believes(4, 40.0) && believes(5, 40.1));
    }
}
