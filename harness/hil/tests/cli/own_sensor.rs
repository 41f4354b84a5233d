//! A custom rate sensor whose errors follow a model identified from measured data.

use super::hil::Hil;
use std::fs;

const DEVICE: &str = r#"
name = "yaw-sensor"
title = "A yaw rate sensor that tells a line of text ten times a second"

[serial]
baud = 115200

[[message]]
name = "Reading"
sent_by = "device"
text = "{Rate:.4}\r\n"
fields = [{ name = "Rate", unit = "deg/s" }]
period_s = 0.1

[parameter.case]
value = 20
unit = "degC"

[signal.Rate]
steps = [[0, 0], [5, 30]]
model = "gyro.model.toml"
temperature = "case"
"#;

/// The scale over temperature of the paper's chain (`hil list models`), and a bias.
const MODEL: &str = r#"
schema = 1
kind = "turns"
[fields]
temperature = "temperature"
[[terms]]
name = "bias"
term = "bias"
form = "constant"
parameters = [{ name = "value", value = 36, unit = "deg/h" }]
[[terms]]
name = "scale_over_temperature"
term = "scale"
drivers = ["temperature"]
form = "linear"
parameters = [
    { name = "slope", value = -0.0014444, unit = "1/K" },
    { name = "origin", value = 36.98, unit = "Cel" },
]
"#;

const PLAN: &str = r#"
name = "turns"
title = "At rest, then turning at 30 deg/s, at two temperatures"
device = "yaw-sensor"
steps = [
    { wait = { duration_s = 4 }, label = "rest" },
    { wait_until = { above = { quantity = "signal.Rate", limit = 20 } }, time_limit_s = 10 },
    { wait = { duration_s = 2 }, label = "cold" },
    { set_parameter = { parameter = "device.case", value = 40 } },
    { wait = { duration_s = 1 } },
    { wait = { duration_s = 2 }, label = "warm" },
]
"#;

/// Bands of 0.1 mdeg/s, the resolution of the line, around the values of the model's formula: 0.01 deg/s at rest, and
/// 30 deg/s times 1 + 0.0014444 x 16.98 or 1 - 0.0014444 x 3.02.
const CHECKS: [(&str, f64); 3] = [("rest", 0.01), ("cold", 30.7458), ("warm", 29.8791)];

fn plan(off: f64) -> String {
    CHECKS.iter().fold(PLAN.to_owned(), |plan, (label, rate)| {
        let (low, high) = (rate + off - 1e-4, rate + off + 1e-4);
        plan + &format!(
            "[[measurement]]\nname = \"{label}\"\ndoc = \"Rate, {label}\"\nquantity = \"signal.Rate\"\n\
             unit = \"deg/s\"\nwhere = {{ \"during.{label}\" = 1 }}\nobservations_min = 15\n\
             check = {{ all_within = [{low}, {high}] }}\n"
        )
    })
}

#[test]
fn a_signal_errs_as_its_model_says() {
    let hil = Hil::new();
    for (name, text) in [
        ("devices/yaw-sensor.toml", DEVICE),
        ("devices/gyro.model.toml", MODEL),
        ("turns.toml", &plan(0.0)),
        ("off.toml", &plan(5e-4)),
    ] {
        let path = hil.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    hil.run(&["run", "./turns.toml"]).exits(0);
    let ran = hil.run(&["run", "./off.toml", "--out", "off"]).exits(1);
    assert!(ran.out.contains("cold"), "{}", ran.out);

    // An effect for which the signal has no place is refused by name, before anything runs.
    let leak = "[[terms]]\nname = \"leak\"\nterm = \"axis\"\ndrivers = [\"rate_y\"]\nform = \"linear\"\n\
                parameters = [{ name = \"slope\", value = 0.01, unit = \"1\" }]\n";
    fs::write(hil.path("devices/gyro.model.toml"), format!("{MODEL}{leak}")).unwrap();
    let ran = hil.run(&["run", "./turns.toml"]).exits(2);
    assert!(ran.err.contains("term `leak` cannot be carried"), "{}", ran.err);
    fs::write(hil.path("devices/gyro.model.toml"), MODEL.replace("schema = 1", "schema = 9"))
        .unwrap();
    let ran = hil.run(&["run", "./turns.toml"]).exits(2);
    assert!(ran.err.contains("schema 9, expected 1"), "{}", ran.err);
}
