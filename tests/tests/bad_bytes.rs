//! Garbage, partial frames and wrong checksums on every line, at rest and in motion: nothing panics, the heading stays
//! within a stated bound, health and counters show the errors, and everything recovers afterwards.
//!
//! Garbage could pass for a valid frame by chance (one in 2^16 offsets on the Navigator's stream, one in 256 answers on
//! the base's serial line). It is then either generated so that it cannot, or the case is left out: a receiver is not
//! to blame for errors that it cannot detect.

use controller::health::Level;
use controller::mission::{AbortReason, Command, MissionResult};
use embedded_can::Frame as _;
use emulators::base::Transport;
use proptest::prelude::*;
use std::sync::{Arc, Mutex};
use tests::devices::{NAVIGATOR, ideal, ideal_table};
use tests::harm::Harm;
use tests::rig::{Answer, Direction, Rig, bytes};
use wire::can::{CanFrame, ExtendedId, StandardId};
use wire::device::Transmit;
use wire::gyro::{GyroDecoder, GyroFormat, GyroStream, OutputMode, navigator};
use wire::table::Command as TableCommand;
use wire::time::Span;
use wire::units::{AngularRate, Speed};

fn any_harm() -> impl Strategy<Value = Harm> {
    let garbage = || prop::collection::vec(any::<u8>(), 0..20);
    prop_oneof![
        Just(Harm::Drop),
        any::<usize>().prop_map(Harm::Cut),
        (any::<usize>(), any::<u8>()).prop_map(|(index, change)| Harm::Change(index, change)),
        garbage().prop_map(Harm::Replace),
        garbage().prop_map(Harm::Before),
        garbage().prop_map(Harm::Behind),
    ]
}

/// From this packet on, this many consecutive packets are damaged.
#[derive(Debug, Clone)]
struct Burst {
    first: usize,
    harms: Vec<Harm>,
}

fn any_bursts(within: usize, length_max: usize) -> impl Strategy<Value = Vec<Burst>> {
    let burst = (0..within, prop::collection::vec(any_harm(), 1..=length_max))
        .prop_map(|(first, harms)| Burst { first, harms });
    prop::collection::vec(burst, 1..6)
}

/// What a tap has received and done.
#[derive(Debug, Default)]
struct Seen {
    received: Vec<u8>,
    /// Packets that arrived whole.
    whole: u64,
    /// Length of the current run of damaged packets.
    harmed_in_a_row: u64,
    runs: Vec<u64>,
}

/// Damages the gyro's stream from now on.
fn harm_gyro(rig: &mut Rig, bursts: &[Burst]) -> Arc<Mutex<Seen>> {
    let seen = Arc::new(Mutex::new(Seen::default()));
    let (told, bursts) = (Arc::clone(&seen), bursts.to_vec());
    let mut number = 0;
    rig.tap(Direction::GyroToController, move |_, piece| {
        let Transmit::Bytes(packet) = piece else { return vec![piece] };
        let harm = bursts
            .iter()
            .find_map(|burst| burst.harms.get(usize::checked_sub(number, burst.first)?));
        number += 1;
        let sent = packet.as_slice();
        let received = harm.map_or_else(|| sent.to_vec(), |harm| harm.done_to(sent));
        let mut seen = told.lock().expect("no closure panicked with it");
        if harm.is_some_and(Harm::takes_it) {
            seen.harmed_in_a_row += 1;
        } else {
            seen.whole += 1;
            if seen.harmed_in_a_row > 0 {
                let run = std::mem::take(&mut seen.harmed_in_a_row);
                seen.runs.push(run);
            }
        }
        seen.received.extend_from_slice(&received);
        bytes(&received)
    });
    seen
}

/// Whether garbage passed for a frame, or garbage before a valid frame spoiled it.
fn is_forged(stream: GyroStream, seen: &Seen) -> bool {
    let mut decoder = GyroDecoder::new(stream);
    decoder.feed(&seen.received, |_| {});
    decoder.counters().frames != seen.whole
}

const RATE_DEG: f64 = 30.0;
const TABLE_RAMP_DEG: f64 = 15.0;
/// The base follows 15 deg/s^2 with up to half as much again.
const BASE_RAMP_DEG: f64 = 22.5;
/// `GyroConfig::timeout`: longer gaps are not bridged.
const SILENCE_S: f64 = 0.1;
const SAMPLE_S: f64 = 0.01;

/// Maximum error of the heading after these runs of lost samples, including the wire's resolution. With |w'| <= a,
/// linear interpolation over T errs by at most a T^2 / 4; an unbridged gap, by at most the whole turn during the gap.
fn bound_deg(runs: &[u64], ramp_deg: f64, duration_s: f64) -> f64 {
    let missed = |run: &u64| {
        let span_s = (*run as f64 + 1.0) * SAMPLE_S;
        if span_s < SILENCE_S - SAMPLE_S {
            ramp_deg * span_s * span_s / 4.0
        } else {
            RATE_DEG * span_s
        }
    };
    runs.iter().map(missed).sum::<f64>() + navigator::RATE_STEP.deg_per_s() / 2.0 * duration_s
}

fn go_table(rig: &mut Rig, deg: i32) {
    let now = rig.now();
    let table = rig.table();
    for command in [
        TableCommand::TopRate(2_400),
        TableCommand::Ramp(1_200),
        TableCommand::Distance(deg * 80),
        TableCommand::Go,
    ] {
        table.command(now, command);
    }
}

fn off_deg(rig: &mut Rig) -> f64 {
    (rig.state().gyro_heading - rig.heading()).deg()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// 360 deg on the table take 14 s, 1400 samples.
    #[test]
    fn garbage_on_the_gyros_line_in_a_turn_costs_what_it_must(bursts in any_bursts(1_400, 30)) {
        let mut rig = Rig::new(&ideal_table(NAVIGATOR), 1).ready();
        let before = off_deg(&mut rig);
        let seen = harm_gyro(&mut rig, &bursts);
        go_table(&mut rig, 360);
        rig.run_for(Span::from_secs(16));
        prop_assume!(!is_forged(NAVIGATOR, &seen.lock().unwrap()));
        let off = (off_deg(&mut rig) - before).abs();
        let bound = bound_deg(&seen.lock().unwrap().runs, TABLE_RAMP_DEG, 14.0);
        prop_assert!(off <= bound, "{} deg, expected at most {}", off, bound);
        let lost = !seen.lock().unwrap().runs.is_empty();
        prop_assert_eq!(rig.health().causes.samples_lost, lost);
        prop_assert_eq!(rig.health().level, if lost { Level::Degraded } else { Level::Ok });
        // Everything recovers once the pose is set: a bias test cannot restore what was lost.
        rig.untap(Direction::GyroToController);
        rig.bias_test(1.0);
        prop_assert_eq!(rig.health().causes.samples_lost, lost);
        rig.set_pose();
        prop_assert_eq!(rig.health().level, Level::Ok);
        let before = off_deg(&mut rig);
        go_table(&mut rig, -90);
        rig.run_for(Span::from_secs(7));
        prop_assert!((off_deg(&mut rig) - before).abs() <= bound_deg(&[], 0.0, 5.0));
    }

    /// 90 deg on the base take 5 s.
    #[test]
    fn garbage_on_the_gyros_line_while_the_base_turns_either_costs_little_or_stops_it(
        bursts in any_bursts(600, 15), transport in prop::sample::select(vec![Transport::Can, Transport::Serial]),
    ) {
        let mut rig = Rig::new(&ideal(transport), 1).ready();
        let before = off_deg(&mut rig);
        let seen = harm_gyro(&mut rig, &bursts);
        let answer = rig.command(Rig::turn_order(90.0, RATE_DEG));
        rig.run_for(Span::from_secs(5));
        prop_assume!(!is_forged(NAVIGATOR, &seen.lock().unwrap()));
        let runs = seen.lock().unwrap().runs.clone();
        let off = (off_deg(&mut rig) - before).abs();
        let bound = bound_deg(&runs, BASE_RAMP_DEG, 10.0);
        prop_assert!(off <= bound, "{} deg, expected at most {}", off, bound);
        let longest = runs.iter().max().copied().unwrap_or(0);
        match answer {
            Answer::Done(MissionResult::Turn(result)) => {
                prop_assert!(result.stop_error.abs().deg() <= 0.1, "{:?}", result);
                // More than ten samples are more than 100 ms, unless everything stands already.
            }
            Answer::Aborted(AbortReason::GyroSilent) => prop_assert!(longest >= 9, "{}", longest),
            other => prop_assert!(false, "{:?}", other),
        }
        prop_assert!(!rig.state().moving);
    }

    /// Any bytes on any stream: no panic, and the gyro is received again afterwards.
    #[test]
    fn any_bytes_on_any_gyro_stream_are_survived(
        bursts in any_bursts(800, 60),
        format in prop::sample::select(GyroFormat::ALL.to_vec()),
    ) {
        let stream = GyroStream { format, mode: OutputMode::Rate, reversed: false };
        let mut rig = Rig::new(&ideal_table(stream), 1).ready();
        harm_gyro(&mut rig, &bursts);
        go_table(&mut rig, 90);
        rig.run_for(Span::from_secs(10));
        rig.untap(Direction::GyroToController);
        rig.run_for(Span::from_secs(1));
        rig.bias_test(1.0);
        rig.set_pose();
        let causes = rig.health().causes;
        prop_assert!(!causes.gyro_silent && !causes.gyro_fault && !causes.samples_lost);
        let before = off_deg(&mut rig);
        go_table(&mut rig, -90);
        rig.run_for(Span::from_secs(7));
        prop_assert!((off_deg(&mut rig) - before).abs() <= bound_deg(&[], 0.0, 5.0));
    }
}

/// Damage that the single checksum byte of the serial line always detects: one changed byte, missing bytes, or
/// additional bytes at the end.
fn any_honest_harm() -> impl Strategy<Value = Option<Harm>> {
    prop_oneof![
        4 => Just(None),
        1 => Just(Some(Harm::Drop)),
        1 => any::<usize>().prop_map(|length| Some(Harm::Cut(length))),
        1 => (any::<usize>(), any::<u8>()).prop_map(|(i, change)| Some(Harm::Change(i, change))),
        1 => prop::collection::vec(any::<u8>(), 1..10).prop_map(|bytes| Some(Harm::Behind(bytes))),
    ]
}

/// Damages a direction by this schedule, repeatedly.
fn harm(rig: &mut Rig, direction: Direction, schedule: &[Option<Harm>]) {
    let schedule = schedule.to_vec();
    let mut number = 0;
    rig.tap(direction, move |_, piece| {
        let harm = schedule[number % schedule.len()].as_ref();
        number += 1;
        match (harm, piece) {
            (None, piece) => vec![piece],
            (Some(harm), Transmit::Bytes(packet)) => bytes(&harm.done_to(packet.as_slice())),
            // A CAN bus does not change bits undetected: a frame arrives, or it does not.
            (Some(Harm::Drop | Harm::Cut(_) | Harm::Change(..)), Transmit::Frame(_)) => Vec::new(),
            (Some(harm), Transmit::Frame(frame)) => {
                let stranger = stranger(&harm.done_to(&[]));
                vec![Transmit::Frame(stranger), Transmit::Frame(frame)]
            }
        }
    });
}

/// A frame of a foreign node with these bytes.
fn stranger(bytes: &[u8]) -> CanFrame {
    let id = StandardId::new(0x2ff).expect("11 bits");
    CanFrame::new(id, &bytes[..bytes.len().min(8)]).expect("at most eight bytes")
}

fn is_at_rest(rig: &mut Rig) -> bool {
    let truth = rig.truth();
    truth.speed == Speed::ZERO && truth.steer_rate == AngularRate::ZERO
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn garbage_on_the_bases_line_is_repeated_survived_or_ends_at_rest(
        to_base in prop::collection::vec(any_honest_harm(), 1..40),
        to_controller in prop::collection::vec(any_honest_harm(), 1..40),
        transport in prop::sample::select(vec![Transport::Can, Transport::Serial]),
    ) {
        let mut rig = Rig::new(&ideal(transport), 1).ready();
        harm(&mut rig, Direction::ControllerToBase, &to_base);
        harm(&mut rig, Direction::BaseToController, &to_controller);
        let from = rig.truth().pose.x;
        let answer = rig.command(Rig::straight_order(1.0, 0.4));
        rig.run_for(Span::from_secs(5));
        prop_assert!(is_at_rest(&mut rig), "{:?}", answer);
        let truth = rig.truth().pose;
        match answer {
            Answer::Done(MissionResult::Straight(result)) => {
                prop_assert!(result.stop_error.abs().m() <= 0.002, "{:?}", result);
                let travelled = (truth.x - from).m();
                prop_assert!((travelled - 1.0).abs() <= 0.0021, "{} m", travelled);
            }
            // At rest there was no answer in time, in motion or to a pose write.
            Answer::Refused(_) => prop_assert!(truth.x == from),
            Answer::Aborted(
                AbortReason::BaseSilent
                | AbortReason::BaseCommandTimeout
                | AbortReason::PoseWriteRefused
                | AbortReason::TimedOut,
            ) => {}
            other => prop_assert!(false, "{:?}", other),
        }
        // The gyro's heading is not affected.
        prop_assert!(off_deg(&mut rig).abs() <= bound_deg(&[], 0.0, 10.0));

        rig.untap(Direction::ControllerToBase);
        rig.untap(Direction::BaseToController);
        rig.run_for(Span::from_secs(2));
        let zero = Command::SetPose(wire::units::Pose::default());
        prop_assert_eq!(rig.command(zero), Answer::Done(MissionResult::Applied));
        let causes = rig.health().causes;
        prop_assert!(!causes.base_silent && !causes.pose_not_written);
        let result = rig.straight(0.5, 0.4);
        prop_assert!(result.stop_error.abs().m() <= 0.002);
    }
}

#[test]
fn wrong_checksums_for_longer_than_the_time_out_are_silence() {
    let mut rig = Rig::new(&ideal(Transport::Can), 1).ready();
    let id = rig.under_way(Rig::turn_order(360.0, RATE_DEG), Span::from_secs(3));
    let since = rig.now();
    rig.tap(Direction::GyroToController, |_, piece| match piece {
        Transmit::Bytes(packet) => {
            let mut wrong = packet.as_slice().to_vec();
            wrong[4] ^= 1;
            bytes(&wrong)
        }
        frame => vec![frame],
    });
    assert_eq!(rig.finish(id), Answer::Aborted(AbortReason::GyroSilent));
    assert!((rig.now() - since).as_secs_f64() <= SILENCE_S + 1e-3);
}

#[test]
fn garbage_at_rest_does_not_turn_a_robot_that_stands() {
    for transport in [Transport::Can, Transport::Serial] {
        let mut rig = Rig::new(&ideal(transport), 1).ready();
        let before = rig.state().gyro_heading;
        let mut state = 1u32;
        rig.tap(Direction::GyroToController, move |_, piece| {
            // Includes forged frames: a linear congruential generator (constants of Numerical Recipes).
            let mut noise = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 24) as u8
            };
            let garbage: Vec<u8> = (0..40).map(|_| noise()).collect();
            [bytes(&garbage), vec![piece]].concat()
        });
        rig.run_for(Span::from_secs(60));
        assert_eq!(rig.state().gyro_heading, before);
    }
}

#[test]
fn frames_of_others_change_nothing() {
    let drive = |disturb: bool| {
        let mut rig = Rig::new(&ideal(Transport::Can), 1).ready();
        if disturb {
            for direction in [Direction::BaseToController, Direction::ControllerToBase] {
                rig.tap(direction, |_, piece| {
                    let Transmit::Frame(frame) = &piece else { return vec![piece] };
                    let short = CanFrame::new(frame.id(), &frame.data()[1..]).expect("shorter");
                    let remote = CanFrame::new_remote(frame.id(), 8).expect("eight bytes");
                    let wide = ExtendedId::new(0x181).expect("29 bits");
                    let wide = CanFrame::new(wide, frame.data()).expect("as many bytes");
                    let others = [short, remote, wide, stranger(&[0xff; 8])];
                    others.map(Transmit::Frame).into_iter().chain([piece]).collect()
                });
            }
        }
        let result = (rig.straight(1.0, 0.4), rig.turn(90.0, RATE_DEG));
        (result, rig.now(), rig.base().frames_ignored())
    };
    let (quiet, disturbed) = (drive(false), drive(true));
    assert_eq!((quiet.0, quiet.1), (disturbed.0, disturbed.1));
    assert_eq!(quiet.2, 0);
    assert!(disturbed.2 > 100, "{} frames were counted", disturbed.2);
}

#[test]
fn a_serial_base_counts_what_it_does_not_understand() {
    let mut rig = Rig::new(&ideal(Transport::Serial), 1).ready();
    for garbage in [&b":0102"[..], b"\r", b";05E000011B\r", b":zz\r", b"noise", &[0xff; 64]] {
        rig.inject(Direction::ControllerToBase, &bytes(garbage)[0]);
    }
    rig.straight(0.5, 0.4);
    let counters = rig.base().serial_counters();
    assert_eq!(counters.bad_checksum, 1, "{counters:?}");
    assert!(counters.malformed >= 2 && counters.skipped >= 64, "{counters:?}");
}
