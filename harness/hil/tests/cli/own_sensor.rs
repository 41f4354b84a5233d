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
    assert!(ran.err.contains("no variable `rate_y`"), "another axis is one: {}", ran.err);
    let turn = leak.replace("axis", "turn").replace("rate_y", "case");
    fs::write(hil.path("devices/gyro.model.toml"), format!("{MODEL}{turn}")).unwrap();
    let ran = hil.run(&["run", "./turns.toml"]).exits(2);
    assert!(ran.err.contains("term `leak` cannot be carried"), "{}", ran.err);
    fs::write(hil.path("devices/gyro.model.toml"), MODEL.replace("schema = 1", "schema = 9"))
        .unwrap();
    let ran = hil.run(&["run", "./turns.toml"]).exits(2);
    assert!(ran.err.contains("schema 9, expected 1"), "{}", ran.err);
}

/// A level, and a device that reads it with a bend.
fn level(name: &str, id: u16, expression: &str) -> String {
    format!(
        "name = \"{name}\"\ntitle = \"\"\nstep_s = 0.05\n[[message]]\nname = \"Reading\"\n\
         sent_by = \"device\"\ncan_id = {id}\nperiod_s = 0.05\n\
         fields = [{{ name = \"Level\", type = \"f32\", unit = \"m\" }}]\n\
         [state.true]\nvalue = \"1 + sin(0.7 * t) + 0.5 * sin(0.31 * t)\"\n\
         [signal.Level]\nexpression = \"{expression}\"\nnoise = 0.001\n"
    )
}

#[test]
fn a_run_of_a_sensor_and_its_reference_is_a_data_package() {
    let hil = Hil::new();
    let node =
        |name: &str| format!("[[node]]\nname = \"{name}\"\nat = \"can0\"\nemulate = \"{name}\"\n");
    let rig = format!("[[line]]\nname = \"can0\"\ncan = {{}}\n{}{}", node("probe"), node("gauge"));
    let plan = "name = \"levels\"\ntitle = \"\"\nrig = \"tank\"\nsteps = [{ repeat = { times = 3, \
        steps = [{ wait = { duration_s = 20 } }] } }]\n[[measurement]]\nname = \"level\"\ndoc = \"\"\n\
        quantity = \"probe.Level\"\nunit = \"m\"\ncheck = { all_within = [-2, 4] }\n";
    for (name, text) in [
        ("devices/probe.toml", &*level("probe", 256, "true + 0.05 * true * true")),
        ("devices/gauge.toml", &*level("gauge", 257, "true")),
        ("rigs/tank.toml", &*rig),
        ("levels.toml", plan),
    ] {
        let path = hil.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    hil.run(&["run", "levels.toml", "--out", "short"]).exits(0);
    hil.run(&["run", "levels.toml", "--out", "full", "--record", "full"]).exits(0);
    let export = |run: &str, measured: &str| {
        let signals = ["--measured", measured, "--reference", "gauge.Level", "--out", "levels"];
        hil.run(&[&["export", run, "--kind", "sensor"][..], &signals].concat())
    };
    let told = export("short", "probe.Level").exits(2).err;
    assert!(
        told.contains("no `probe.Level` was heard") && told.contains("--record full"),
        "{told}"
    );
    let told = export("full", "probe.Levle").exits(2).err;
    assert!(told.contains("no signal `Levle`") && told.contains("Level"), "{told}");
    let told = export("full", "gauge.Reading.Level").exits(2).err;
    assert!(told.contains("`gauge.Level` is what is measured itself"), "{told}");
    let told = export("full", "probe.Level").exits(0).out;
    assert!(told.ends_with(" rows, 3 runs\n"), "{told}");
    hil.run(&["identify", "levels", "--out", "found"]).exits(0);
    let found = fs::read_to_string(hil.path("found/finding.json")).unwrap();
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    assert_eq!(found["verdict"], "explained", "{found}");
    let bend = &found["effects"][0];
    assert_eq!(
        (&bend["name"], &bend["drivers"][0]),
        (&"nonlinearity".into(), &"gauge.Level".into())
    );
    let coefficient = bend["parameters"][0]["value"].as_f64().unwrap();
    assert!((coefficient - 0.05).abs() < 0.001, "{bend}");
}

/// Answers that look the same are told apart in an export as in the run.
#[test]
fn a_run_of_an_instrument_that_only_answers_is_a_data_package() {
    let hil = Hil::new();
    let page = include_str!("../../../../docs/request-and-answer.md");
    let block = |begins: &str| {
        let mut blocks = page.split("```toml\n").filter_map(|rest| rest.split_once("```"));
        blocks.find_map(|(block, _)| block.starts_with(begins).then_some(block)).unwrap()
    };
    let rig = "[[line]]\nname = \"uart\"\nserial = {}\n\
        [[node]]\nname = \"supply\"\nat = \"uart\"\nemulate = \"supply\"\n\
        [[node]]\nname = \"asker\"\nat = \"uart\"\ntester = true\n";
    // All in one round, which is one run of the data set.
    let (asked, judged) = block("name = \"readings\"").split_once("  { repeat").unwrap();
    let judged = judged.split_once("\n]\n").unwrap().1;
    let steps = ["AskVoltage", "AskCurrent"].map(|ask| {
        format!("{{ send = {{ message = \"{ask}\", every_s = 0.2 }} }}, {{ wait = {{ duration_s = 4.1 }} }},\n")
    });
    let plan = format!("{asked}{}]\n{judged}", steps.concat());
    let plan = plan.replace("device = \"supply\"", "rig = \"bench\"");
    for (name, text) in [
        ("devices/supply.toml", block("name = \"supply\"")),
        ("rigs/bench.toml", rig),
        ("readings.toml", &*plan.replace("signal.", "supply.")),
    ] {
        let path = hil.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    hil.run(&["run", "readings.toml", "--out", "run", "--record", "full"]).exits(0);
    let signals = ["--measured", "supply.Voltage", "--reference", "supply.Current"];
    let out = ["--out", "volts"];
    let told = hil.run(&[&["export", "run", "--kind", "sensor"][..], &signals, &out].concat());
    assert!(told.exits(0).out.ends_with(" rows, 1 run\n"));
    hil.run(&["export", "run", "--tables", "tables", "--format", "csv"]).exits(0);
    let signals = fs::read_to_string(hil.path("tables/signals.csv")).unwrap();
    let told = |line: &str| signals.matches(line).count();
    assert!(told(",supply,VoltageIs,Voltage,12.0") >= 40, "{signals}");
    assert!(told(",supply,CurrentIs,Current,1.2") >= 20, "{signals}");
    // Nothing else was heard of it.
    let right = told("VoltageIs,Voltage,12.0,") + told("CurrentIs,Current,1.2,");
    assert_eq!(told(",supply,"), right, "{signals}");
}
