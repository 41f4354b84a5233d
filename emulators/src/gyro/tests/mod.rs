//! The whole chain, before the encoder rounds its output.

mod effects;
mod errors;
mod fault;
mod stream;
mod terms;

use super::{GyroEmulator, GyroFault, GyroParameters};
use wire::gyro::{GyroFormat, GyroOutput, GyroSample, GyroStream, OutputMode};
use wire::time::Timestamp;
use wire::units::Angle;

const NAVIGATOR: GyroStream =
    GyroStream { format: GyroFormat::Navigator, mode: OutputMode::Rate, reversed: false };

const DSP3000: GyroStream =
    GyroStream { format: GyroFormat::Dsp3000Ascii, mode: OutputMode::Increment, reversed: false };

pub(super) fn gyro(parameters: GyroParameters, stream: GyroStream) -> GyroEmulator {
    GyroEmulator::new(parameters, stream, 5, "gyro")
}

/// The next output, before the encoder rounds it.
pub(super) fn measured(
    gyro: &mut GyroEmulator,
    now: Timestamp,
    heading: Angle,
) -> Option<GyroSample> {
    let (wanted, interval_s) = gyro.advance(now, heading)?;
    if gyro.faults.is_empty() {
        return Some(gyro.sound(wanted, interval_s));
    }
    gyro.measure_faulty(wanted, interval_s)
}

/// Every output up to `seconds`, on a carrier with the heading `heading`.
pub(super) fn run(
    gyro: &mut GyroEmulator,
    seconds: f64,
    heading: impl Fn(f64) -> Angle,
    mut deliver: impl FnMut(GyroSample),
) {
    while gyro.next_wakeup() <= Timestamp::from_secs_f64(seconds) {
        let now = gyro.next_wakeup();
        if let Some(sample) = measured(gyro, now, heading(now.as_secs_f64())) {
            deliver(sample);
        }
    }
}

pub(super) fn rate(sample: GyroSample) -> f64 {
    match sample.output {
        GyroOutput::Rate(rate) => rate.deg_per_s(),
        other => panic!("not a rate: {other:?}"),
    }
}

pub(super) fn increment(sample: GyroSample) -> f64 {
    match sample.output {
        GyroOutput::Increment(angle) => angle.deg(),
        other => panic!("not an increment: {other:?}"),
    }
}

/// A turn at 30 deg/s with ramps of 15 deg/s^2, begun at 1 s: the paper's table run.
pub(super) fn table_turn(direction: f64) -> impl Fn(f64) -> Angle {
    move |t| {
        let t = (t - 1.0).clamp(0.0, 14.0);
        let deg = if t < 2.0 {
            7.5 * t * t
        } else if t < 12.0 {
            30.0 + 30.0 * (t - 2.0)
        } else {
            360.0 - 7.5 * (14.0 - t).powi(2)
        };
        Angle::from_deg(direction * deg)
    }
}

/// Variance of the mean over `later` seconds minus the mean over the `earlier` seconds just before, for a Gauss-Markov
/// process of unit variance and correlation time `t`, from its autocovariance e^(-|s|/t) integrated over both
/// intervals.
pub(super) fn variance_after_bias_test(earlier: f64, later: f64, t: f64) -> f64 {
    let own = |length: f64| 2.0 * (t / length).powi(2) * (length / t - 1.0 + (-length / t).exp());
    let shared =
        t * t / (earlier * later) * (1.0 - (-earlier / t).exp()) * (1.0 - (-later / t).exp());
    own(earlier) + own(later) - 2.0 * shared
}
