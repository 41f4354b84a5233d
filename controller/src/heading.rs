//! From gyro samples to heading: bias off, Eq. 4's factors on, summed over time.

use crate::calibration::Calibration;
use crate::clock_watch::ClockWatch;
use crate::config::{GyroConfig, IntegrationClock, TEMPERATURE_MAX, TEMPERATURE_MIN};
use wire::gyro::{GyroOutput, GyroSample, Sequence};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Temperature};

/// Temperature is averaged over this long before it sets the correction: it changes by less than
/// 0.01 K meanwhile, and a sensor's noise does not reach the heading.
const TEMPERATURE_UPDATE: Span = Span::from_secs(1);

/// One sample, understood.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Reading {
    /// Raw rate: nominally scaled, nothing subtracted.
    pub(crate) raw_rate: AngularRate,
    /// Temperature, if the sample has a credible one.
    pub(crate) temperature: Option<Temperature>,
    /// Samples lost before this one.
    pub(crate) lost: u16,
    /// Silence before it was too long to be bridged.
    pub(crate) after_silence: bool,
    /// A comparison of the clocks ended with this sample.
    pub(crate) clock_ratio: Option<f64>,
}

/// Sums corrected samples to a heading that is not wrapped.
#[derive(Debug, Clone)]
pub(crate) struct HeadingIntegrator {
    clock: IntegrationClock,
    period: Span,
    silence_max: Span,
    heading: Angle,
    held: bool,
    bias: AngularRate,
    calibration: Calibration,
    gain_ccw: f64,
    gain_cw: f64,
    temperature: Option<Temperature>,
    temperature_sum: f64,
    temperature_count: u32,
    temperature_due: Timestamp,
    last_arrival: Option<Timestamp>,
    last_rate: AngularRate,
    last_sequence: Option<Sequence>,
    last_integrated: Option<Angle>,
    watch: ClockWatch,
    samples: u64,
    samples_lost: u64,
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
            bias: AngularRate::ZERO,
            calibration: Calibration::default(),
            gain_ccw: 1.0,
            gain_cw: 1.0,
            temperature: None,
            temperature_sum: 0.0,
            temperature_count: 0,
            temperature_due: Timestamp::ZERO,
            last_arrival: None,
            last_rate: AngularRate::ZERO,
            last_sequence: None,
            last_integrated: None,
            watch: ClockWatch::new(period),
            samples: 0,
            samples_lost: 0,
        }
    }

    pub(crate) const fn heading(&self) -> Angle {
        self.heading
    }

    pub(crate) const fn set_heading(&mut self, heading: Angle) {
        self.heading = heading;
    }

    /// While held the heading stays as it is: what the gyro reads on a robot that is known to stand is
    /// bias, not rotation.
    pub(crate) const fn hold(&mut self, held: bool) {
        self.held = held;
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

    /// Nothing was heard for too long: what passed meanwhile is unknown and is not bridged.
    pub(crate) const fn lose_track(&mut self) {
        self.last_arrival = None;
        self.last_sequence = None;
        self.last_integrated = None;
        self.watch.restart();
    }

    /// Takes one valid sample that arrived `now`. `skipped` samples before it were invalid: where
    /// the stream has no sequence they count as lost.
    pub(crate) fn sample(&mut self, now: Timestamp, sample: &GyroSample, skipped: u16) -> Reading {
        let after_silence = self.last_arrival.is_some_and(|last| now - last > self.silence_max);
        if after_silence {
            self.lose_track();
        }
        let lost = match (sample.sequence, self.last_sequence) {
            (Some(this), Some(last)) => {
                let lost = this.lost_since(last);
                if self.has_room_for(now, lost) {
                    lost
                } else if this == last {
                    return Reading { raw_rate: self.last_rate, ..Reading::default() };
                } else {
                    0
                }
            }
            (None, _) if self.last_arrival.is_some() => skipped,
            _ => 0,
        };
        self.last_sequence = sample.sequence;
        let temperature =
            sample.temperature.filter(|t| (TEMPERATURE_MIN..=TEMPERATURE_MAX).contains(t));
        if let Some(temperature) = temperature {
            self.average_temperature(now, temperature);
        }
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
            self.corrected(raw_rate) * span_s
        } else {
            (self.corrected(raw_rate) + self.corrected(bridge) * f64::from(lost)) * period_s
        };
        if !self.held {
            self.heading += Angle::from_rad(step);
        }
        self.last_arrival = Some(now);
        self.last_rate = raw_rate;
        self.samples += 1;
        self.samples_lost += u64::from(lost);
        let clock_ratio = self.watch.sample(now, lost);
        Reading { raw_rate, temperature, lost, after_silence, clock_ratio }
    }

    /// So many samples may have been due since the last one arrived. A running number that says more
    /// is repeated or wrong, and bridging it would turn the heading for nothing. What a host hands over
    /// in bunches may seem to have come at once, so that the limit of silence is allowed on top.
    fn has_room_for(&self, now: Timestamp, lost: u16) -> bool {
        self.last_arrival
            .is_some_and(|last| self.period * i64::from(lost) <= (now - last) + self.silence_max)
    }

    /// rad/s
    fn corrected(&self, raw: AngularRate) -> f64 {
        let rate = raw.rad_per_s() - self.bias.rad_per_s();
        rate * if rate < 0.0 { self.gain_cw } else { self.gain_ccw }
    }

    fn average_temperature(&mut self, now: Timestamp, temperature: Temperature) {
        self.temperature_sum += temperature.celsius();
        self.temperature_count += 1;
        if now < self.temperature_due {
            return;
        }
        let mean = self.temperature_sum / f64::from(self.temperature_count);
        self.temperature = Some(Temperature::from_celsius(mean));
        self.temperature_sum = 0.0;
        self.temperature_count = 0;
        self.temperature_due = now + TEMPERATURE_UPDATE;
        if self.calibration.needs_temperature() {
            self.update_gains();
        }
    }

    fn update_gains(&mut self) {
        let ccw = AngularRate::from_rad_per_s(1.0);
        self.gain_ccw = self.calibration.gain(self.temperature, ccw);
        self.gain_cw = self.calibration.gain(self.temperature, -ccw);
    }
}

#[cfg(test)]
mod tests {
    use super::{HeadingIntegrator, IntegrationClock};
    use crate::calibration::{Calibration, Factor};
    use crate::config::GyroConfig;
    use proptest::prelude::*;
    use wire::gyro::{GyroOutput, GyroSample, GyroStatus, Sequence};
    use wire::time::{Span, Timestamp};
    use wire::units::{Angle, AngularRate, Temperature};

    const PERIOD: Span = Span::from_millis(10);

    fn sample(output: GyroOutput, number: u32) -> GyroSample {
        GyroSample {
            output,
            valid: true,
            status: GyroStatus::default(),
            temperature: Some(Temperature::from_celsius(25.0)),
            sequence: Some(Sequence { value: number as u8, modulus: 256 }),
        }
    }

    fn at(n: u32) -> Timestamp {
        Timestamp::ZERO + PERIOD * i64::from(n)
    }

    /// One turn in 12 s, in whichever form.
    fn turn(n: u32) -> Angle {
        Angle::from_deg(360.0 / 1_200.0 * f64::from(n))
    }

    #[test]
    fn rate_increment_and_integrated_angle_agree() {
        let rate = turn(1) / PERIOD;
        type Form = (&'static str, fn(u32, AngularRate) -> GyroOutput);
        let forms: [Form; 3] = [
            ("rate", |_, rate| GyroOutput::Rate(rate)),
            ("increment", |_, _| GyroOutput::Increment(turn(1))),
            ("integrated", |n, _| GyroOutput::Integrated(turn(n).wrapped())),
        ];
        for (name, form) in forms {
            let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
            // The first integrated angle is the origin.
            integrator.sample(at(0), &sample(form(0, AngularRate::ZERO), 0), 0);
            integrator.set_heading(Angle::ZERO);
            for n in 1..=1_200 {
                integrator.sample(at(n), &sample(form(n, rate), n), 0);
            }
            assert!((integrator.heading().deg() - 360.0).abs() < 1e-9, "{name}");
        }
    }

    #[test]
    fn bias_and_factors_are_those_of_eq_4() {
        let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
        integrator.set_bias(AngularRate::from_deg_per_s(0.1));
        let line = Factor::TemperatureLine { slope_deg_per_celsius: -0.52, intercept_deg: 19.23 };
        integrator.set_calibration(Calibration {
            factors: [line].into_iter().collect(),
            ..Calibration::default()
        });
        for n in 0..1_000 {
            let output = GyroOutput::Rate(AngularRate::from_deg_per_s(30.1));
            integrator.sample(at(n), &sample(output, n), 0);
        }
        let expected = 300.0 * 360.0 / (379.23 - 0.52 * 25.0);
        assert!((integrator.heading().deg() - expected).abs() < 1e-9);
    }

    #[test]
    fn a_held_heading_stays_and_the_samples_count_on() {
        let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
        let output = GyroOutput::Rate(AngularRate::from_deg_per_s(0.01));
        integrator.hold(true);
        for n in 0..100 {
            integrator.sample(at(n), &sample(output, n), 0);
        }
        assert_eq!((integrator.heading(), integrator.samples()), (Angle::ZERO, 100));
        integrator.hold(false);
        integrator.sample(at(100), &sample(output, 100), 0);
        assert!(integrator.heading() > Angle::ZERO);
    }

    #[test]
    fn silence_is_not_bridged() {
        let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
        let output = GyroOutput::Rate(AngularRate::from_deg_per_s(10.0));
        integrator.sample(at(0), &sample(output, 0), 0);
        let reading = integrator.sample(at(500), &sample(output, 244), 0);
        assert!(reading.lost == 0 && reading.after_silence);
        assert!((integrator.heading().deg() - 0.2).abs() < 1e-9);
    }

    #[test]
    fn host_time_follows_a_slow_gyro_and_sample_count_does_not() {
        for (clock, expected) in
            [(IntegrationClock::Samples, 30.0), (IntegrationClock::HostTime, 30.9)]
        {
            let config = GyroConfig { clock, ..GyroConfig::default() };
            let mut integrator = HeadingIntegrator::new(&config);
            let rate = GyroOutput::Rate(AngularRate::from_deg_per_s(3.0));
            for n in 0..1_000 {
                let arrival = Timestamp::ZERO + Span::from_micros(10_300) * i64::from(n);
                integrator.sample(arrival, &sample(rate, n), 0);
            }
            assert!((integrator.heading().deg() - expected).abs() < 0.01, "{clock:?}");
        }
    }

    #[test]
    fn a_number_that_repeats_or_leaps_is_not_bridged() {
        let rate = GyroOutput::Rate(AngularRate::from_deg_per_s(30.0));
        let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
        integrator.sample(at(0), &sample(rate, 0), 0);
        integrator.sample(at(1), &sample(rate, 1), 0);
        integrator.sample(at(1), &sample(rate, 1), 0);
        assert!((integrator.heading().deg() - 0.6).abs() < 1e-9, "doubled");
        integrator.sample(at(2), &sample(rate, 200), 0);
        integrator.sample(at(3), &sample(rate, 3), 0);
        assert!((integrator.heading().deg() - 1.2).abs() < 1e-9, "leapt and back");
        assert_eq!((integrator.samples(), integrator.samples_lost()), (4, 0));
    }

    proptest! {
        #[test]
        fn lost_samples_are_bridged_and_counted(lost in prop::collection::btree_set(2u32..998, 0..200)) {
            let mut integrator = HeadingIntegrator::new(&GyroConfig::default());
            // A ramp: the mean of the neighbours is exact when one sample is lost.
            let rate = |n: u32| AngularRate::from_deg_per_s(0.03 * f64::from(n));
            for n in (0..1_000).filter(|n| !lost.contains(n)) {
                integrator.sample(at(n), &sample(GyroOutput::Rate(rate(n)), n), 0);
            }
            let ideal: f64 = (0..1_000).map(|n| rate(n).deg_per_s() * 0.01).sum();
            prop_assert_eq!(integrator.samples_lost(), lost.len() as u64);
            prop_assert!((integrator.heading().deg() - ideal).abs() < 0.05);
        }
    }
}
