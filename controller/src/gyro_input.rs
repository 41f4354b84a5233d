//! Input from the gyro: takes each sample, detects its faults and tracks how long they last.

use crate::config::{GyroConfig, IntegrationClock};
use crate::heading::{HeadingIntegrator, Reading};
use crate::jump_gate::JumpGate;
use crate::mutant::{Mutant, Planted};
use crate::stuck_watch::{Neighbours, StuckWatch};
use wire::gyro::{GyroOutput, GyroSample, GyroStream};
use wire::time::{Span, Timestamp};

/// Largest error of a gyro's clock: a DSP-3000 is off by 3 % from unit to unit and by 0.2 % with temperature (its
/// manual).
const CLOCK_ERROR_MAX: f64 = 0.032;

/// Faults since the last reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct GyroTrouble {
    pub(crate) over_range: bool,
    pub(crate) invalid: bool,
    pub(crate) lost: bool,
    pub(crate) clock_mismatch: bool,
    pub(crate) temperature: bool,
}

/// Integrator and watches of one gyro.
#[derive(Debug, Clone)]
pub(crate) struct GyroInput {
    config: GyroConfig,
    integrator: HeadingIntegrator,
    heard: Option<Timestamp>,
    good: Option<Timestamp>,
    /// Arrival of the last sample that may have waited during a pause.
    returned: Timestamp,
    /// Arrival of the last sample that certainly did: together with others, or right after a stall of the host.
    waited: Timestamp,
    /// End of the host's last stall.
    stalled: Option<Timestamp>,
    skipped: u16,
    /// Present on a base, whose turn rate is limited.
    gate: Option<JumpGate>,
    stuck: StuckWatch,
    /// Neighbours of the bias test or the rest in progress.
    neighbours: Neighbours,
    /// First ratio of the clocks.
    clock_ratio: Option<f64>,
    /// Whether the clocks differ now.
    clocks_differ: bool,
    temperature_doubtful: bool,
    trouble: GyroTrouble,
    planted: Planted,
}

impl GyroInput {
    pub(crate) fn new(config: GyroConfig, on_base: bool) -> Self {
        let GyroStream { format, mode, .. } = config.stream;
        Self {
            config,
            integrator: HeadingIntegrator::new(&config),
            heard: None,
            good: None,
            returned: Timestamp::ZERO,
            waited: Timestamp::ZERO,
            stalled: None,
            skipped: 0,
            gate: on_base.then(|| JumpGate::new(format.period())),
            stuck: StuckWatch::new(format, mode),
            neighbours: Neighbours::default(),
            clock_ratio: None,
            clocks_differ: false,
            temperature_doubtful: false,
            trouble: GyroTrouble::default(),
            planted: Planted::default(),
        }
    }

    pub(crate) const fn plant(&mut self, planted: Planted) {
        self.planted = planted;
        self.integrator.plant(planted);
    }

    pub(crate) const fn integrator(&self) -> &HeadingIntegrator {
        &self.integrator
    }

    pub(crate) const fn integrator_mut(&mut self) -> &mut HeadingIntegrator {
        &mut self.integrator
    }

    pub(crate) const fn trouble(&self) -> GyroTrouble {
        self.trouble
    }

    /// Clears past faults when a heading is set: they no longer affect it. Faults that persist stay.
    pub(crate) fn forgive(&mut self) {
        self.trouble = GyroTrouble {
            clock_mismatch: self.clocks_differ,
            temperature: self.temperature_doubtful,
            ..GyroTrouble::default()
        };
    }

    /// A rest or a bias test begins: its readings show the effect of the noise.
    pub(crate) fn begin_rest(&mut self) {
        self.neighbours = Neighbours::default();
    }

    /// A bias test at rest ends. Returns true if its readings came from a working gyro, false if it was stuck.
    pub(crate) fn learn_noise(&mut self) -> bool {
        let blind = self.planted.is(Mutant::StuckReadingsBelieved);
        let was_stuck = self.stuck.learn(core::mem::take(&mut self.neighbours)) && !blind;
        self.trouble.invalid |= was_stuck;
        !was_stuck
    }

    /// True if the readings were stuck throughout the last bias test: it showed none of the noise of the present rest.
    pub(crate) fn was_stuck_in_test(&self) -> bool {
        self.stuck.was_stuck(self.neighbours) && !self.planted.is(Mutant::StuckReadingsBelieved)
    }

    /// The host stalled until `now`.
    pub(crate) const fn hear_of_stall(&mut self, now: Timestamp) {
        self.stalled = Some(now);
    }

    /// True until the first sample.
    pub(crate) const fn is_starting(&self) -> bool {
        self.heard.is_none()
    }

    /// True if no sample arrived within the time-out.
    pub(crate) fn is_silent(&self, now: Timestamp) -> bool {
        self.is_silent_for(now, self.config.timeout)
    }

    /// True if no sample arrived within `span`.
    pub(crate) fn is_silent_for(&self, now: Timestamp, span: Span) -> bool {
        self.last_of_use().is_none_or(|last| now - last > span)
    }

    /// Earliest time at which [`Self::is_silent_for`] can become true.
    pub(crate) fn silent_for_at(&self, span: Span) -> Timestamp {
        self.last_of_use().map_or(Timestamp::MAX, |last| last + span + Span::from_nanos(1))
    }

    /// The last sample. What bridges a silence bridges invalid samples as well: they are none then.
    fn last_of_use(&self) -> Option<Timestamp> {
        if self.integrator.carries_across_stalls() { self.good } else { self.heard }
    }

    /// The last sample is the newest possible one, or the one before it.
    pub(crate) fn is_fresh(&self, now: Timestamp) -> bool {
        !self.is_silent_for(now, self.config.stream.format.period() * 2)
    }

    /// True if a good sample arrived after those that ended a pause: a stalled host receives all waiting samples at once,
    /// and their age is unknown.
    pub(crate) fn is_current(&self) -> bool {
        self.good.is_some_and(|last| last > self.returned)
    }

    /// True if the last sample was one of several that a stalled host received at once, or the only one: it may be as old
    /// as the stall was long.
    pub(crate) fn has_waited(&self) -> bool {
        self.last_of_use().is_some_and(|last| last <= self.waited)
    }

    /// True if a sample that arrives at `now` follows one that ended a pause faster than a gyro sends: it has waited too.
    /// A host reads what waited in pieces, each a little later than the one before.
    fn follows_at_once(&self, now: Timestamp) -> bool {
        let half = self.config.stream.format.period() / 2;
        self.heard.is_some_and(|last| last == self.returned && now - last < half)
    }

    /// Samples arrive, but none has been valid for too long, or all are equal.
    pub(crate) fn is_invalid(&self, now: Timestamp) -> bool {
        let since = |last: Option<Timestamp>, span| last.is_none_or(|last| now - last > span);
        let none_valid = since(self.good, self.config.invalid_max);
        !since(self.heard, self.config.timeout) && (none_valid || self.is_stuck())
    }

    pub(crate) fn is_stuck(&self) -> bool {
        self.stuck.is_stuck()
            && !self.planted.is(Mutant::StuckReadingsBelieved)
            && !self.planted.blinds_second_looks()
    }

    /// Earliest time at which [`Self::is_silent`] can become true.
    pub(crate) fn silent_at(&self) -> Timestamp {
        // One nanosecond later: a sample exactly at the limit is still in time.
        self.silent_for_at(self.config.timeout)
    }

    /// Takes a sample; returns a reading if the sample is good.
    // A reading is large: inlining avoids copying it from function to function.
    #[inline(always)]
    pub(crate) fn take(&mut self, now: Timestamp, sample: &GyroSample) -> Option<Reading> {
        // Samples that waited less make no heading older than one and a half time-outs.
        let short = self.config.timeout / 2;
        let follows = self.follows_at_once(now);
        let returns = self.is_silent_for(now, short);
        if follows || (returns && self.stalled.is_some_and(|end| now - end < short)) {
            self.waited = now;
        }
        if follows || returns {
            self.returned = now;
        }
        if self.is_silent(now)
            && !self.integrator.carries_across_stalls()
            && let Some(gate) = &mut self.gate
        {
            gate.restart();
        }
        self.heard = Some(now);
        let whole = sample.valid && !sample.status.built_in_test_failed;
        let usable = whole
            && is_finite(sample.output)
            && (self.gate.as_mut().is_none_or(|gate| gate.believes(now, sample.output))
                || self.planted.is(Mutant::JumpBelieved));
        if !usable {
            self.trouble.invalid = true;
            self.skipped = self.skipped.saturating_add(1);
            return None;
        }
        self.trouble.over_range |=
            sample.status.over_range && !self.planted.is(Mutant::OverRangeIgnored);
        self.good = Some(now);
        let reading = self.integrator.sample(now, sample, core::mem::take(&mut self.skipped));
        if reading.after_silence {
            self.stuck.restart();
        }
        if let Some(rate) = reading.measured {
            self.neighbours.add(self.stuck.sample(rate));
        }
        self.trouble.lost |= reading.lost > 0 || reading.missing || reading.after_silence;
        self.trouble.temperature |= reading.temperature_doubtful;
        self.temperature_doubtful = reading.temperature_doubtful;
        if let Some(ratio) = reading.clock_ratio {
            self.compare_clocks(ratio, sample.output);
        }
        Some(reading)
    }

    fn compare_clocks(&mut self, ratio: f64, output: GyroOutput) {
        let first = *self.clock_ratio.get_or_insert(ratio);
        self.clocks_differ = match (output, self.config.clock) {
            (GyroOutput::Rate(_), IntegrationClock::Samples) => {
                (ratio - 1.0).abs() > self.config.clock_mismatch_max
            }
            // A clock error within the manual's limits does no harm here. A clock that changes points to something
            // else, such as uncounted samples.
            _ => {
                (ratio - 1.0).abs() > CLOCK_ERROR_MAX
                    || (ratio - first).abs() > self.config.clock_mismatch_max
            }
        };
        self.trouble.clock_mismatch |= self.clocks_differ;
    }

    /// Call after all samples that arrived at once.
    pub(crate) fn took(&mut self) {
        self.trouble.invalid |= self.is_stuck();
    }
}

fn is_finite(output: GyroOutput) -> bool {
    match output {
        GyroOutput::Rate(rate) => rate.is_finite(),
        GyroOutput::Increment(angle) | GyroOutput::Integrated(angle) => angle.is_finite(),
    }
}

#[cfg(test)]
mod tests {
    use super::{GyroConfig, GyroInput, GyroOutput, GyroSample, Timestamp};
    use wire::gyro::GyroStatus;
    use wire::time::Span;
    use wire::units::AngularRate;

    /// A stalled host reads what waited in pieces; the age of each is unknown, however late its piece was read.
    #[test]
    fn what_waited_is_not_current_in_whatever_pieces_it_is_read() {
        let mut input = GyroInput::new(GyroConfig::default(), true);
        let mut current = |micros: i64| {
            input.take(Timestamp::ZERO + Span::from_micros(micros), &sample(true));
            input.is_current()
        };
        current(10_000);
        assert!(current(20_000));
        for piece in 0..40 {
            assert!(!current(1_020_000 + piece * 300), "piece {piece}");
        }
        assert!(current(1_041_700), "one that came by itself");
        assert!(current(1_042_000), "and what the line bunches then");
    }

    /// One sample alone shows its age to a host that was awake: nothing came before it.
    #[test]
    fn a_sample_alone_has_waited_only_if_the_host_stalled() {
        let second = |stalled: bool| {
            let mut input = GyroInput::new(GyroConfig::default(), true);
            let at = |millis| Timestamp::ZERO + Span::from_millis(millis);
            input.take(at(10), &sample(true));
            if stalled {
                input.hear_of_stall(at(40_000));
            }
            input.take(at(40_001), &sample(true));
            let waited = input.has_waited();
            input.take(at(40_011), &sample(true));
            assert!(!input.has_waited() && input.is_current(), "the next one came by itself");
            waited
        };
        assert!(second(true) && !second(false));
    }

    /// What turns the heading is the last good sample: one that is invalid makes the heading no younger.
    #[test]
    fn an_invalid_sample_after_a_pause_is_not_current() {
        let mut input = GyroInput::new(GyroConfig::default(), true);
        let mut current = |micros: i64, valid: bool| {
            input.take(Timestamp::ZERO + Span::from_micros(micros), &sample(valid));
            input.is_current()
        };
        current(10_000, true);
        assert!(current(20_000, true));
        assert!(!current(1_020_000, true), "the last of those that waited");
        assert!(!current(1_030_000, false));
        assert!(current(1_040_000, true));
    }

    fn sample(valid: bool) -> GyroSample {
        GyroSample {
            output: GyroOutput::Rate(AngularRate::ZERO),
            valid,
            status: GyroStatus::default(),
            temperature: None,
            sequence: None,
        }
    }
}
