//! A log of a serial line that several devices share, and a log that has no place for it.

use super::hil::Hil;
use std::fs;

const RIG: &str = "title = \"Two sensors\"\n\
    [[line]]\nname = \"rs485\"\nserial = {}\n\
    [[line]]\nname = \"can0\"\ncan = { bit_rate = 125_000 }\n\
    [[node]]\nname = \"a\"\nat = \"rs485\"\nemulate = \"a\"\n\
    [[node]]\nname = \"b\"\nat = \"rs485\"\nemulate = \"b\"\n\
    [[node]]\nname = \"master\"\nat = \"rs485\"\ntester = true\n\
    [[node]]\nname = \"lamp\"\nat = \"can0\"\nemulate = \"lamp\"\n";

/// Its answer is that of any other sensor but for the value.
fn sensor(name: &str, value: u8) -> String {
    let upper = name.to_uppercase();
    format!(
        "name = \"{name}\"\ntitle = \"A sensor\"\n[serial]\nbaud = 9600\n[signal.Value{upper}]\nexpression = \"{value}\"\n\
         [[message]]\nname = \"Ask{upper}\"\nsent_by = \"host\"\ntext = \"{upper}?\\n\"\n\
         [[message]]\nname = \"Is{upper}\"\nsent_by = \"device\"\nanswers = \"Ask{upper}\"\ndelay_s = 0.01\n\
         text = \"V={{Value{upper}:.1}}\\n\"\nfields = [{{ name = \"Value{upper}\", unit = \"bar\" }}]\n"
    )
}

const LAMP: &str = "name = \"lamp\"\ntitle = \"A lamp\"\n[signal.On]\nexpression = \"1\"\n\
    [[message]]\nname = \"Lit\"\ncan_id = 0x100\nsent_by = \"device\"\nperiod_s = 0.1\nfields = [{ name = \"On\", type = \"u8\" }]\n";

/// Asks both in turn, while `a` is gone for a time.
const PLAN: &str = r#"
name = "polls"
title = "Polls two sensors"
rig = "two"
steps = [ { repeat = { times = 10, steps = [
    { send = { message = "AskA", every_s = 0 } }, { wait = { duration_s = 0.1 } },
    { send = { message = "AskB", every_s = 0 } }, { wait = { duration_s = 0.1 } } ] } } ]
[[fault]]
target = "a"
what = { disconnect = { for_s = 1.1 } }
when = { at_s = 0.5 }
[[property]]
name = "a answers"
always = "sent(master.AskA) -> within 150 ms: sent(a.IsA)"
[[property]]
name = "the lamp is lit"
always = "lamp.On == 1"
[[measurement]]
name = "value_of_a"
doc = "1 bar"
quantity = "a.ValueA"
unit = "bar"
check = { all_within = [0.9, 1.1] }
[[measurement]]
name = "clean"
doc = "Nothing else on the line"
quantity = "unexpected.rs485"
unit = "1"
check = { all_within = [0, 0] }
"#;

fn ran() -> Hil {
    let hil = Hil::new();
    for folder in ["rigs", "devices"] {
        fs::create_dir(hil.path(folder)).unwrap();
    }
    for (file, text) in [
        ("rigs/two.toml", RIG),
        ("devices/a.toml", &sensor("a", 1)),
        ("devices/b.toml", &sensor("b", 2)),
        ("devices/lamp.toml", LAMP),
        ("polls.toml", PLAN),
    ] {
        fs::write(hil.path(file), text).unwrap();
    }
    hil.run(&["run", "./polls.toml", "--record", "full", "--out", "run"]).exits(1);
    hil
}

/// The verdicts on the properties and measurements of a run.
fn verdicts(hil: &Hil, run: &str) -> Vec<String> {
    let text = fs::read(hil.path(run).join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let all = |key: &str| summary[key].as_array().unwrap().clone();
    let measurements = all("measurements").into_iter().map(|one| one["verdict"].clone());
    let properties = all("properties");
    let held = properties.into_iter().map(|one| one.get("held").cloned().unwrap_or_default());
    measurements.chain(held).map(|one| one.to_string()).collect()
}

/// Found by a user: each answer was given to each device, so that one that was silent answered with the bytes of another.
#[test]
fn each_answer_is_that_of_one_device() {
    let hil = ran();
    hil.run(&["export", "run", "--bus", "a.pcapng"]).exits(0);
    hil.run(&["import", "a.pcapng", "--plan", "./polls.toml", "--out", "import"]).exits(1);
    let expected = ["\"pass\"", "\"pass\"", "false", "true"];
    assert_eq!(verdicts(&hil, "run"), expected);
    assert_eq!(verdicts(&hil, "import"), expected);
    let bytes = |run: &str| {
        let shown = hil.run(&["show", run]).exits(0).out;
        let said = shown.lines().filter(|line| line.contains(" bytes "));
        said.map(|line| line.split_whitespace().skip(1).collect::<Vec<_>>().join(" ")).collect()
    };
    let (of_run, of_import): (Vec<String>, Vec<String>) = (bytes("run"), bytes("import"));
    assert_eq!(of_run, of_import);
}

/// Found by a user: what a log has no place for was silence. What must not be sent there held, and what must be sent broke.
#[test]
fn what_a_log_cannot_hold_is_not_judged() {
    let hil = ran();
    hil.run(&["export", "run", "--bus", "a.log"]).exits(0);
    let import = hil.run(&["import", "a.log", "--plan", "./polls.toml", "--out", "import"]);
    let told = import.exits(1).out;
    let why = "the log holds nothing of the serial line rs485";
    assert!(told.contains(&format!("a answers is not judged: {why}")), "{told}");
    assert!(told.contains(&format!("clean unset: {why}")), "{told}");
    let expected = ["\"unset\"", "\"unset\"", "null", "true"];
    assert_eq!(verdicts(&hil, "import"), expected);
    hil.run(&["check", "import"]).exits(1);
    assert_eq!(verdicts(&hil, "import"), expected, "judged again");
}
