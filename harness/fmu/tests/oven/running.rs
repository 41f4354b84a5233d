//! What devices make of an FMU while it runs.

use crate::{DEVICE, at, device, folder, read, run};
use wire::device::Transmit;

/// The temperature after each step of the oven, by its equation.
fn expected(steps: usize) -> Vec<f64> {
    let (mut temperature, h) = (18.0_f64, 0.02 / 10.0);
    let mut all = vec![temperature];
    for step in 0..steps {
        let from = step as f64 * 0.02;
        let power = if from >= 2.0 {
            0.0
        } else if from >= 0.5 {
            1000.0
        } else {
            400.0
        };
        for _ in 0..10 {
            temperature += h * ((power - (temperature - 18.0) * 2.0) / 250.0);
        }
        all.push(temperature);
    }
    all
}

#[test]
fn outputs_are_states_that_change_with_each_step() {
    for version in [2, 3] {
        let folder = folder(version);
        let mut device = device(&folder, DEVICE);
        let sent = run(&mut device, at(3.0));
        let expected = expected(150);
        assert_eq!(sent.len(), 150);
        for ((_, bytes), expected) in sent.iter().zip(&expected[1..]) {
            assert_eq!(f64::from_le_bytes(bytes[..8].try_into().unwrap()), *expected);
        }
        assert_eq!(device.value("inside"), Some(expected[150]));
        // A boolean and a whole number.
        assert_eq!((device.value("is_hot"), device.value("done")), (Some(0.0), Some(150.0)));
        assert_eq!(device.description().unit("inside"), Some("degC"));
        assert_eq!(device.description().doc("inside"), Some("Temperature of the load"));
        assert_eq!(run(&mut crate::device(&folder, DEVICE), at(3.0)), sent);
    }
}

#[test]
fn steps_do_not_depend_on_when_the_device_is_woken_or_receives() {
    let folder = folder(2);
    let (mut often, mut once) = (device(&folder, DEVICE), device(&folder, DEVICE));
    for tick in 1..=1000 {
        let now = at(0.0013 * f64::from(tick));
        often.wake(now);
        let mut host = described::Outbox::new(
            often.description().layout().clone(),
            described::Sender::Host,
            8,
        );
        host.send(now, 1, &[7.0], |_| false).unwrap();
        if let Some(Transmit::Frame(frame)) = host.transmit() {
            often.receive_frame(now, &frame);
        }
        while often.transmit().is_some() {}
    }
    run(&mut once, at(1.3));
    assert_eq!(often.value("inside"), once.value("inside"));
    assert_eq!(often.value("done"), Some(65.0));
}

#[test]
fn a_received_signal_acts_from_the_next_step_on() {
    let folder = folder(3);
    let text = DEVICE.replace("\"if(t >= 0.5, 1000, 400)\"", "\"Power\"").replace("\"t < 2\"", "1");
    let mut device = device(&folder, &text);
    run(&mut device, at(0.109));
    let mut host =
        described::Outbox::new(device.description().layout().clone(), described::Sender::Host, 8);
    host.send(at(0.11), 1, &[500.0], |_| false).unwrap();
    let Some(Transmit::Frame(frame)) = host.transmit() else { panic!("nothing is sent") };
    device.receive_frame(at(0.11), &frame);
    run(&mut device, at(0.12));
    assert_eq!(device.value("inside"), Some(18.0));
    run(&mut device, at(0.14));
    assert!(device.value("inside").unwrap() > 18.0);
}

#[test]
fn an_input_that_changes_as_a_step_begins_acts_in_it() {
    let folder = folder(3);
    let text = DEVICE.replace("\"if(t >= 0.5, 1000, 400)\"", "\"Power\"").replace("\"t < 2\"", "1");
    let mut device = device(&folder, &text);
    run(&mut device, at(0.12));
    let mut host =
        described::Outbox::new(device.description().layout().clone(), described::Sender::Host, 8);
    host.send(at(0.12), 1, &[500.0], |_| false).unwrap();
    let Some(Transmit::Frame(frame)) = host.transmit() else { panic!("nothing is sent") };
    device.receive_frame(at(0.12), &frame);
    run(&mut device, at(0.14));
    assert!(device.value("inside").unwrap() > 18.0);
}

#[test]
fn a_tunable_parameter_follows_and_a_fixed_one_waits_for_power_on() {
    let folder = folder(2);
    let mut device = device(&folder, DEVICE);
    run(&mut device, at(1.0));
    let before = device.value("inside").unwrap();
    // Setting a fixed one in a run is an error of the oven: nobody does.
    assert!(device.set_parameter(at(1.0), "load", 500.0));
    assert!(device.set_parameter(at(1.0), "room", 5000.0));
    run(&mut device, at(1.5));
    let much = device.value("inside").unwrap() - before;
    assert!(much > 10.0, "{much}");
    device.power(at(2.0), false);
    device.power(at(3.0), true);
    assert_eq!(device.value("inside"), Some(5000.0));
    assert_eq!(device.value("done"), Some(0.0));
    run(&mut device, at(3.1));
    assert_eq!(device.value("done"), Some(5.0));
    assert_eq!(device.failure(at(3.1)), None);
}

#[test]
fn instances_of_a_library_for_one_a_process_are_apart() {
    let folder = tempfile::tempdir().unwrap();
    fmu::samples::oven(&folder.path().join("oven.fmu"), 2, |text| {
        text.replace(
            "<CoSimulation ",
            "<CoSimulation canBeInstantiatedOnlyOncePerProcess=\"true\" ",
        )
    });
    let (mut one, mut other) = (device(&folder, DEVICE), device(&folder, DEVICE));
    assert_eq!(run(&mut one, at(1.0)), run(&mut other, at(1.0)));
}

#[test]
fn a_device_with_an_fmu_is_not_copied_and_a_step_of_its_own_applies() {
    let folder = folder(2);
    let text = DEVICE.replace("file = \"oven.fmu\"", "file = \"oven.fmu\"\nstep_s = 0.05");
    let mut device = device(&folder, &text);
    run(&mut device, at(1.0));
    assert_eq!(device.value("done"), Some(20.0));
    assert!(!device.can_be_copied());
    let mut copy = device.clone();
    copy.wake(at(1.05));
    assert!(copy.failure(at(1.05)).unwrap().contains("cannot go on with an FMU"));
    let described = read(&folder, &text).unwrap();
    assert_eq!(described.states().collect::<Vec<_>>(), ["done", "inside", "is_hot"]);
}
