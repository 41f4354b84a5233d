use super::{ANSWERS_MAX, TableEmulator, TableParameters};
use proptest::prelude::*;
use wire::time::{Span, Timestamp};

fn table(parameters: TableParameters) -> TableEmulator {
    TableEmulator::new(parameters)
}

fn say(table: &mut TableEmulator, now: Timestamp, line: &str) -> String {
    table.receive(now, line.as_bytes());
    let mut answers = String::new();
    while let Some(packet) = table.transmit() {
        answers.push_str(std::str::from_utf8(packet.as_slice()).unwrap());
    }
    answers
}

/// Moves by `deg`; returns the end of the move and the angle there, in degrees.
fn turn(table: &mut TableEmulator, now: Timestamp, deg: f64) -> (Timestamp, f64) {
    let line = format!("D{}\rG\r", (deg / 0.0125).round());
    assert_eq!(say(table, now, &line), "=D\r=G\r");
    let end = table.next_wakeup().unwrap();
    table.wake(end);
    (end, table.angle_at(end).deg())
}

#[test]
fn an_ideal_table_turns_what_it_is_told() {
    let mut table = table(TableParameters::default());
    let (end, angle) = turn(&mut table, Timestamp::ZERO, -360.0);
    assert_eq!(end, Timestamp::from_secs_f64(14.0));
    assert!((angle + 360.0).abs() < 1e-9);
    assert!((table.angle_at(end + Span::from_secs(9)).deg() + 360.0).abs() < 1e-9);
    assert_eq!(table.next_wakeup(), None);
}

#[test]
fn the_indexer_answers() {
    let mut table = table(TableParameters { rate_max_steps_per_s: 5_000.0, ..Default::default() });
    let at = |millis| Timestamp::ZERO + Span::from_millis(millis);
    assert_eq!(say(&mut table, at(0), "?\r"), "=P0 M0\r");
    assert_eq!(say(&mut table, at(0), "V2400\rA1200\rD28800\rG\r"), "=V\r=A\r=D\r=G\r");
    assert_eq!(say(&mut table, at(1_000), "?\r"), "=P600 M1\r");
    assert_eq!(say(&mut table, at(1_000), "G\r"), "!G\r");
    assert_eq!(say(&mut table, at(14_000), "?\r"), "=P28800 M0\r");
    assert_eq!(say(&mut table, at(14_000), "V0\rV5001\rA0\rX\r"), "!V\r!V\r!A\r!X\r");
    assert_eq!(say(&mut table, at(14_000), "D0\rG\r?\r"), "=D\r=G\r=P28800 M0\r");
}

#[test]
fn a_stop_ramps_down_to_a_whole_step() {
    let mut table = table(TableParameters::default());
    say(&mut table, Timestamp::ZERO, "D-28800\rG\r");
    let now = Timestamp::from_secs_f64(5.0);
    let before = table.angle_at(now);
    assert_eq!(say(&mut table, now, "S\r"), "=S\r");
    assert_eq!(table.angle_at(now), before);
    let end = table.next_wakeup().unwrap();
    // 2400 steps/s at 1200 steps/s^2.
    assert!((end - now - Span::from_secs(2)).as_secs_f64().abs() < 1e-3);
    assert_eq!(say(&mut table, end, "?\rS\r"), "=P-12000 M0\r=S\r");
    assert!((table.angle_at(end).deg() + 150.0).abs() < 1e-9);
}

#[test]
fn ramped_too_hard_it_loses_whole_cycles_and_does_not_know() {
    let weak = TableParameters { acceleration_limit_steps_per_s2: 1_200.0, ..Default::default() };
    let mut table = table(weak);
    say(&mut table, Timestamp::ZERO, "A2400\r");
    let (end, angle) = turn(&mut table, Timestamp::ZERO, 360.0);
    // 1200 steps, 15 deg.
    assert_eq!(table.steps_lost_at(end), 1_200.0);
    assert!((angle - 345.0).abs() < 1e-9);
    assert_eq!(say(&mut table, end, "?\r"), "=P28800 M0\r");
    say(&mut table, end, "A1200\r");
    let (_, angle) = turn(&mut table, end, -360.0);
    assert!((angle + 15.0).abs() < 1e-9, "the second move lost nothing");
}

/// In a cw-ccw run play looks like a scale error of -B/360; three revolutions show the same B.
#[test]
fn play_is_lost_at_each_reversal_only() {
    let mut table = table(TableParameters { backlash_deg: 0.1, ..Default::default() });
    let (now, start) = turn(&mut table, Timestamp::ZERO, 10.0);
    assert!((start - 9.95).abs() < 1e-9, "from the middle of the play");
    let (now, same_way) = turn(&mut table, now, 360.0);
    assert!((same_way - start - 360.0).abs() < 1e-9);
    let (now, back) = turn(&mut table, now, -360.0);
    assert!((same_way - back - 359.9).abs() < 1e-9);
    let (_, thrice) = turn(&mut table, now, 3.0 * 360.0);
    assert!((thrice - back - (3.0 * 360.0 - 0.1)).abs() < 1e-9);
}

#[test]
fn eccentricity_shows_within_a_turn_and_vanishes_over_one() {
    let mut table = table(TableParameters {
        eccentricity_1x_deg: 0.05,
        eccentricity_1x_phase_deg: 30.0,
        eccentricity_2x_deg: 0.01,
        ..Default::default()
    });
    let (now, quarter) = turn(&mut table, Timestamp::ZERO, 90.0);
    let expected = 90.0 + 0.05 * (120f64.to_radians().sin() - 30f64.to_radians().sin());
    assert!((quarter - expected).abs() < 1e-9);
    let (_, whole) = turn(&mut table, now, 270.0);
    assert!((whole - 360.0).abs() < 1e-9);
}

#[test]
fn answers_are_bounded() {
    let mut table = table(TableParameters::default());
    table.receive(Timestamp::ZERO, "?\r".repeat(ANSWERS_MAX + 3).as_bytes());
    assert_eq!(table.answers_dropped(), 3);
}

proptest! {
    #[test]
    fn the_angle_is_continuous_whatever_comes(
        lines in prop::collection::vec(
            ("(V[1-4]000|A[1-9]00|D-?[0-9]{1,4}|G|S)\r", 1i64..3_000),
            1..20,
        ),
        backlash_deg in 0f64..1.0,
    ) {
        let mut table = table(TableParameters { backlash_deg, ..Default::default() });
        let mut now = Timestamp::ZERO;
        let mut last = table.angle_at(now);
        for (line, millis) in lines {
            say(&mut table, now, &line);
            for _ in 0..millis {
                now += Span::from_millis(1);
                table.wake(now);
                let angle = table.angle_at(now);
                // 4000 steps/s of 0.0125 deg.
                prop_assert!((angle - last).abs().deg() <= 0.05 + 1e-9);
                last = angle;
            }
        }
    }

    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        table(TableParameters::default()).receive(Timestamp::from_nanos(-5), &bytes);
    }
}
