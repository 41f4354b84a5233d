//! From gyro samples to heading: subtracts the bias, applies Eq. 4's factors and a model's corrections, and integrates
//! over time.

use crate::bump_watch::BumpWatch;
use crate::calibration::Calibration;
use crate::clock_watch::ClockWatch;
use crate::config::{GyroConfig, IntegrationClock, TEMPERATURE_MAX, TEMPERATURE_MIN};
use crate::correction::{Sum, Watch};
use crate::loss_watch::LossWatch;
use crate::mutant::{self, Mutant, Planted};
use crate::silence::{Silence, Silences};
use crate::temperature_watch::TemperatureWatch;
use wire::gyro::{GyroOutput, GyroSample, Sequence};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Temperature};

/// Averaging time of the temperature before it sets the correction: the temperature changes by less than 0.01 K
/// meanwhile, and the sensor's noise does not reach the heading.
const TEMPERATURE_UPDATE: Span = Span::from_secs(1);

/// One decoded sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Reading {
    /// Raw rate: nominally scaled, with only the calibration's bias terms subtracted.
    pub(crate) raw_rate: AngularRate,
    /// Measured rate; `None` if the sample is a repetition.
    pub(crate) measured: Option<AngularRate>,
    /// Temperature, if the sample has a credible one.
    pub(crate) temperature: Option<Temperature>,
    /// Samples lost before this one.
    pub(crate) lost: u16,
    /// More samples are missing than the sequence numbers show.
    pub(crate) missing: bool,
    /// The silence before it was too long to be bridged.
    pub(crate) after_silence: bool,
    /// The samples of the silence before it are on their way, or it bridged them itself.
    pub(crate) stalled: bool,
    /// Result of a clock comparison that ended with this sample.
    pub(crate) clock_ratio: Option<f64>,
    /// Its temperature, or the mean of the last second, cannot be true.
    pub(crate) temperature_doubtful: bool,
    /// The gyro turned by more than its bias while the heading was held.
    pub(crate) pushed: bool,
}

/// Integrates corrected samples to a heading that is not wrapped.
#[derive(Debug, Clone)]
pub(crate) struct HeadingIntegrator {
    clock: IntegrationClock,
    period: Span,
    silence_max: Span,
    heading: Angle,
    held: bool,
    silences: Silences,
    bias: AngularRate,
    calibration: Calibration,
    corrections: Watch,
    gain_ccw: f64,
    gain_cw: f64,
    temperature: Option<Temperature>,
    temperature_sum: f64,
    temperature_count: u32,
    temperature_due: Timestamp,
    temperature_watch: TemperatureWatch,
    bumps: BumpWatch,
    last_arrival: Option<Timestamp>,
    last_rate: AngularRate,
    last_sequence: Option<Sequence>,
    last_integrated: Option<Angle>,
    watch: ClockWatch,
    losses: LossWatch,
    samples: u64,
    samples_lost: u64,
    planted: Planted,
}

impl HeadingIntegrator {
    pub(crate) fn new(config: &GyroConfig) -> Self {
        let period = config.stream.format.period();
        Self {
            clock: config.clock,
            period,
            silence_max: config.timeout,
            heading: Angle::ZERO,
            held: false,
            silences: Silences::default(),
            bias: AngularRate::ZERO,
            calibration: Calibration::default(),
            corrections: Watch::default(),
            gain_ccw: 1.0,
            gain_cw: 1.0,
            temperature: None,
            temperature_sum: 0.0,
            temperature_count: 0,
            temperature_due: Timestamp::ZERO,
            temperature_watch: TemperatureWatch::default(),
            bumps: BumpWatch::default(),
            last_arrival: None,
            last_rate: AngularRate::ZERO,
            last_sequence: None,
            last_integrated: None,
            watch: ClockWatch::new(period),
            losses: LossWatch::new(period),
            samples: 0,
            samples_lost: 0,
            planted: Planted::default(),
        }
    }

    pub(crate) const fn plant(&mut self, planted: Planted) {
        self.planted = planted;
    }

    pub(crate) const fn heading(&self) -> Angle {
        self.heading
    }

    pub(crate) const fn set_heading(&mut self, heading: Angle) {
        self.heading = heading;
    }

    /// Holds the heading constant: what the gyro reads on a stationary robot is bias, not rotation.
    pub(crate) const fn hold(&mut self, held: bool) {
        self.held = held;
    }

    pub(crate) const fn is_held(&self) -> bool {
        self.held
    }

    /// From now on, a silence after which no number is missing counts as a delay of the line, and a short one is
    /// bridged by its neighbours.
    pub(crate) const fn carry_across_stalls(&mut self, carries: bool) {
        self.silences.carry(carries);
    }

    pub(crate) const fn carries_across_stalls(&self) -> bool {
        self.silences.carries()
    }

    /// Sets the heading from another source while the gyro is silent.
    pub(crate) fn bridge_to(&mut self, heading: Angle) {
        self.silences.begins(self.heading);
        self.heading = heading;
    }

    /// Last rate.
    pub(crate) fn rate(&self) -> AngularRate {
        self.last_rate - self.bias
    }

    pub(crate) const fn bias(&self) -> AngularRate {
        self.bias
    }

    pub(crate) const fn set_bias(&mut self, bias: AngularRate) {
        self.bias = bias;
    }

    pub(crate) const fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    pub(crate) fn set_calibration(&mut self, calibration: Calibration) {
        if calibration.corrections != self.calibration.corrections {
            self.corrections.begin(&calibration.corrections);
        }
        self.calibration = calibration;
        self.update_gains();
    }

    pub(crate) const fn temperature(&self) -> Option<Temperature> {
        self.temperature
    }

    pub(crate) const fn samples(&self) -> u64 {
        self.samples
    }

    pub(crate) const fn samples_lost(&self) -> u64 {
        self.samples_lost
    }

    pub(crate) const fn clock_ratio(&self) -> Option<f64> {
        self.watch.ratio()
    }

    /// Marks a silence that was too long: the rotation during it is unknown and is not bridged.
    pub(crate) fn lose_track(&mut self) {
        self.last_arrival = None;
        self.last_sequence = None;
        self.last_integrated = None;
        self.bumps.restart();
        self.watch.restart();
        self.losses.restart();
    }

    /// Takes a valid sample that arrived at `now`, after `skipped` invalid ones. In a stream without sequence numbers
    /// these count as lost.
    #[inline(always)]
    pub(crate) fn sample(&mut self, now: Timestamp, sample: &GyroSample, skipped: u16) -> Reading {
        if self.silences.is_overtaken(now, self.period) {
            self.last_sequence = sample.sequence;
            return Reading { raw_rate: self.last_rate, ..Reading::default() };
        }
        let lasted = self.last_arrival.map_or(Span::ZERO, |last| now - last);
        let silence = Silence { lasted, period: self.period };
        let after_silence = lasted > self.silence_max;
        let stalled =
            after_silence && self.silences.is_known(silence, self.last_sequence, sample.sequence);
        if after_silence && !stalled {
            self.samples_lost += silence.lost(self.last_sequence, sample.sequence);
            self.lose_track();
        }
        if let Some(heading) = self.silences.ends(now, stalled, sample.sequence.is_some()) {
            self.heading = heading;
        }
        let lost = match (sample.sequence, self.last_sequence) {
            (Some(_), Some(_)) if self.planted.is(Mutant::MissedSequenceGap) => 0,
            (Some(this), Some(last)) => {
                let lost = this.lost_since(last);
                if lost == 0 || self.has_room_for(now, lost) {
                    lost
                } else if this == last && !self.planted.is(Mutant::RepeatedSampleCounted) {
                    return Reading { raw_rate: self.last_rate, ..Reading::default() };
                } else {
                    0
                }
            }
            (None, _) if stalled => silence.due(),
            (None, _) if self.last_arrival.is_some() => skipped,
            _ => 0,
        };
        self.last_sequence = sample.sequence;
        self.corrections.hear(now);
        let temperature =
            sample.temperature.filter(|t| (TEMPERATURE_MIN..=TEMPERATURE_MAX).contains(t));
        let out_of_range = temperature != sample.temperature;
        let wild = temperature.is_some_and(|temperature| {
            self.temperature_watch.sample(now, temperature, sample.status.warming_up);
            !self.average_temperature(now, temperature)
        });
        let temperature_doubtful = out_of_range || wild || self.temperature_watch.is_frozen();
        let first = self.last_arrival.is_none();
        let spans = i64::from(lost) + 1;
        let period_s = self.period.as_secs_f64();
        let raw_rate = match sample.output {
            GyroOutput::Rate(rate) => rate,
            GyroOutput::Increment(angle) => angle / self.period,
            GyroOutput::Integrated(angle) => {
                let turned =
                    self.last_integrated.map_or(Angle::ZERO, |last| (angle - last).wrapped());
                self.last_integrated = Some(angle);
                turned / (self.period * spans)
            }
        };
        // Lost samples are bridged with the mean of their neighbours; an integrated angle lost none.
        let bridge = match sample.output {
            GyroOutput::Integrated(_) => raw_rate,
            _ => (raw_rate + self.last_rate) * 0.5,
        };
        let step = if first || lost == 0 {
            let span_s = match (self.clock, sample.output, self.last_arrival) {
                (IntegrationClock::HostTime, GyroOutput::Rate(_), Some(last)) => {
                    (now - last).as_secs_f64()
                }
                _ => period_s,
            };
            self.corrected(now, raw_rate) * span_s
        } else {
            let bridged = self.corrected(now, bridge) * f64::from(lost);
            (self.corrected(now, raw_rate) + bridged) * period_s
        };
        let less_known = raw_rate - self.known_bias(now, raw_rate);
        let pushed = self.held && self.bumps.turns(Angle::from_rad(step), self.period * spans);
        if !self.held {
            self.bumps.restart();
            self.heading += Angle::from_rad(step);
            if self.planted.is(Mutant::OverflowAfterLongRuns) {
                self.heading = Angle::from_rad(mutant::in_32_bits(self.heading.rad()));
            }
        }
        self.last_arrival = Some(now);
        self.last_rate = raw_rate;
        self.samples += 1;
        self.samples_lost += u64::from(lost);
        let clock_ratio = self.watch.sample(now, lost);
        if let Some(ratio) = clock_ratio {
            self.losses.compared(ratio);
        }
        let missing = self.losses.sample(now, lost)
            && !self.planted.is(Mutant::MissedSequenceGap)
            && !self.planted.blinds_second_looks();
        Reading {
            raw_rate: less_known,
            measured: Some(raw_rate),
            temperature,
            lost,
            missing,
            after_silence: after_silence && !stalled,
            stalled,
            clock_ratio,
            temperature_doubtful: temperature_doubtful
                && !self.planted.is(Mutant::TemperatureBelieved),
            pushed: pushed && !self.planted.is(Mutant::BumpIgnored),
        }
    }

    /// True if `lost` samples can have been due since the last arrival. A sequence number that claims more is repeated
    /// or wrong, and bridging it would turn the heading for nothing. A host that delivers in bunches may let samples
    /// seem simultaneous, so the limit of silence is allowed on top.
    fn has_room_for(&self, now: Timestamp, lost: u16) -> bool {
        self.last_arrival
            .is_some_and(|last| self.period * i64::from(lost) <= (now - last) + self.silence_max)
    }

    /// rad/s
    fn corrected(&self, now: Timestamp, raw: AngularRate) -> f64 {
        let rate = raw.rad_per_s() - self.bias.rad_per_s();
        if self.calibration.corrections.is_empty() {
            return rate * self.gain(rate);
        }
        let sum = self.sum(now, rate, self.bias);
        let rate = rate - sum.bias;
        rate * self.gain(rate) / sum.scale
    }

    /// The part of the bias that the calibration's terms explain.
    fn known_bias(&self, now: Timestamp, raw: AngularRate) -> AngularRate {
        if self.calibration.corrections.is_empty() {
            return AngularRate::ZERO;
        }
        // A bias test computes the new bias from this: it must not contain the old one.
        let sum = self.sum(now, raw.rad_per_s() - self.bias.rad_per_s(), AngularRate::ZERO);
        AngularRate::from_rad_per_s(sum.bias)
    }

    fn sum(&self, now: Timestamp, less_bias: f64, tested_bias: AngularRate) -> Sum {
        let terms = &self.calibration.corrections;
        self.corrections
            .sum(now, terms, less_bias, self.heading, tested_bias, |rate| self.gain(rate))
    }

    /// The factors of Eq. 4 for the direction of `rate`.
    const fn gain(&self, rate: f64) -> f64 {
        if rate < 0.0 { self.gain_cw } else { self.gain_ccw }
    }

    /// Returns false if the mean of the last second cannot be true; that mean is not used.
    fn average_temperature(&mut self, now: Timestamp, temperature: Temperature) -> bool {
        self.temperature_sum += temperature.celsius();
        self.temperature_count += 1;
        if now < self.temperature_due {
            return true;
        }
        let mean = self.temperature_sum / f64::from(self.temperature_count);
        let mean = Temperature::from_celsius(mean);
        self.temperature_sum = 0.0;
        self.temperature_count = 0;
        self.temperature_due = now + TEMPERATURE_UPDATE;
        let believed = self.temperature_watch.believes(now, mean);
        if believed || self.planted.is(Mutant::TemperatureBelieved) {
            self.temperature = Some(mean);
            self.corrections.tell(now, mean, &self.calibration.corrections);
            if self.calibration.needs_temperature() {
                self.update_gains();
            }
        }
        believed
    }

    fn update_gains(&mut self) {
        let ccw = AngularRate::from_rad_per_s(1.0);
        self.gain_ccw = self.calibration.gain(self.temperature, ccw);
        if self.planted.is(Mutant::CcwSign) {
            self.gain_ccw = 2.0 - self.gain_ccw;
        }
        self.gain_cw = self.calibration.gain(self.temperature, -ccw);
        if self.planted.is(Mutant::SwappedDirections) {
            core::mem::swap(&mut self.gain_cw, &mut self.gain_ccw);
        }
        if self.planted.is(Mutant::FirstFactorAlone) {
            let mut first = self.calibration.clone();
            first.factors.truncate(1);
            self.gain_ccw = first.gain(self.temperature, ccw);
            self.gain_cw = first.gain(self.temperature, -ccw);
        }
    }
}

#[cfg(test)]
mod tests;
