//! What a described device does.

use super::{ANSWERS_MAX, Device, QUEUE_MAX};
use crate::layout::Wired;
use crate::{Description, Layout};
use proptest::prelude::*;
use std::sync::Arc;
use wire::can::CanFrame;
use wire::time::{Span, Timestamp};

const OVEN: &str = include_str!("../../tests/data/oven.toml");
const DBC: &str = include_str!("../../tests/data/oven.dbc");

fn parse(text: &str) -> Arc<Description> {
    let read = &mut |name: &str| match name {
        "oven.dbc" => Ok(DBC.to_owned()),
        "trace.csv" => Ok("t_s, temp\n0, 10\n1, 20\n3, 40\n".to_owned()),
        other => Err(format!("no file {other} in this test")),
    };
    let found = Description::parse("test.toml", text, read);
    Arc::new(found.unwrap_or_else(|error| panic!("{}: {error}", error.file())))
}

fn oven() -> Arc<Description> {
    parse(OVEN)
}

fn at(seconds: f64) -> Timestamp {
    Timestamp::from_secs_f64(seconds)
}

/// All that the device sends up to and with `until`, woken when it asks for it.
fn run(device: &mut Device, until: f64) -> Vec<(Timestamp, Wired)> {
    let mut sent = Vec::new();
    while device.next_wakeup() <= at(until) {
        let now = device.next_wakeup();
        device.wake(now);
        assert!(device.next_wakeup() > now, "it asks for what is past");
        while let Some(wired) = device.transmit() {
            sent.push((now, wired));
        }
    }
    device.wake(at(until));
    sent
}

fn command(layout: &Layout, setpoint: f64, enable: f64) -> CanFrame {
    let index = layout.find("Command").unwrap();
    match layout.encode(index, &[setpoint, enable]).unwrap() {
        Wired::Frame(frame) => frame,
        Wired::Bytes(_) => panic!("on CAN"),
    }
}

fn values(layout: &Layout, wired: &Wired) -> (usize, Vec<f64>) {
    let mut decoder = layout.decoder();
    let decoded = match wired {
        Wired::Frame(frame) => decoder.frame(frame),
        Wired::Bytes(packet) => {
            let mut found = None;
            decoder.bytes(packet.as_slice(), &mut |decoded| found = Some(decoded));
            found
        }
    };
    let decoded = decoded.unwrap();
    (decoded.message, decoded.values.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect())
}

/// All of what is sent as text: time in nanoseconds, message, values.
fn listed(layout: &Layout, sent: &[(Timestamp, Wired)]) -> Vec<String> {
    sent.iter()
        .map(|(at, wired)| {
            let (message, values) = values(layout, wired);
            format!("{} {} {values:?}", at.as_secs_f64(), layout.messages()[message].name)
        })
        .collect()
}

/// A device whose signal `x` shows an expression, with a state or two before it.
fn showing(rest: &str) -> Arc<Description> {
    parse(&format!(
        "name = \"d\"\n{rest}\n[[message]]\nname = \"M\"\nsent_by = \"device\"\ncan_id = 1\n\
         period_s = 0.1\nfields = [{{ name = \"x\", type = \"f64\" }}]\n\
         [[message]]\nname = \"H\"\nsent_by = \"host\"\ncan_id = 2\ntimeout_s = 1\n\
         initial = {{ u = 5 }}\nfields = [{{ name = \"u\", type = \"u8\" }}]\n"
    ))
}

#[test]
fn the_oven_heats_as_the_exact_exponential() {
    let description = oven();
    let frame = command(description.layout(), 300.0, 1.0);
    let mut device = Device::new(Arc::clone(&description), 1);
    // Between two steps, so that the first one is a short one.
    let begin = 0.1234567;
    for count in 0..1200 {
        let now = begin + 0.5 * f64::from(count);
        run(&mut device, now);
        device.receive_frame(at(now), &frame);
        let exact = 20.0 + 120.0 * (1.0 - f64::exp(-(now - begin) / 300.0));
        let found = device.value("temperature").unwrap();
        assert!((found - exact).abs() < 1e-9, "{now}: {found} instead of {exact}");
    }
    assert!(device.value("Temperature").unwrap() > 120.0);
    assert_eq!((device.not_finite(), device.dropped(), device.clipped()), (0, 0, 0));
}

#[test]
fn the_thermostat_keeps_the_setpoint_within_its_hysteresis() {
    let description = oven();
    let frame = command(description.layout(), 60.0, 1.0);
    let mut device = Device::new(Arc::clone(&description), 1);
    let (mut switched, mut before) = (0, 0.0);
    for count in 0..6000 {
        let now = 0.5 * f64::from(count);
        run(&mut device, now);
        device.receive_frame(at(now), &frame);
        let heater = device.value("heater").unwrap();
        switched += u32::from(heater != before);
        before = heater;
        if now > 300.0 {
            let temperature = device.value("temperature").unwrap();
            assert!((58.9..60.1).contains(&temperature), "{now} s: {temperature}");
        }
    }
    assert!(switched > 20, "{switched}");
}

#[test]
fn a_message_that_stays_away_is_forgotten_on_time() {
    let description = oven();
    let mut device = Device::new(Arc::clone(&description), 1);
    device.receive_frame(at(0.25), &command(description.layout(), 100.0, 1.0));
    assert_eq!((device.value("Setpoint"), device.value("heater")), (Some(100.0), Some(1.0)));
    run(&mut device, 1.2499);
    assert_eq!(device.value("Command.Enable"), Some(1.0));
    run(&mut device, 1.25);
    assert_eq!((device.value("Setpoint"), device.value("Enable")), (Some(20.0), Some(0.0)));
    assert_eq!(device.value("heater"), Some(0.0));
    // Again is again.
    device.receive_frame(at(2.0), &command(description.layout(), 100.0, 1.0));
    device.receive_frame(at(2.9), &command(description.layout(), 100.0, 1.0));
    run(&mut device, 3.5);
    assert_eq!(device.value("heater"), Some(1.0));
    run(&mut device, 3.95);
    assert_eq!(device.value("heater"), Some(0.0));
}

#[test]
fn an_answer_comes_after_its_delay_and_a_period_on_its_own() {
    let description = oven();
    let mut device = Device::new(Arc::clone(&description), 1);
    let mut sent = run(&mut device, 0.15);
    device.receive_frame(at(0.15), &command(description.layout(), 100.0, 1.0));
    sent.extend(run(&mut device, 0.25));
    let layout = description.layout();
    let times: Vec<_> = sent
        .iter()
        .map(|(at, wired)| (at.as_nanos() / 1_000, values(layout, wired).0))
        .map(|(micros, message)| (micros, layout.messages()[message].name.as_str()))
        .collect();
    assert_eq!(times, [(100_000, "Status"), (152_000, "Report"), (200_000, "Status")]);
    assert_eq!(values(layout, &sent[1].1).1, [1500.0]);
}

#[test]
fn off_it_is_silent_and_deaf_and_on_again_at_its_start() {
    let description = oven();
    let frame = command(description.layout(), 100.0, 1.0);
    let mut device = Device::new(Arc::clone(&description), 1);
    device.receive_frame(at(0.0), &frame);
    run(&mut device, 0.9);
    assert!(device.value("temperature").unwrap() > 20.3);
    assert!(device.set_parameter(at(0.95), "ambient", 10.0));
    device.receive_frame(at(0.95), &frame);
    device.power(at(0.951), false);
    assert_eq!((device.next_wakeup(), device.transmit()), (Timestamp::MAX, None));
    device.receive_frame(at(1.0), &frame);
    device.wake(at(2.0));
    assert_eq!(device.transmit(), None);
    device.power(at(5.0), true);
    assert_eq!(device.value("temperature"), Some(10.0));
    assert_eq!(device.value("Enable"), Some(0.0));
    let sent = run(&mut device, 5.35);
    let times: Vec<_> = sent.iter().map(|(at, _)| at.as_nanos() / 1_000_000).collect();
    assert_eq!(times, [5100, 5200, 5300]);
}

#[test]
fn parameters_are_set_in_their_range() {
    let mut device = Device::new(oven(), 1);
    assert!(!device.set_parameter(at(0.0), "ambient", 100.0));
    assert!(!device.set_parameter(at(0.0), "ambient", f64::NAN));
    assert!(!device.set_parameter(at(0.0), "temperature", 30.0));
    assert!(!device.set_parameter(at(0.0), "t", 30.0));
    assert_eq!(device.value("ambient"), Some(20.0));
    assert!(device.set_parameter(at(0.0), "ambient", 50.0));
    run(&mut device, 300.0);
    let exact = 20.0 + 30.0 * (1.0 - f64::exp(-1.0));
    assert!((device.value("temperature").unwrap() - exact).abs() < 1e-9);
    let mut warm = Description::clone(&oven());
    assert_eq!(warm.set_parameter("ambient", 30.0), Ok(()));
    assert!(warm.set_parameter("ambient", 70.0).is_err());
    assert_eq!(Device::new(Arc::new(warm), 1).value("temperature"), Some(30.0));
    let refused = |name: &str, value| oven().check_parameter(name, value).unwrap_err();
    insta::assert_snapshot!(refused("ambiant", 1.0), @"no parameter `ambiant`: did you mean `ambient`?");
    insta::assert_snapshot!(refused("ambient", 100.0), @"`ambient` cannot be 100: it goes from -40 to 60");
    insta::assert_snapshot!(refused("hysteresis", -1.0), @"`hysteresis` cannot be -1: it is at least 0");
}

#[test]
fn noise_belongs_to_seed_and_signal() {
    let noisy = |toml: &str, seed| {
        let description = parse(toml);
        let mut device = Device::new(Arc::clone(&description), seed);
        let sent = run(&mut device, 20.0);
        let first = |(_, wired): &(Timestamp, Wired)| values(description.layout(), wired).1[0];
        sent.iter().map(first).collect::<Vec<f64>>()
    };
    let (one, again, other) = (noisy(OVEN, 1), noisy(OVEN, 1), noisy(OVEN, 2));
    assert_eq!(one, again);
    assert_ne!(one, other);
    // Another signal's noise shifts nothing.
    let more = OVEN.replace("expression = \"heater\"", "expression = \"heater\"\nnoise = 0.1");
    assert_ne!(more, OVEN);
    assert_eq!(noisy(&more, 1), one);
    let mean = one.iter().sum::<f64>() / one.len() as f64;
    let square = |value: &f64| (value - mean) * (value - mean);
    let rms = (one.iter().map(square).sum::<f64>() / (one.len() - 1) as f64).sqrt();
    // Of 200 values the standard deviation is known to 5 %.
    assert!((mean - 20.0).abs() < 0.02 && (0.04..0.06).contains(&rms), "{mean} {rms}");
    assert!(Device::new(oven(), 1).value("Temperature") == Some(20.0));
}

#[test]
fn what_is_not_finite_leaves_what_was_before() {
    let description = showing(
        "[state.a]\nstart = 2\nrate = \"if(t > 0.2, 0 / 0, 1)\"\n[state.b]\nvalue = \"1 / (t < 0.25)\"\n\
         [signal.x]\nexpression = \"a / (t < 0.35)\"\n",
    );
    let mut device = Device::new(Arc::clone(&description), 1);
    let sent = run(&mut device, 0.5);
    let shown: Vec<f64> =
        sent.iter().map(|(_, wired)| values(description.layout(), wired).1[0]).collect();
    for (value, expected) in shown.iter().zip([2.1, 2.2, 2.2, 2.2, 2.2]) {
        assert!((value - expected).abs() < 0.02, "{shown:?}");
    }
    assert_eq!(device.value("b"), Some(1.0));
    assert!(device.not_finite() > 20, "{}", device.not_finite());
}

#[test]
fn what_is_beyond_its_range_is_sent_as_its_end() {
    let text = OVEN.replace("expression = \"temperature\"", "expression = \"1e6 * (t - 0.15)\"");
    let description = parse(&text);
    let mut device = Device::new(Arc::clone(&description), 1);
    let sent = run(&mut device, 0.2);
    let first = |(_, wired): &(Timestamp, Wired)| values(description.layout(), wired).1[0];
    assert_eq!(sent.iter().map(first).collect::<Vec<_>>(), [-40.0, 320.0]);
    assert_eq!(device.clipped(), 2);
}

#[test]
fn series_go_on_from_power_on() {
    for (source, expected) in [
        ("steps = [[0, 1], [0.2, 2], [0.35, 3]]", [1.0, 2.0, 2.0, 3.0]),
        ("steps = [[0, 0], [0.4, 4]]\ninterpolate = true", [1.0, 2.0, 3.0, 4.0]),
        ("steps = [[0, 0], [0.15, 1], [0.25, 2]]\nrepeat = true", [0.0, 1.0, 0.0, 1.0]),
        ("csv = \"trace.csv\"\ninterpolate = true", [11.0, 12.0, 13.0, 14.0]),
        ("csv = \"trace.csv\"\ntime = \"temp\"\nvalue = \"t_s\"", [0.0; 4]),
    ] {
        let description = showing(&format!("[signal.x]\n{source}"));
        let mut device = Device::new(Arc::clone(&description), 1);
        for begin in [0.0, 7.0] {
            device.power(at(begin), false);
            device.power(at(begin), true);
            let sent = run(&mut device, begin + 0.42);
            let first = |(_, wired): &(Timestamp, Wired)| values(description.layout(), wired).1[0];
            let shown: Vec<f64> = sent.iter().map(first).collect();
            let near = shown.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
            assert!(near && shown.len() == 4, "{source}: {shown:?}");
        }
    }
}

#[test]
fn what_nobody_takes_is_dropped_and_counted() {
    let description = oven();
    let frame = command(description.layout(), 100.0, 1.0);
    let mut device = Device::new(Arc::clone(&description), 1);
    for _ in 0..ANSWERS_MAX + 3 {
        device.receive_frame(at(0.0), &frame);
    }
    assert_eq!(device.dropped(), 3);
    for count in 1..=100 {
        device.wake(at(0.1 * f64::from(count)));
    }
    let mut waiting = 0;
    while device.transmit().is_some() {
        waiting += 1;
    }
    assert_eq!(waiting, QUEUE_MAX);
    assert_eq!(device.dropped(), (3 + 100 + ANSWERS_MAX - QUEUE_MAX) as u64);
}

#[test]
fn a_meter_answers_over_a_serial_line() {
    let description = parse(
        "name = \"meter\"\n[serial]\nbaud = 9600\n[parameter.level]\nvalue = 1.5\n\
         [signal.Level]\nexpression = \"level\"\n\
         [[message]]\nname = \"Ask\"\nsent_by = \"host\"\ntext = \"LEVEL?\\r\\n\"\n\
         [[message]]\nname = \"Set\"\nsent_by = \"host\"\ntext = \"SET {Gain}\\r\\n\"\n\
         [[message]]\nname = \"Tell\"\nsent_by = \"device\"\ntext = \"L={Level:.3}\\r\\n\"\nanswers = \"Ask\"\n",
    );
    let mut device = Device::new(description, 1);
    device.receive_bytes(at(1.0), b"?\r\nLEV");
    assert_eq!(device.transmit(), None);
    device.receive_bytes(at(1.1), b"EL?\r\nSET 2.5\r\nLEVEL?\r\n");
    let mut sent = Vec::new();
    while let Some(Wired::Bytes(line)) = device.transmit() {
        sent.extend_from_slice(line.as_slice());
    }
    assert_eq!(sent.escape_ascii().to_string(), "L=1.500\\r\\nL=1.500\\r\\n");
    assert_eq!((device.value("Gain"), device.damaged()), (Some(2.5), 3));
}

#[test]
fn a_multiplexer_that_nobody_drives_takes_its_pages_in_turn() {
    let dbc = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: D H\n\nBO_ 1 M: 3 D\n \
               SG_ Page M : 0|8@1+ (1,0) [0|255] \"\" H\n SG_ A m2 : 8|8@1+ (1,0) [0|0] \"\" H\n \
               SG_ B m7 : 8|8@1+ (1,0) [0|0] \"\" H\n\n";
    let text = "name = \"d\"\ndbc = \"d.dbc\"\nnode = \"D\"\nmessage.M.period_s = 1\n\
                signal.A.expression = 3\nsignal.B.expression = \"4 + t\"\n";
    let description = Description::parse("d.toml", text, &mut |_| Ok(dbc.to_owned())).unwrap();
    let mut device = Device::new(Arc::new(description.clone()), 1);
    let sent = listed(description.layout(), &run(&mut device, 3.0));
    assert_eq!(sent, ["1 M [2.0, 3.0, NaN]", "2 M [7.0, NaN, 6.0]", "3 M [2.0, 3.0, NaN]"]);
}

#[test]
fn woken_late_it_sends_once_and_keeps_its_grid() {
    let mut device = Device::new(oven(), 1);
    device.wake(at(1.05));
    assert!(device.transmit().is_some() && device.transmit().is_none());
    assert_eq!(device.next_wakeup(), at(1.1));
    // And before its time not at all, nor in the past.
    device.wake(at(1.06));
    device.wake(at(0.5));
    assert_eq!(device.transmit(), None);
}

#[test]
fn the_end_of_all_time_is_reached() {
    let mut device = Device::new(showing("step_s = 1e6\n[state.a]\nrate = 1\n"), 1);
    device.wake(Timestamp::MAX);
    assert!(device.transmit().is_some());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Waking is no event: only what is received and sent is.
    #[test]
    fn what_it_sends_does_not_depend_on_how_often_it_is_woken(
        wakes in prop::collection::vec(0i64..5_000_000_000, 0..40), told in 0i64..4_000_000_000
    ) {
        let description = oven();
        let frame = command(description.layout(), 80.0, 1.0);
        let told = Timestamp::from_nanos(told);
        let mut plain = Device::new(Arc::clone(&description), 5);
        let mut woken = Device::new(Arc::clone(&description), 5);
        let seconds = |at: Timestamp| at.as_secs_f64();
        let mut expected = run(&mut plain, seconds(told));
        plain.receive_frame(told, &frame);
        expected.extend(run(&mut plain, 5.0));

        let mut wakes = wakes;
        wakes.sort_unstable();
        let mut found = Vec::new();
        let (before, behind): (Vec<i64>, Vec<i64>) =
            wakes.into_iter().partition(|nanos| *nanos < told.as_nanos());
        for nanos in before {
            found.extend(run(&mut woken, seconds(Timestamp::from_nanos(nanos))));
        }
        found.extend(run(&mut woken, seconds(told)));
        woken.receive_frame(told, &frame);
        for nanos in behind {
            found.extend(run(&mut woken, seconds(Timestamp::from_nanos(nanos))));
        }
        found.extend(run(&mut woken, 5.0));
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn nothing_that_it_receives_makes_it_panic(
        frames in prop::collection::vec((0u16..0x7ff, prop::collection::vec(any::<u8>(), 0..=8)), 0..20),
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        times in prop::collection::vec(any::<i64>(), 1..5)
    ) {
        let mut device = Device::new(showing("[signal.x]\nexpression = \"u / (u - 7)\"\n"), 1);
        for time in times {
            let now = Timestamp::from_nanos(time);
            for (id, data) in &frames {
                let id = wire::can::StandardId::new(*id).unwrap();
                device.receive_frame(now, &CanFrame::new(id, data).unwrap());
            }
            device.receive_bytes(now, &bytes);
            device.wake(now);
            device.power(now + Span::from_secs(1), time % 2 == 0);
        }
    }
}
