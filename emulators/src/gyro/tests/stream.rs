//! Outputs in time: clock, latency, modes, late wakes.

use super::{DSP3000, NAVIGATOR, gyro, increment, measured, rate, run};
use crate::gyro::{GyroEmulator, GyroParameters};
use crate::parameters::Parameters as _;
use proptest::prelude::*;
use wire::gyro::{GyroOutput, GyroStream, OutputMode};
use wire::packet::Packet;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate};

#[test]
fn an_ideal_gyro_reads_the_carrier() {
    let mut gyro = gyro(GyroParameters::default(), NAVIGATOR);
    let mut outputs = 0;
    run(
        &mut gyro,
        10.0,
        |t| Angle::from_deg(-30.0 * t),
        |sample| {
            assert!((rate(sample) + 30.0).abs() < 1e-9);
            assert!(sample.valid && !sample.status.over_range && !sample.status.warming_up);
            assert_eq!(
                sample.sequence.map(|s| (u32::from(s.value), s.modulus)),
                Some((outputs % 256, 256))
            );
            outputs += 1;
        },
    );
    assert_eq!(outputs, 1_000);
}

#[test]
fn a_clock_error_spoils_rate_times_nominal_time_but_not_increments() {
    let parameters = GyroParameters { clock_error_ppm: 20_000.0, ..Default::default() };
    let heading = |t: f64| Angle::from_deg(30.0 * t);
    let mut by_rate = 0.0;
    let rates = GyroStream { mode: OutputMode::Rate, ..DSP3000 };
    run(&mut gyro(parameters.clone(), rates), 12.0, heading, |s| by_rate += rate(s) * 0.01);
    let (mut by_increment, mut outputs) = (0.0, 0);
    run(&mut gyro(parameters, DSP3000), 12.0, heading, |sample| {
        by_increment += increment(sample);
        outputs += 1;
    });
    assert_eq!(outputs, 1_224);
    assert!((by_rate - 360.0 * 1.02).abs() < 1e-3, "{by_rate}");
    assert!((by_increment - 360.0).abs() < 1e-6, "{by_increment}");
}

#[test]
fn commands_change_the_mode_and_zero_the_angle() {
    let mut gyro = gyro(GyroParameters::default(), DSP3000);
    let heading = |t: f64| Angle::from_deg(30.0 * t);
    run(&mut gyro, 1.0, heading, |_| ());
    gyro.receive(Timestamp::from_secs_f64(1.0), b"P\n");
    let mut last = None;
    run(&mut gyro, 2.0, heading, |sample| last = Some(sample.output));
    assert!(matches!(last, Some(GyroOutput::Integrated(a)) if (a.deg() - 60.0).abs() < 1e-6));
    gyro.receive(Timestamp::from_secs_f64(2.0), b"Z\n");
    run(&mut gyro, 15.0, heading, |sample| last = Some(sample.output));
    assert!(matches!(last, Some(GyroOutput::Integrated(a)) if (a.deg() - 30.0).abs() < 1e-6));
    gyro.receive(Timestamp::from_secs_f64(15.0), b"R\n");
    run(&mut gyro, 16.0, heading, |sample| last = Some(sample.output));
    assert!(matches!(last, Some(GyroOutput::Rate(_))));
}

#[test]
fn latency_delays_the_bytes_and_not_the_measurement() {
    let delayed = GyroParameters { latency_s: 0.025, ..Default::default() };
    let (mut late, mut prompt) = (gyro(delayed, NAVIGATOR), gyro(Default::default(), NAVIGATOR));
    let log = |gyro: &mut GyroEmulator| {
        let mut log = Vec::new();
        while gyro.next_wakeup() <= Timestamp::from_secs_f64(1.0) {
            let now = gyro.next_wakeup();
            let heading = Angle::from_deg(now.as_secs_f64().powi(2));
            let mut packet = Packet::new();
            log.extend(gyro.wake(now, heading, &mut packet).then_some((now, packet)));
        }
        log
    };
    let (late, prompt) = (log(&mut late), log(&mut prompt));
    assert_eq!(late.len() + 3, prompt.len());
    for ((late_at, late), (at, packet)) in late.iter().zip(&prompt) {
        assert_eq!((*late_at - *at, late), (Span::from_millis(25), packet));
    }
}

#[test]
fn a_late_wake_loses_no_angle() {
    let mut gyro = gyro(GyroParameters::default(), DSP3000);
    let mut turned = 0.0;
    let mut now = Timestamp::ZERO;
    for late_ms in [0, 3, 10, 47, 500, 1] {
        now += Span::from_millis(10 + late_ms);
        let heading = Angle::from_deg(7.0 * now.as_secs_f64().powi(2));
        while gyro.next_wakeup() <= now {
            turned += measured(&mut gyro, now, heading).map_or(0.0, increment);
        }
    }
    // Up to the last output, evenly within the last wake's interval.
    let (at, seen) = gyro.carrier.unwrap();
    assert!(now - at < Span::from_millis(10));
    // The run began, and the first heading was taken, 10 ms after the start.
    assert!((turned - (seen.deg() - 7.0 * 0.01f64.powi(2))).abs() < 1e-9);
}

#[test]
fn a_carrier_that_was_placed_did_not_turn() {
    let mut gyro = gyro(GyroParameters::default(), NAVIGATOR);
    run(&mut gyro, 1.0, |_| Angle::ZERO, |_| ());
    gyro.carrier_placed(Angle::from_deg(90.0));
    run(&mut gyro, 2.0, |_| Angle::from_deg(90.0), |sample| assert_eq!(rate(sample), 0.0));
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_name_others() {
    let parameters = GyroParameters {
        angle_random_walk_deg_per_sqrt_h: 0.083,
        bias_drift_deg_per_s: 0.005,
        ..Default::default()
    };
    let bytes = |seed, name| {
        let mut gyro = GyroEmulator::new(parameters.clone(), NAVIGATOR, seed, name);
        let mut bytes = Vec::new();
        while bytes.len() < 8_000 {
            let now = gyro.next_wakeup();
            let mut packet = Packet::new();
            gyro.wake(now, Angle::ZERO, &mut packet);
            bytes.extend_from_slice(packet.as_slice());
        }
        bytes
    };
    assert_eq!(bytes(1, "gyro"), bytes(1, "gyro"));
    assert_ne!(bytes(1, "gyro"), bytes(1, "second gyro"));
    assert_ne!(bytes(1, "gyro"), bytes(2, "gyro"));
}

proptest! {
    /// No permitted parameter value stops the time.
    #[test]
    fn no_allowed_parameter_stops_the_clock(index in 0..GyroParameters::TABLE.len(), upper: bool) {
        let info = GyroParameters::TABLE[index];
        let mut gyro = gyro(GyroParameters::default(), DSP3000);
        let value = if upper { info.domain.max } else { info.domain.min };
        gyro.set_parameter(info.name, value).unwrap();
        let mut last = Timestamp::from_nanos(-1);
        for _ in 0..300 {
            let now = gyro.next_wakeup();
            prop_assert!(now > last || gyro.parameters().latency_s > 0.0);
            gyro.wake(now, Angle::from_rad(1.0), &mut Packet::new());
            last = now;
        }
        prop_assert!(last > Timestamp::from_secs_f64(1.0));
    }

    #[test]
    fn no_bytes_and_no_heading_panic(bytes in prop::collection::vec(any::<u8>(), 0..64), rad: f64) {
        let mut gyro = gyro(GyroParameters::default(), DSP3000);
        gyro.receive(Timestamp::ZERO, &bytes);
        for _ in 0..4 {
            let now = gyro.next_wakeup();
            gyro.wake(now, Angle::from_rad(rad), &mut Packet::new());
            let far = AngularRate::from_rad_per_s(rad) * Span::from_secs(1);
            gyro.wake(Timestamp::MAX, far, &mut Packet::new());
        }
    }
}
