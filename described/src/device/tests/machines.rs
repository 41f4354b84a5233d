//! State machines: transitions, assignments, and signals that depend on states.

use super::{at, parse, run, values};
use crate::device::Device;
use crate::{Description, Sender};
use proptest::prelude::*;
use std::sync::Arc;
use wire::can::CanFrame;
use wire::device::Transmit;
use wire::time::Timestamp;

/// A contactor: it closes on request after a pre-charge, and opens permanently on overvoltage.
const CONTACTOR: &str = r#"
name = "contactor"
[parameter.drift]
value = 0
[state.voltage]
start = 4
rate = "drift"
[state.latch]
start = 0
[state.trips]
[machine.mode]
states = ["Standby", "Precharge", "Closed", "Fault"]
start = "Standby"
transitions = [
  { from = ["Precharge", "Closed"], to = "Fault", when = "voltage > 4.3", set = { latch = "10 * voltage" } },
  { from = "Standby", to = "Precharge", when = "Close == 1 and latch == 0" },
  { from = "Precharge", to = "Closed", after_s = 0.5012345 },
  { from = ["Precharge", "Closed"], to = "Standby", when = "Close == 0" },
  { from = "Fault", to = "Standby", on = "Reset", set = { latch = 0, voltage = 4 } },
]
enter.Fault = { trips = "trips + 1" }
[signal.State]
expression = "mode"
[signal.Output]
in.mode = { Closed = "voltage", Precharge = "voltage * time_in(mode)" }
expression = 0
[signal.IsOpen]
expression = "mode != 'Closed'"
[[message]]
name = "Status"
sent_by = "device"
can_id = 1
send = "on_change"
fields = [{ name = "State", type = "u8" }]
[[message]]
name = "Values"
sent_by = "device"
can_id = 2
period_s = 0.25
fields = [{ name = "Output", type = "f32" }, { name = "IsOpen", type = "u8" }]
[[message]]
name = "Request"
sent_by = "host"
can_id = 3
fields = [{ name = "Close", type = "u8" }]
[[message]]
name = "Reset"
sent_by = "host"
can_id = 4
fields = []
"#;

fn frame(description: &Description, name: &str, values: &[f64]) -> CanFrame {
    let layout = description.layout();
    let index = layout.find(name).unwrap();
    assert_eq!(layout.messages()[index].sender, Sender::Host);
    match layout.encode(index, values).unwrap() {
        Transmit::Frame(frame) => frame,
        Transmit::Bytes(_) => panic!("on CAN"),
    }
}

fn mode(device: &Device) -> f64 {
    device.value("mode").unwrap()
}

#[test]
fn a_time_in_a_state_is_over_on_the_nanosecond() {
    let description = parse(CONTACTOR);
    let mut device = Device::new(Arc::clone(&description), 1);
    run(&mut device, 0.1003);
    device.receive_frame(at(0.1003), &frame(&description, "Request", &[1.0]));
    assert_eq!(mode(&device), 1.0, "at once, as the message is heard");
    let Some(Transmit::Frame(told)) = device.transmit() else { panic!("it tells at once") };
    assert_eq!(told.data(), [1]);
    let closed = Timestamp::from_nanos(601_534_500);
    let before = Timestamp::from_nanos(601_534_499);
    let sent = run(&mut device, 0.6015344);
    let shown: Vec<f64> =
        sent.iter().map(|(_, wired)| values(description.layout(), wired).1[0]).collect();
    let expected = [0.25, 0.5].map(|t| 4.0 * (t - 0.1003));
    assert!(
        shown.len() == 2 && shown.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6),
        "{shown:?}"
    );
    device.wake(before);
    assert_eq!((mode(&device), device.next_wakeup()), (1.0, closed));
    device.wake(closed);
    assert_eq!(mode(&device), 2.0);
    let Some(Transmit::Frame(frame)) = device.transmit() else { panic!("it tells at once") };
    assert_eq!(frame.data(), [2]);
}

#[test]
fn it_trips_at_the_end_of_a_step_and_stays_until_it_is_reset() {
    let description = parse(CONTACTOR);
    let mut device = Device::new(Arc::clone(&description), 1);
    device.receive_frame(at(0.0), &frame(&description, "Request", &[1.0]));
    run(&mut device, 1.0);
    assert_eq!((mode(&device), device.value("Output")), (2.0, Some(4.0)));
    assert!(device.set_parameter(at(1.0), "drift", 1.0));
    run(&mut device, 1.295);
    assert_eq!(mode(&device), 2.0);
    run(&mut device, 1.32);
    assert_eq!((mode(&device), device.value("Output")), (3.0, Some(0.0)));
    assert_eq!(device.value("trips"), Some(1.0));
    let latch = device.value("latch").unwrap();
    assert!((43.0..43.2).contains(&latch), "what it was on the way: {latch}");
    device.receive_frame(at(1.4), &frame(&description, "Request", &[0.0]));
    assert_eq!(mode(&device), 3.0);
    device.receive_frame(at(1.5), &frame(&description, "Reset", &[]));
    let found = ["mode", "latch", "voltage", "trips"].map(|name| device.value(name).unwrap());
    assert_eq!(found, [0.0, 0.0, 4.0, 1.0]);
    device.power(at(2.0), false);
    device.power(at(3.0), true);
    assert_eq!((mode(&device), device.value("trips")), (0.0, Some(0.0)));
}

#[test]
fn machines_go_on_in_the_order_in_which_they_are_written() {
    let text = |first: &str, second: &str| {
        let machine = |name: &str, when: &str| {
            format!(
                "[machine.{name}]\nstates = [\"Off\", \"On\", \"Over\"]\nstart = \"Off\"\ntransitions = [\
                 {{ from = \"Off\", to = \"On\", when = '{when}' }},\
                 {{ from = \"On\", to = \"Over\", when = 1 }}]\n"
            )
        };
        let of = |name: &str| match name {
            "a" => machine("a", "t > 0.015"),
            _ => machine("b", "a == \"On\""),
        };
        super::showing(&format!(
            "{}{}[signal.x]\nexpression = \"10 * a + b\"\n",
            of(first),
            of(second)
        ))
    };
    let after = |description: Arc<Description>, seconds: f64| {
        let mut device = Device::new(description, 1);
        device.wake(at(seconds));
        (device.value("a").unwrap(), device.value("b").unwrap())
    };
    // A later machine sees the change at once, an earlier one a step later, when it is already over.
    assert_eq!(after(text("a", "b"), 0.02), (1.0, 1.0));
    assert_eq!(after(text("b", "a"), 0.02), (1.0, 0.0));
    assert_eq!(after(text("b", "a"), 0.03), (2.0, 1.0));
    // One transition at a time.
    assert_eq!(after(text("a", "b"), 0.03), (2.0, 2.0));
}

#[test]
fn a_signal_that_is_heard_has_the_names_of_its_dbc() {
    let dbc = "BU_: D H\nBO_ 1 M: 1 D\n SG_ X : 0|8@1+ (1,0) [0|0] \"\" H\n\
               BO_ 2 Request: 1 H\n SG_ Wanted : 0|8@1+ (1,0) [0|0] \"\" D\n\
               VAL_ 2 Wanted 0 \"Open\" 7 \"Closed\" ;\n";
    let text = |value: &str| {
        format!(
            "name = \"d\"\ndbc = \"d.dbc\"\nnode = \"D\"\nmessage.M.period_s = 1\n\
             signal.X.expression = 'Wanted == \"{value}\"'\n"
        )
    };
    let parse =
        |value: &str| Description::parse("d.toml", &text(value), &mut |_| Ok(dbc.to_owned()));
    let description = parse("Closed").unwrap();
    let mut device = Device::new(Arc::new(description.clone()), 1);
    assert_eq!(device.value("X"), Some(0.0));
    device.receive_frame(at(0.1), &frame(&description, "Request", &[7.0]));
    assert_eq!(device.value("X"), Some(1.0));
    let error = parse("Close").unwrap_err();
    assert_eq!(
        (error.message(), error.advice()),
        ("`Wanted` is never `Close`", Some("did you mean `Closed`?"))
    );
}

#[test]
fn a_time_that_is_over_without_steps_is_over() {
    let description = super::showing(
        "step_s = 1e-5\n[machine.m]\nstates = [\"A\", \"B\"]\nstart = \"A\"\n\
         transitions = [{ from = \"A\", to = \"B\", after_s = 500 }]\n[signal.x]\nexpression = \"m\"\n",
    );
    // More steps than one call makes.
    let mut device = Device::new(description, 1);
    device.wake(at(600.0));
    device.wake(at(600.1));
    assert_eq!(device.value("m"), Some(1.0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// A wake-up is not an event for machines either.
    #[test]
    fn how_often_it_is_woken_makes_no_difference(
        wakes in prop::collection::vec(0i64..3_000_000_000, 0..40), told in 0i64..2_000_000_000
    ) {
        let description = parse(&CONTACTOR.replace("value = 0\n", "value = 0.2\n"));
        let told = Timestamp::from_nanos(told);
        let course = |wakes: &[i64]| {
            let mut device = Device::new(Arc::clone(&description), 1);
            let mut sent = Vec::new();
            let mut is_told = false;
            for nanos in wakes.iter().copied().chain([3_000_000_000]) {
                if nanos > told.as_nanos() && !is_told {
                    sent.extend(run(&mut device, told.as_secs_f64()));
                    device.receive_frame(told, &frame(&description, "Request", &[1.0]));
                    is_told = true;
                }
                sent.extend(run(&mut device, Timestamp::from_nanos(nanos).as_secs_f64()));
            }
            (sent, mode(&device))
        };
        let mut wakes = wakes;
        wakes.sort_unstable();
        prop_assert_eq!(course(&wakes), course(&[]));
    }
}
