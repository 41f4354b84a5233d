//! Lost, duplicated and late samples, and a gyro whose clock differs from the host's.

use controller::Mutant;
use controller::config::IntegrationClock;
use controller::health::Level;
use emulators::gyro::GyroParameters;
use record::Device;
use record::outcome::Outcome;
use tests::devices::{NAVIGATOR, ideal_table, shipped};
use tests::plans::{plan_of, prepared, run};
use tests::rig::{Direction, Rig, bytes};
use wire::device::Transmit;
use wire::gyro::{GyroFormat, GyroStream, OutputMode, dsp3000_binary};
use wire::table::Command as TableCommand;
use wire::time::Span;

/// Rate of the table's turns, and their ramp.
const RATE_DEG: f64 = 30.0;
const RAMP_DEG: f64 = 15.0;
const STEPS_PER_DEG: f64 = 80.0;

const fn stream(format: GyroFormat, mode: OutputMode) -> GyroStream {
    GyroStream { format, mode, reversed: false }
}

const DSP_RATE: GyroStream = stream(GyroFormat::Dsp3000Ascii, OutputMode::Rate);
const DSP_INCREMENT: GyroStream = stream(GyroFormat::Dsp3000Ascii, OutputMode::Increment);
const DSP_INTEGRATED: GyroStream = stream(GyroFormat::Dsp3000Ascii, OutputMode::Integrated);
const BINARY_RATE: GyroStream = stream(GyroFormat::Dsp3000Binary, OutputMode::Rate);
const BINARY_INCREMENT: GyroStream = stream(GyroFormat::Dsp3000Binary, OutputMode::Increment);
const BINARY_INTEGRATED: GyroStream = stream(GyroFormat::Dsp3000Binary, OutputMode::Integrated);
const ECORE: GyroStream = stream(GyroFormat::Ecore2000, OutputMode::Rate);

const ALL_STREAMS: [GyroStream; 8] = [
    NAVIGATOR,
    ECORE,
    DSP_RATE,
    DSP_INCREMENT,
    DSP_INTEGRATED,
    BINARY_RATE,
    BINARY_INCREMENT,
    BINARY_INTEGRATED,
];

/// Turns the table by whole degrees and waits for rest; returns the error of the heading in deg.
fn turn(rig: &mut Rig, deg: i32) -> f64 {
    let error = |rig: &mut Rig| rig.state().gyro_heading - rig.heading();
    let before = error(rig);
    let now = rig.now();
    let table = rig.table();
    for command in [
        TableCommand::TopRate((RATE_DEG * STEPS_PER_DEG) as u32),
        TableCommand::Ramp((RAMP_DEG * STEPS_PER_DEG) as u32),
        TableCommand::Distance(deg * STEPS_PER_DEG as i32),
        TableCommand::Go,
    ] {
        table.command(now, command);
    }
    rig.run_for(Span::from_secs_f64(f64::from(deg.abs()) / RATE_DEG + RATE_DEG / RAMP_DEG + 1.0));
    (error(rig) - before).deg()
}

/// Maximum quantisation error of a stream in one turn: half a step of rate in each sample, always with the same sign.
fn quantisation_deg(stream: GyroStream, deg: i32) -> f64 {
    let span_s = f64::from(deg.abs()) / RATE_DEG + RATE_DEG / RAMP_DEG;
    // The integrated angle and the increment have steps of angle, 1e-6 deg or 6e-6 deg per sample.
    let steps = 6e-6 * span_s / stream.format.period().as_secs_f64();
    stream.format.facts().rate_step.deg_per_s() * span_s / 2.0 + steps
}

fn rig_with(
    stream: GyroStream,
    clock: IntegrationClock,
    change: impl FnOnce(&mut GyroParameters),
) -> Rig {
    let mut devices = ideal_table(stream);
    change(&mut devices.gyro.1);
    Rig::with_config(&devices, 1, |config| config.gyro.clock = clock).ready()
}

#[test]
fn every_stream_tells_a_turn_of_the_table() {
    for stream in ALL_STREAMS {
        for deg in [360, -360] {
            let mut rig = rig_with(stream, IntegrationClock::Samples, |_| {});
            let error = turn(&mut rig, deg);
            assert!(error.abs() <= quantisation_deg(stream, deg), "{stream:?}: {error}");
            assert_eq!(rig.health().level, Level::Ok, "{stream:?}");
            assert_eq!(rig.state().samples_lost, 0, "{stream:?}");
        }
    }
}

#[test]
fn a_clock_two_percent_off_spoils_rates_by_as_much_and_angles_not_at_all() {
    const OFF: f64 = 0.02;
    for sign in [1.0, -1.0] {
        for stream in ALL_STREAMS {
            let mut rig = rig_with(stream, IntegrationClock::Samples, |gyro| {
                gyro.clock_error_ppm = sign * OFF * 1e6;
            });
            let error = turn(&mut rig, 360);
            // A sample more or less at either end of the turn lies in the ramps and has no effect.
            let expected = match stream.mode {
                OutputMode::Rate => 360.0 * sign * OFF,
                OutputMode::Increment | OutputMode::Integrated => 0.0,
            };
            let slack = quantisation_deg(stream, 360) * (1.0 + OFF);
            assert!((error - expected).abs() <= slack, "{stream:?} {sign}: {error} deg");
            // Clocks are compared over 20 s.
            rig.run_for(Span::from_secs(25));
            let spoils = stream.mode == OutputMode::Rate;
            assert_eq!(rig.health().causes.clock_mismatch, spoils, "{stream:?}");
            assert_eq!(rig.health().level, if spoils { Level::Degraded } else { Level::Ok });
            let ratio = rig.state().clock_ratio.expect("the clocks were compared");
            assert!((ratio - 1.0 - sign * OFF).abs() < 1e-3, "{stream:?}: {ratio}");
            // A bias test does not correct a clock.
            rig.bias_test(1.0);
            assert_eq!(rig.health().causes.clock_mismatch, spoils, "{stream:?}");
        }
    }
}

#[test]
fn a_clock_that_changes_or_leaves_its_data_sheet_is_told_where_it_spoils_nothing() {
    for stream in [DSP_INCREMENT, DSP_INTEGRATED] {
        let mut rig = rig_with(stream, IntegrationClock::Samples, |gyro| {
            gyro.clock_error_ppm = 40_000.0;
        });
        rig.run_for(Span::from_secs(25));
        assert!(rig.health().causes.clock_mismatch, "4 % are more than the manual's 3.2 %");
        // Lost samples without a counter look like a changed clock.
        let mut rig = rig_with(stream, IntegrationClock::Samples, |_| {});
        rig.run_for(Span::from_secs(25));
        assert_eq!(rig.health().level, Level::Ok);
        lose(&mut rig, |number| number % 50 == 0);
        rig.run_for(Span::from_secs(45));
        assert!(rig.health().causes.clock_mismatch, "{stream:?}");
    }
}

#[test]
fn host_time_mends_a_clock_that_is_off() {
    for stream in [NAVIGATOR, ECORE, DSP_RATE, BINARY_RATE] {
        for ppm in [20_000.0, -20_000.0] {
            let mut rig =
                rig_with(stream, IntegrationClock::HostTime, |gyro| gyro.clock_error_ppm = ppm);
            let error = turn(&mut rig, 360);
            let slack = quantisation_deg(stream, 360) * 1.02;
            assert!(error.abs() <= slack, "{stream:?} {ppm}: {error} deg");
        }
    }
}

#[test]
fn a_clock_within_the_limit_is_no_mismatch() {
    let mut rig = rig_with(DSP_INCREMENT, IntegrationClock::Samples, |gyro| {
        gyro.clock_error_ppm = 2_000.0;
    });
    rig.run_for(Span::from_secs(60));
    assert_eq!(rig.health().level, Level::Ok);
}

/// Drops the gyro packets for which `drop` returns `true`, counted from one.
fn lose(rig: &mut Rig, mut drop: impl FnMut(u32) -> bool + Send + 'static) {
    let mut number = 0;
    rig.tap(Direction::GyroToController, move |_, piece| {
        number += 1;
        if drop(number) { Vec::new() } else { vec![piece] }
    });
}

#[test]
fn what_the_navigator_loses_is_counted_and_bridged() {
    // With |w'| <= a, linear interpolation over T errs by at most a T^2 / 4.
    for (run, every) in [(1u32, 10u32), (3, 20), (9, 100)] {
        let mut rig = rig_with(NAVIGATOR, IntegrationClock::Samples, |_| {});
        let before = rig.state().samples;
        lose(&mut rig, move |number| number % every < run && number >= every);
        let error = turn(&mut rig, 360);
        let bridge_s = f64::from(run + 1) * 0.01;
        // Only a gap at one of the four bends of the trapezoid is not linear.
        let bound = quantisation_deg(NAVIGATOR, 360) + 4.0 * RAMP_DEG * bridge_s.powi(2) / 4.0;
        assert!(error.abs() <= bound, "{run} of {every}: {error} deg, expected at most {bound}");
        let state = rig.state();
        let share = f64::from(run) / f64::from(every);
        let expected = share * (state.samples + state.samples_lost - before) as f64;
        assert!(
            (state.samples_lost as f64 - expected).abs() <= f64::from(every),
            "{run} of {every}: {} lost, about {expected} expected",
            state.samples_lost
        );
        assert!(rig.health().causes.samples_lost);
        assert_eq!(rig.health().level, Level::Degraded);
        rig.untap(Direction::GyroToController);
        rig.run_for(Span::from_millis(100));
        rig.bias_test(1.0);
        assert!(rig.health().causes.samples_lost, "no bias test finds what was lost");
        rig.set_pose();
        assert_eq!(rig.health().level, Level::Ok);
    }
}

#[test]
fn exactly_what_is_dropped_is_counted() {
    let mut rig = rig_with(NAVIGATOR, IntegrationClock::Samples, |_| {});
    lose(&mut rig, |number| [10, 20, 21, 40, 300, 301, 302].contains(&number));
    rig.run_for(Span::from_secs(10));
    assert_eq!(rig.state().samples_lost, 7);
}

#[test]
fn a_doubled_sample_is_counted_once() {
    for stream in [NAVIGATOR, BINARY_RATE] {
        let mut rig = rig_with(stream, IntegrationClock::Samples, |_| {});
        let mut number = 0;
        rig.tap(Direction::GyroToController, move |_, piece| {
            number += 1;
            if number == 700 { vec![piece, piece] } else { vec![piece] }
        });
        let error = turn(&mut rig, 360);
        let bound = quantisation_deg(stream, 360) + relock_deg(stream);
        assert!(error.abs() <= bound, "{stream:?}: {error} deg, expected at most {bound}");
    }
}

/// One of them in a turn at 30 deg/s is 0.3 deg, and a wheel may err by more.
#[test]
fn one_sample_that_nobody_counted_is_missed() {
    for stream in [ECORE, DSP_RATE, DSP_INCREMENT] {
        for copies in [0, 1, 2] {
            let mut rig = rig_with(stream, IntegrationClock::Samples, |gyro| {
                gyro.clock_error_ppm = 20_000.0 * f64::from(u8::from(stream == DSP_INCREMENT));
            });
            rig.run_for(Span::from_secs(25));
            let mut number = 0;
            rig.tap(Direction::GyroToController, move |_, piece| {
                number += 1;
                let count = if number == 300 { copies } else { 1 };
                std::iter::repeat_n(piece, count).collect()
            });
            turn(&mut rig, 360);
            assert_eq!(rig.health().causes.samples_lost, copies != 1, "{stream:?}: {copies}");
        }
    }
}

/// Cost of one lost lock: the binary stream is trusted again only after ten consecutive frames, and its two-bit counter
/// cannot tell how many were missed meanwhile.
fn relock_deg(stream: GyroStream) -> f64 {
    match stream.format {
        GyroFormat::Dsp3000Binary => {
            let frames = f64::from(dsp3000_binary::LOCK_FRAMES) + 1.0;
            RATE_DEG * frames * stream.format.period().as_secs_f64()
        }
        _ => 0.0,
    }
}

#[test]
fn a_frame_lost_at_1000_hz_costs_a_lock_and_shows() {
    for (stream, bound) in [
        (BINARY_RATE, relock_deg(BINARY_RATE)),
        (BINARY_INCREMENT, relock_deg(BINARY_INCREMENT)),
        // The angle itself shows how far it turned.
        (BINARY_INTEGRATED, 0.0),
    ] {
        let mut rig = rig_with(stream, IntegrationClock::Samples, |_| {});
        lose(&mut rig, |number| number == 6_000);
        let error = turn(&mut rig, 360);
        let bound = bound + quantisation_deg(stream, 360);
        assert!(error.abs() <= bound, "{stream:?}: {error} deg, expected at most {bound}");
        assert!(rig.state().samples_lost > 0, "{stream:?}");
        assert!(rig.health().causes.samples_lost);
    }
}

#[test]
fn without_a_running_number_the_clock_tells_what_is_lost() {
    // The ASCII stream has no counter: its lost samples look like a slow clock.
    let mut rig = rig_with(DSP_RATE, IntegrationClock::Samples, |_| {});
    lose(&mut rig, |number| number % 50 == 0);
    let error = turn(&mut rig, 360);
    assert!((error + 360.0 / 50.0).abs() < 1.0, "{error}");
    rig.run_for(Span::from_secs(45));
    assert!(rig.health().causes.clock_mismatch);
    assert_eq!(rig.state().samples_lost, 0, "nothing tells");
    // The integrated angle is not affected.
    let mut rig = rig_with(DSP_INTEGRATED, IntegrationClock::Samples, |_| {});
    lose(&mut rig, |number| number % 50 == 0);
    let error = turn(&mut rig, 360);
    assert!(error.abs() < quantisation_deg(DSP_INTEGRATED, 360), "{error}");
}

#[test]
fn samples_that_come_in_bunches_are_all_used() {
    // Like a serial adapter that delivers its data 16 times a second.
    for clock in [IntegrationClock::Samples, IntegrationClock::HostTime] {
        let mut rig = rig_with(NAVIGATOR, clock, |_| {});
        let mut waiting = Vec::new();
        rig.tap(Direction::GyroToController, move |_, piece| {
            if let Transmit::Bytes(packet) = piece {
                waiting.extend_from_slice(packet.as_slice());
            }
            if waiting.len() >= 6 * 8 { bytes(&std::mem::take(&mut waiting)) } else { Vec::new() }
        });
        let error = turn(&mut rig, 360);
        // By host time the first sample of a batch counts for the whole batch: six samples of a ramp, at each bend.
        let bunch_s = 0.06;
        let slack = match clock {
            IntegrationClock::Samples => 0.0,
            IntegrationClock::HostTime => {
                RAMP_DEG * bunch_s * bunch_s * 4.0 + 2.0 * RATE_DEG * 0.01
            }
        };
        assert!(error.abs() <= quantisation_deg(NAVIGATOR, 360) + slack, "{clock:?}: {error}");
        assert_eq!(rig.state().samples_lost, 0);
        assert_eq!(rig.health().level, Level::Ok);
    }
}

/// Waiting for a time in the future would take longer, and the base would drive on unheard.
#[test]
fn a_host_clock_that_is_set_back_holds_up_nothing() {
    let steps = "{ bias_test = { duration_s = 3 } }, { place = { x_m = 0, y_m = 0, heading_deg = 0 } }, \
                 { straight = { distance_m = 2, speed_m_per_s = 0.4 } }";
    let fault = "\n[[fault]]\ntarget = \"host\"\nwhat = { clock_step = { step_s = -0.7 } }\n\
                 when = { step = \"straight\", after_s = 2 }\n";
    let run_with = |devices: &str, mutant: Option<Mutant>| {
        let text = format!("{}{fault}", plan_of(steps));
        let mut prepared = prepared(&text, shipped(devices));
        prepared.mutant = mutant;
        let run = run(&prepared, 1);
        assert_eq!(run.simulated.faults.first().map(|fault| fault.acted), Some(1));
        let sent = run.sent_by(Device::Controller);
        let driving = sent.iter().map(|record| record.at.as_secs_f64());
        let driving: Vec<f64> = driving.filter(|at| (5.0..9.0).contains(at)).collect();
        let gap = driving.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        (run.simulated.ending, driving.len(), gap)
    };
    for devices in ["paper", "paper-serial"] {
        let (ending, sent, gap) = run_with(devices, None);
        assert_eq!(ending.outcome, Outcome::Passed, "{ending:?}");
        assert!(sent > 100, "{devices}: {sent}");
        assert!(gap < 0.06, "{devices}: nothing for {gap} s");
        // The mutant that believes the host's clock waits for the size of the step.
        let (_, _, gap) = run_with(devices, Some(Mutant::HostClockBelieved));
        assert!(gap > 0.4, "{devices}: nothing for {gap} s");
    }
}
