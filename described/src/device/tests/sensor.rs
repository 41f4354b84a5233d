//! Signals of a sensor with a model of its errors.

use super::{at, listed, run};
use crate::description::tests::shown;
use crate::{Description, Device, Files, Input, Step, Steps};
use std::sync::Arc;

const TEXT: &str = r#"
name = "rate-sensor"
[serial]
baud = 115200
[[message]]
name = "Reading"
sent_by = "device"
text = "{Rate:.3}\r\n"
fields = [{ name = "Rate", unit = "deg/s" }]
period_s = 1
[parameter.turning]
value = 10
[state.case]
start = "20"
rate = "1"
[signal.Rate]
expression = "turning"
model = "gyro.model.toml"
temperature = "case"
"#;

/// A bias of 0.1 deg/s per kelvin above 20 degC, and a scale that is 1 % too large.
struct Drifts;

impl Files for Drifts {
    fn text(&mut self, name: &str) -> Result<String, String> {
        Err(format!("no {name}"))
    }

    fn errors(&mut self, name: &str, unit: &str) -> Result<Steps, String> {
        if name != "gyro.model.toml" {
            return self.text(name).map(|_| Steps::default());
        }
        if unit != "deg/s" {
            return Err(format!("it is of a rate, not of {unit}"));
        }
        let input = |name: &str, input| (name.to_owned(), input);
        let expression = "clamp(1.01 * x + 0.1 * (T - 20), -15, 15)".to_owned();
        Ok(Steps {
            inputs: vec![input("x", Input::Value), input("T", Input::Named("temperature".into()))],
            steps: vec![Step { name: "read".to_owned(), expression, first: None }],
            delay_s: 0.0,
        })
    }
}

#[test]
fn it_errs_in_the_unit_of_its_signal() {
    let description = Description::parse_with("sensor.toml", TEXT, &mut Drifts).unwrap();
    let mut device = Device::new(Arc::new(description.clone()), 1);
    let sent = run(&mut device, 3.0);
    let read = ["1 Reading [10.2]", "2 Reading [10.3]", "3 Reading [10.4]"];
    assert_eq!(listed(description.layout(), &sent), read);
    assert!((device.value("Rate").unwrap() - 10.4).abs() < 1e-9, "looked at, not read");
    assert!(device.set_parameter(at(3.0), "turning", 100.0));
    let sent = run(&mut device, 4.0);
    assert_eq!(listed(description.layout(), &sent), ["4 Reading [15.0]"], "its range");
}

#[test]
fn what_is_true_may_be_a_record() {
    let text = TEXT.replacen("expression = \"turning\"", "steps = [[0, 10], [2, 0]]", 1);
    let description = Description::parse_with("sensor.toml", &text, &mut Drifts).unwrap();
    let mut device = Device::new(Arc::new(description.clone()), 1);
    let sent = run(&mut device, 2.0);
    let read = ["1 Reading [10.2]", "2 Reading [0.2]"];
    assert_eq!(listed(description.layout(), &sent), read);
}

#[test]
fn what_is_missing_or_has_no_meaning_is_said_in_its_place() {
    let changes = [
        ("temperature = \"case\"\n", ""),
        ("expression = \"turning\"\n", ""),
        ("unit = \"deg/s\"", "unit = \"degC\""),
        ("model = \"gyro", "model = \"giro"),
        ("model = \"gyro.model.toml\"\n", ""),
        ("expression = \"turning\"", "expression = 1\nsteps = [[0, 1]]"),
    ];
    let refused = changes.map(|(from, to)| {
        assert!(TEXT.contains(from), "{from}");
        let text = TEXT.replacen(from, to, 1);
        let error = Description::parse_with("sensor.toml", &text, &mut Drifts).unwrap_err();
        format!("{from} -> {to}\n{}", shown(&error))
    });
    insta::assert_snapshot!(refused.join("\n"));
}

#[test]
fn what_is_sent_is_corrected_by_what_the_device_knows() {
    let description = Description::parse_with("sensor.toml", TEXT, &mut Drifts).unwrap();
    let mut device = Device::new(Arc::new(description.clone()), 1);
    run(&mut device, 1.0);
    let named = |name: &str| Input::Named(name.to_owned());
    let expression = "(x - 0.1 * (case - 20)) / 1.01".to_owned();
    let steps = Steps {
        inputs: vec![("x".to_owned(), Input::Value), ("case".to_owned(), named("case"))],
        steps: vec![Step { name: "corrected".to_owned(), expression, first: None }],
        delay_s: 0.0,
    };
    device.correct("Rate", Some(&steps)).unwrap();
    let mut sent = run(&mut device, 3.0);
    device.correct("Rate", None).unwrap();
    sent.extend(run(&mut device, 4.0));
    let read = ["2 Reading [10.0]", "3 Reading [10.0]", "4 Reading [10.5]"];
    assert_eq!(listed(description.layout(), &sent), read);
    let unknown = Steps { inputs: vec![("y".to_owned(), named("oil"))], ..steps.clone() };
    assert_eq!(device.correct("Rate", Some(&unknown)).unwrap_err(), "the device knows no `oil`");
    assert_eq!(device.correct("Speed", Some(&steps)).unwrap_err(), "the device sends no `Speed`");
}
