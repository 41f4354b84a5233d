//! The whole chain, looked at before the encoder rounds it.

use super::{GyroEmulator, GyroParameters};
use proptest::prelude::*;
use wire::gyro::{GyroFormat, GyroOutput, GyroSample, GyroStream, OutputMode};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate};

const NAVIGATOR: GyroStream = GyroStream {
    format: GyroFormat::Navigator,
    mode: OutputMode::Rate,
    reversed: false,
};
const DSP3000: GyroStream = GyroStream {
    format: GyroFormat::Dsp3000Ascii,
    mode: OutputMode::Increment,
    reversed: false,
};

fn gyro(parameters: GyroParameters, stream: GyroStream) -> GyroEmulator {
    GyroEmulator::new(parameters, stream, 5, "gyro")
}

/// Every output up to `seconds`, on a carrier that heads where `heading` says.
fn run(
    gyro: &mut GyroEmulator,
    seconds: f64,
    heading: impl Fn(f64) -> Angle,
    mut deliver: impl FnMut(GyroSample),
) {
    while gyro.next_wakeup() <= Timestamp::from_secs_f64(seconds) {
        let now = gyro.next_wakeup();
        if let Some(sample) = gyro.measure(now, heading(now.as_secs_f64())) {
            deliver(sample);
        }
    }
}

fn rate(sample: GyroSample) -> f64 {
    match sample.output {
        GyroOutput::Rate(rate) => rate.deg_per_s(),
        other => panic!("not a rate: {other:?}"),
    }
}

fn increment(sample: GyroSample) -> f64 {
    match sample.output {
        GyroOutput::Increment(angle) => angle.deg(),
        other => panic!("not an increment: {other:?}"),
    }
}

/// A turn at 30 deg/s with ramps of 15 deg/s^2, begun at 1 s: the paper's table run.
fn table_turn(direction: f64) -> impl Fn(f64) -> Angle {
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

/// Eq. 5: E_T = -0.52 T + 19.23 deg for 360 deg, clockwise and counter-clockwise alike.
#[test]
fn the_papers_scale_gives_equation_5() {
    for celsius in [20.0, 25.0, 31.0, 36.98, 42.0] {
        for direction in [-1.0, 1.0] {
            let mut gyro = gyro(
                GyroParameters {
                    ambient_celsius: celsius,
                    scale_ppm_per_kelvin: -0.52 / 360.0 * 1e6,
                    scale_zero_celsius: 19.23 / 0.52,
                    bandwidth_hz: 100.0,
                    range_deg_per_s: 100.0,
                    ..Default::default()
                },
                NAVIGATOR,
            );
            let mut turned = 0.0;
            run(&mut gyro, 16.0, table_turn(direction), |sample| {
                turned += rate(sample) * 0.01
            });
            let error = direction * turned - 360.0;
            assert!(
                (error - (-0.52 * celsius + 19.23)).abs() < 1e-9,
                "{celsius}: {error}"
            );
        }
    }
}

#[test]
fn beyond_the_range_the_data_are_wrong_and_the_validity_stays_good() {
    let parameters = GyroParameters {
        range_deg_per_s: 100.0,
        ..Default::default()
    };
    for (true_rate, shown, over) in [
        (99.0, 99.0, false),
        (150.0, 100.0, true),
        (-101.0, -100.0, true),
    ] {
        let mut gyro = gyro(parameters.clone(), NAVIGATOR);
        run(
            &mut gyro,
            1.0,
            |t| Angle::from_deg(true_rate * t),
            |sample| {
                assert!((rate(sample) - shown).abs() < 1e-9);
                assert_eq!((sample.status.over_range, sample.valid), (over, true));
            },
        );
    }
}

#[test]
fn a_clock_error_spoils_rate_times_nominal_time_but_not_increments() {
    let parameters = GyroParameters {
        clock_error_ppm: 20_000.0,
        ..Default::default()
    };
    let heading = |t: f64| Angle::from_deg(30.0 * t);
    let mut by_rate = 0.0;
    let rates = GyroStream {
        mode: OutputMode::Rate,
        ..DSP3000
    };
    run(&mut gyro(parameters.clone(), rates), 12.0, heading, |s| {
        by_rate += rate(s) * 0.01
    });
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
fn warm_up_moves_bias_and_flag_and_a_hot_start_does_not() {
    let cold = GyroParameters {
        ambient_celsius: 22.0,
        self_heating_kelvin: 20.0,
        thermal_time_constant_s: 2_100.0,
        bias_deg_per_h_per_kelvin: 3.0,
        reference_celsius: 42.0,
        warm_up_flag_kelvin: 1.0,
        ..Default::default()
    };
    let hot = GyroParameters {
        powered_before_s: 1e6,
        ..cold.clone()
    };
    let mut drift = gyro(cold, NAVIGATOR);
    let mut last = None;
    run(
        &mut drift,
        2_100.0,
        |_| Angle::ZERO,
        |sample| {
            assert!(sample.status.warming_up);
            last = Some(rate(sample));
        },
    );
    let expected_deg_per_h = -3.0 * 20.0 * (-1.0f64).exp();
    assert!(
        (last.unwrap() * 3_600.0 - expected_deg_per_h).abs() < 1e-3,
        "{last:?}"
    );
    assert!((drift.truth().bias.deg_per_h() - expected_deg_per_h).abs() < 1e-3);
    let mut steady = gyro(hot, NAVIGATOR);
    run(
        &mut steady,
        10.0,
        |_| Angle::ZERO,
        |sample| {
            assert!(!sample.status.warming_up);
            assert!(rate(sample).abs() < 1e-9);
        },
    );
}

#[test]
fn scale_depends_on_direction_rate_and_tilt() {
    let shown = |parameters, true_rate: f64| {
        let mut last = 0.0;
        run(
            &mut gyro(parameters, NAVIGATOR),
            1.0,
            |t| Angle::from_deg(true_rate * t),
            |sample| {
                last = rate(sample);
            },
        );
        last / true_rate
    };
    let asymmetric = GyroParameters {
        scale_asymmetry_ppm: 400.0,
        ..Default::default()
    };
    assert!((shown(asymmetric.clone(), 30.0) - 1.0002).abs() < 1e-9);
    assert!((shown(asymmetric, -30.0) - 0.9998).abs() < 1e-9);
    let cubic = GyroParameters {
        scale_ppm_at_30_deg_per_s: -1_000.0,
        ..Default::default()
    };
    assert!((shown(cubic.clone(), 30.0) - 0.999).abs() < 1e-9);
    assert!((shown(cubic, -15.0) - 0.99975).abs() < 1e-9);
    let tilted = GyroParameters {
        axis_tilt_deg: 1.0,
        ..Default::default()
    };
    assert!(((shown(tilted, 30.0) - 1.0) * 360.0 + 0.055).abs() < 1e-3);
}

#[test]
fn parameters_change_during_a_run() {
    let mut gyro = gyro(
        GyroParameters {
            thermal_time_constant_s: 10.0,
            ..Default::default()
        },
        NAVIGATOR,
    );
    run(&mut gyro, 3.505, |_| Angle::ZERO, |_| ());
    gyro.set_parameter("bias_deg_per_h", 3_600.0).unwrap();
    gyro.set_parameter("ambient_celsius", 30.0).unwrap();
    assert!(gyro.set_parameter("ambient", 30.0).is_err());
    let mut first = None;
    run(
        &mut gyro,
        13.5,
        |_| Angle::ZERO,
        |sample| {
            first.get_or_insert(rate(sample));
        },
    );
    assert!((first.unwrap() - 1.0).abs() < 1e-12);
    let expected = 30.0 - 10.0 * (-1.0f64).exp();
    assert!((gyro.truth().coil_temperature.celsius() - expected).abs() < 0.02);
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
    run(&mut gyro, 15.0, heading, |sample| {
        last = Some(sample.output)
    });
    assert!(matches!(last, Some(GyroOutput::Integrated(a)) if (a.deg() - 30.0).abs() < 1e-6));
    gyro.receive(Timestamp::from_secs_f64(15.0), b"R\n");
    run(&mut gyro, 16.0, heading, |sample| {
        last = Some(sample.output)
    });
    assert!(matches!(last, Some(GyroOutput::Rate(_))));
}

#[test]
fn latency_delays_the_bytes_and_not_the_measurement() {
    let delayed = GyroParameters {
        latency_s: 0.025,
        ..Default::default()
    };
    let (mut late, mut prompt) = (
        gyro(delayed, NAVIGATOR),
        gyro(Default::default(), NAVIGATOR),
    );
    let log = |gyro: &mut GyroEmulator| {
        let mut log = Vec::new();
        while gyro.next_wakeup() <= Timestamp::from_secs_f64(1.0) {
            let now = gyro.next_wakeup();
            let heading = Angle::from_deg(now.as_secs_f64().powi(2));
            log.extend(gyro.wake(now, heading).map(|packet| (now, packet)));
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
            turned += gyro.measure(now, heading).map_or(0.0, increment);
        }
    }
    // Up to the last output, evenly within the last wake's interval.
    let (at, seen) = gyro.carrier.unwrap();
    assert!(now - at < Span::from_millis(10));
    // The run began, and the first heading was taken, 10 ms after the start.
    assert!((turned - (seen.deg() - 7.0 * 0.01f64.powi(2))).abs() < 1e-9);
}

/// Allan variance of white noise N^2/t, of a Gauss-Markov process and of a rate random walk K^2 t/3
/// (IEEE Std 952-1997, annex B), at averaging times where each one rules.
#[test]
fn allan_deviations_are_those_of_theory() {
    let white = GyroParameters {
        angle_random_walk_deg_per_sqrt_h: 0.6,
        ..Default::default()
    };
    let walk = GyroParameters {
        rate_random_walk_deg_per_s_per_sqrt_s: 1e-3,
        ..Default::default()
    };
    let drift = GyroParameters {
        bias_drift_deg_per_s: 0.005,
        bias_drift_correlation_s: 10.0,
        ..Default::default()
    };
    // sigma^2 (2 r - 3 + 4 e^-r - e^-2r) / r^2, with the process's rms sigma and r = t/T.
    let markov = |t: f64| {
        let r = t / 10.0;
        let bracket = 2.0 * r - 3.0 + 4.0 * (-r).exp() - (-2.0 * r).exp();
        0.005 * (bracket / (r * r)).sqrt()
    };
    let cases: [(GyroParameters, &dyn Fn(f64) -> f64); 3] = [
        (white, &|t| 0.01 / t.sqrt()),
        (walk, &|t| 1e-3 * (t / 3.0).sqrt()),
        (drift, &markov),
    ];
    for (parameters, theory) in cases {
        let mut rates = Vec::new();
        run(
            &mut gyro(parameters, NAVIGATOR),
            20_000.0,
            |_| Angle::ZERO,
            |s| rates.push(rate(s)),
        );
        for seconds in [1usize, 10, 20] {
            let means: Vec<f64> = rates
                .chunks_exact(seconds * 100)
                .map(|chunk| chunk.iter().sum::<f64>() / chunk.len() as f64)
                .collect();
            let square: f64 = means
                .windows(2)
                .map(|pair| (pair[1] - pair[0]).powi(2))
                .sum();
            let deviation = (square / (2 * (means.len() - 1)) as f64).sqrt();
            // Relative standard error of an Allan deviation from n means: 1/sqrt(2 (n - 1)), more by
            // up to sqrt(3/2) where neighbours are correlated; 4 of them allowed.
            let allowed = 4.0 * (1.5 / (2.0 * (means.len() - 1) as f64)).sqrt();
            let ratio = deviation / theory(seconds as f64);
            assert!(
                (ratio - 1.0).abs() < allowed,
                "{seconds} s: {ratio} +- {allowed}"
            );
        }
    }
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
            bytes.extend(
                gyro.wake(now, Angle::ZERO)
                    .iter()
                    .flat_map(|p| p.as_slice().to_vec()),
            );
        }
        bytes
    };
    assert_eq!(bytes(1, "gyro"), bytes(1, "gyro"));
    assert_ne!(bytes(1, "gyro"), bytes(1, "second gyro"));
    assert_ne!(bytes(1, "gyro"), bytes(2, "gyro"));
}

proptest! {
    #[test]
    fn the_mean_at_rest_is_the_bias(bias_deg_per_h in -100.0f64..100.0, seed: u64) {
        let parameters = GyroParameters {
            bias_deg_per_h,
            angle_random_walk_deg_per_sqrt_h: 0.083,
            ..Default::default()
        };
        let mut gyro = GyroEmulator::new(parameters, NAVIGATOR, seed, "gyro");
        let mut sum = 0.0;
        run(&mut gyro, 20.0, |_| Angle::ZERO, |sample| sum += rate(sample));
        // White noise leaves N/sqrt(20 s) in the mean; 5 of them allowed.
        let sigma = 0.083 / 60.0 / 20f64.sqrt();
        prop_assert!((sum / 2_000.0 - bias_deg_per_h / 3_600.0).abs() < 5.0 * sigma);
    }

    #[test]
    fn no_bytes_and_no_heading_panic(bytes in prop::collection::vec(any::<u8>(), 0..64), rad: f64) {
        let mut gyro = gyro(GyroParameters::default(), DSP3000);
        gyro.receive(Timestamp::ZERO, &bytes);
        for _ in 0..4 {
            let now = gyro.next_wakeup();
            gyro.wake(now, Angle::from_rad(rad));
            gyro.wake(Timestamp::MAX, AngularRate::from_rad_per_s(rad) * Span::from_secs(1));
        }
    }
}
