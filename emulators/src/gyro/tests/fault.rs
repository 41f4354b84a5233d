//! Effect of each fault on the outputs, and full recovery after it.

use super::{
    DSP3000, GyroFault, GyroParameters, NAVIGATOR, gyro, increment, measured, rate, table_turn,
};
use crate::gyro::GyroEmulator;
use crate::random::RandomStream;
use wire::gyro::GyroSample;
use wire::time::Timestamp;

/// The samples of a turn at 30 deg/s with a fault from 5 s to 7 s, and how often it acted.
fn faulty(parameters: GyroParameters, fault: GyroFault) -> (Vec<(f64, GyroSample)>, u64) {
    let mut gyro = gyro(parameters, NAVIGATOR);
    run(&mut gyro, fault)
}

fn run(gyro: &mut GyroEmulator, fault: GyroFault) -> (Vec<(f64, GyroSample)>, u64) {
    let heading = table_turn(1.0);
    let (mut samples, mut acted, mut on) = (Vec::new(), None, false);
    while gyro.next_wakeup() <= Timestamp::from_secs_f64(10.0) {
        let now = gyro.next_wakeup();
        let t = now.as_secs_f64();
        if t >= 5.0 && !on {
            gyro.begin_fault(4, fault, RandomStream::new(1, "fault", "4"));
            on = true;
        }
        if t >= 7.0 && acted.is_none() {
            acted = Some(gyro.end_fault(4));
        }
        if let Some(sample) = measured(gyro, now, heading(t)) {
            samples.push((t, sample));
        }
    }
    (samples, acted.unwrap())
}

fn within(samples: &[(f64, GyroSample)], from: f64, to: f64) -> Vec<GyroSample> {
    samples.iter().filter(|(t, _)| (from..to).contains(t)).map(|(_, sample)| *sample).collect()
}

fn rates(samples: &[(f64, GyroSample)], from: f64, to: f64) -> Vec<f64> {
    within(samples, from, to).into_iter().map(rate).collect()
}

#[test]
fn a_stuck_gyro_repeats_its_reading_and_counts_on() {
    let noisy = GyroParameters { angle_random_walk_deg_per_sqrt_h: 1.0, ..Default::default() };
    let (samples, acted) = faulty(noisy, GyroFault::Stuck);
    let stuck = rates(&samples, 5.0, 7.0);
    assert!(stuck.len() as u64 == acted && stuck.iter().all(|rate| *rate == stuck[0]));
    let after = rates(&samples, 7.0, 9.0);
    assert!(after.iter().any(|rate| *rate != stuck[0]));
    let numbers = within(&samples, 5.0, 7.0);
    assert!(numbers.windows(2).all(|pair| pair[0].sequence != pair[1].sequence && pair[0].valid));
}

#[test]
fn beyond_the_smaller_range_it_reads_its_end_and_says_valid() {
    let parameters = GyroParameters { range_deg_per_s: 100.0, ..Default::default() };
    let (samples, acted) = faulty(parameters, GyroFault::OverRange { lost: 0.9 });
    let clipped = within(&samples, 5.0, 7.0);
    assert_eq!(clipped.len() as u64, acted);
    assert!(clipped.iter().all(|sample| sample.valid && (rate(*sample) - 10.0).abs() < 1e-9));
    assert!(rates(&samples, 7.0, 9.0).iter().all(|rate| (rate - 30.0).abs() < 1e-6));
}

#[test]
fn a_bias_step_is_a_step() {
    let by = 1f64.to_radians();
    let (samples, acted) = faulty(GyroParameters::default(), GyroFault::BiasStep { by });
    let biased = rates(&samples, 5.0, 7.0);
    assert_eq!(biased.len() as u64, acted);
    assert!(biased.iter().all(|rate| (rate - 31.0).abs() < 1e-6));
    assert!((rates(&samples, 4.0, 5.0)[0] - 30.0).abs() < 1e-6);
}

#[test]
fn a_noise_burst_has_its_size_and_shifts_no_other_number() {
    let noisy = GyroParameters { angle_random_walk_deg_per_sqrt_h: 1.0, ..Default::default() };
    let rms = 1f64.to_radians();
    let (samples, _) = faulty(noisy.clone(), GyroFault::Noise { rms });
    let (without, _) = faulty(noisy, GyroFault::BiasStep { by: 0.0 });
    let burst = rates(&samples, 5.0, 7.0);
    let plain = rates(&without, 5.0, 7.0);
    let square: f64 = burst.iter().zip(&plain).map(|(a, b)| (a - b).powi(2)).sum();
    let rms = (square / burst.len() as f64).sqrt();
    // Some hundred draws: within a fifth.
    assert!((rms - 1.0).abs() < 0.2, "{rms}");
    assert_eq!(rates(&samples, 7.0, 9.0), rates(&without, 7.0, 9.0));
}

#[test]
fn the_temperature_sensor_hangs_or_goes_wild() {
    let warming = GyroParameters {
        self_heating_kelvin: 20.0,
        thermal_time_constant_s: 10.0,
        ..Default::default()
    };
    let told = |fault| {
        let (samples, acted) = faulty(warming.clone(), fault);
        let celsius: Vec<f64> = within(&samples, 5.0, 7.0)
            .iter()
            .map(|sample| sample.temperature.unwrap().celsius())
            .collect();
        assert_eq!(celsius.len() as u64, acted);
        celsius
    };
    let frozen = told(GyroFault::TemperatureFrozen);
    assert!(frozen.iter().all(|celsius| *celsius == frozen[0]));
    let wild = told(GyroFault::TemperatureWild { rms_kelvin: 20.0 });
    let spread = wild.iter().fold(0f64, |most, celsius| most.max((celsius - wild[0]).abs()));
    assert!(spread > 20.0, "{spread}");
}

#[test]
fn a_restart_is_silent_and_begins_to_count_anew() {
    let (samples, acted) = faulty(GyroParameters::default(), GyroFault::Off);
    assert!(within(&samples, 5.0, 7.0).is_empty() && acted > 100);
    let first = within(&samples, 7.0, 8.0)[0];
    assert_eq!(first.sequence.unwrap().value, 0);
    // Rotation during the fault appears in no increment.
    let mut gyro = gyro(GyroParameters::default(), DSP3000);
    let (samples, _) = run(&mut gyro, GyroFault::Off);
    assert!(within(&samples, 7.0, 9.0).iter().all(|sample| increment(*sample).abs() < 1.0));
}
