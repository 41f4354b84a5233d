//! The oven: its behaviour with and without commands.

use super::{at, command, oven, run, values};
use crate::Description;
use crate::device::Device;
use std::sync::Arc;
use wire::time::Timestamp;

#[test]
fn the_oven_heats_as_the_exact_exponential() {
    let description = oven();
    let frame = command(description.layout(), 300.0, 1.0);
    let mut device = Device::new(Arc::clone(&description), 1);
    // Between two steps, so that the first step is a short one.
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
    assert_eq!((device.not_finite(), device.dropped(), device.clipped().count()), (0, 0, 0));
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
    // Repeating the command gives the same result.
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
    insta::assert_snapshot!(refused("ambient", 100.0), @"`ambient` cannot be 100 degC: its range is -40 to 60 degC");
    insta::assert_snapshot!(refused("hysteresis", -1.0), @"`hysteresis` cannot be -1 K: it is at least 0 K");
}
