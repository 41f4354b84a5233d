//! The gyro's port: bytes to samples, what is wrong with them, and how long it has been so.

use crate::config::GyroConfig;
use crate::heading::{HeadingIntegrator, Reading};
use crate::mutant::{Mutant, Planted};
use wire::gyro::{GyroDecoder, GyroOutput};
use wire::time::Timestamp;
use wire::units::Angle;

/// What has gone wrong since it was last forgiven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct GyroTrouble {
    pub(crate) over_range: bool,
    pub(crate) invalid: bool,
    pub(crate) lost: bool,
    pub(crate) clock_mismatch: bool,
}

/// Decoder, integrator and watches of one gyro.
#[derive(Debug, Clone)]
pub(crate) struct GyroInput {
    config: GyroConfig,
    decoder: GyroDecoder,
    integrator: HeadingIntegrator,
    heard: Option<Timestamp>,
    good: Option<Timestamp>,
    skipped: u16,
    trouble: GyroTrouble,
    planted: Planted,
}

impl GyroInput {
    pub(crate) fn new(config: GyroConfig) -> Self {
        Self {
            config,
            decoder: GyroDecoder::new(config.stream),
            integrator: HeadingIntegrator::new(&config),
            heard: None,
            good: None,
            skipped: 0,
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

    /// A bias test passed: what went wrong before it no longer touches the heading from here on.
    pub(crate) fn forgive(&mut self) {
        self.trouble =
            GyroTrouble { clock_mismatch: self.trouble.clock_mismatch, ..GyroTrouble::default() };
    }

    /// Has any sample been heard yet?
    pub(crate) const fn is_starting(&self) -> bool {
        self.heard.is_none()
    }

    /// No sample at all within the time-out.
    pub(crate) fn is_silent(&self, now: Timestamp) -> bool {
        self.heard.is_none_or(|heard| now - heard > self.config.timeout)
    }

    /// Samples come, and none has been valid for too long.
    pub(crate) fn is_invalid(&self, now: Timestamp) -> bool {
        !self.is_silent(now) && self.good.is_none_or(|good| now - good > self.config.invalid_max)
    }

    /// When [`Self::is_silent`] may become true.
    pub(crate) fn silent_at(&self) -> Timestamp {
        // One nanosecond late: the limit itself is still in time.
        let margin = wire::time::Span::from_nanos(1);
        self.heard.map_or(Timestamp::MAX, |heard| heard + self.config.timeout + margin)
    }

    /// Takes bytes and hands each good reading, with the angle it added, to `deliver`.
    pub(crate) fn receive(
        &mut self,
        now: Timestamp,
        bytes: &[u8],
        mut deliver: impl FnMut(Reading, Angle),
    ) {
        let Self { decoder, integrator, heard, good, skipped, trouble, config, planted } = self;
        decoder.feed(bytes, |sample| {
            *heard = Some(now);
            if !sample.valid || sample.status.built_in_test_failed || !is_finite(sample.output) {
                trouble.invalid = true;
                *skipped = skipped.saturating_add(1);
                return;
            }
            trouble.over_range |= sample.status.over_range && !planted.is(Mutant::OverRangeIgnored);
            *good = Some(now);
            let before = integrator.heading();
            let reading = integrator.sample(now, &sample, core::mem::take(skipped));
            trouble.lost |= reading.lost > 0 || reading.missing || reading.after_silence;
            if let Some(ratio) = reading.clock_ratio {
                trouble.clock_mismatch = (ratio - 1.0).abs() > config.clock_mismatch_max;
            }
            deliver(reading, integrator.heading() - before);
        });
    }
}

fn is_finite(output: GyroOutput) -> bool {
    match output {
        GyroOutput::Rate(rate) => rate.is_finite(),
        GyroOutput::Increment(angle) | GyroOutput::Integrated(angle) => angle.is_finite(),
    }
}
