//! Logs of rigs with several lines or nodes.

use super::hil::Hil;
use super::own_log::{figures, within};
use std::collections::BTreeSet;
use std::fs;

/// Found by a user: a frame at the instant at which a `wait` ends belonged to that step in the run, and to the next one in
/// the import of its log.
#[test]
fn a_frame_at_the_end_of_a_step_belongs_to_it() {
    let hil = Hil::new();
    hil.run(&["new", "oven"]).exits(0);
    let mut rig = "[[line]]\nname = \"can0\"\ncan = {}\n".to_owned();
    for (name, id, period_s) in [("k", 0x100, 0.1), ("j", 0x50, 0.03)] {
        let device = format!(
            "name = \"{name}\"\ntitle = \"\"\nsource = \"invented\"\n[parameter.p]\nvalue = 1\n\
             [signal.P]\nexpression = \"p\"\n[[message]]\nname = \"M\"\nsent_by = \"device\"\n\
             can_id = {id}\nperiod_s = {period_s}\nfields = [{{ name = \"P\", type = \"u8\" }}]\n"
        );
        fs::write(hil.path(format!("oven/devices/{name}.toml")), device).unwrap();
        rig += &format!("[[node]]\nname = \"{name}\"\nat = \"can0\"\nemulate = \"{name}\"\n");
    }
    fs::create_dir_all(hil.path("oven/rigs")).unwrap();
    fs::write(hil.path("oven/rigs/steps.toml"), rig).unwrap();
    let plan = r#"
name = "steps"
title = ""
rig = "steps"
steps = [
    { wait_until = { above = { quantity = "k.P", limit = 0.5 } }, time_limit_s = 1 },
    { wait = { duration_s = 1 }, label = "before" },
    { set_parameter = { parameter = "k.p", value = 3 } },
    { wait = { duration_s = 0.95 }, label = "after" },
]
[[measurement]]
name = "after"
doc = "The value once it is set"
quantity = "k.P"
unit = "1"
check = { never_outside = { band = [3, 3], during = "after" } }
"#;
    fs::write(hil.path("oven/steps.toml"), plan).unwrap();
    within(&hil, &["run", "steps.toml", "--out", "run", "--record", "full"]).exits(0);
    for log in ["steps.log", "steps.pcapng"] {
        within(&hil, &["export", "run", "--bus", log]).exits(0);
        within(&hil, &["import", log, "--plan", "steps.toml", "--out", "again"]).exits(0);
        assert_eq!(figures(&hil, "again"), figures(&hil, "run"), "{log}");
    }
}

/// Traffic that a fault makes is of its bus, and of no node: no message of theirs has its identifiers.
#[test]
fn traffic_that_a_fault_makes_is_of_its_bus() {
    let hil = two_buses();
    let fault = "[[fault]]\ntarget = \"vehicle\"\nwhat = { bus_load = { load_percent = 80 } }\n";
    let plan = fs::read_to_string(hil.path("oven/two.toml")).unwrap();
    let loaded = plan.replace("\"two\"\ntitle", "\"loaded\"\ntitle") + fault;
    fs::write(hil.path("oven/loaded.toml"), loaded).unwrap();
    within(&hil, &["run", "loaded.toml", "--out", "run", "--record", "full"]).exits(0);
    within(&hil, &["export", "run", "--bus", "loaded.log"]).exits(0);
    let log = fs::read_to_string(hil.path("oven/loaded.log")).unwrap();
    let dbc = fs::read_to_string(hil.path("oven/devices/oven.dbc")).unwrap();
    let messages: Vec<String> = dbc
        .lines()
        .filter_map(|line| line.strip_prefix("BO_ ")?.split(' ').next()?.parse::<u32>().ok())
        .map(|id| format!("{id:03X}"))
        .collect();
    let channels = |is_of_a_node: bool| -> BTreeSet<&str> {
        let of = |line: &str| messages.iter().any(|id| line.contains(&format!(" {id}#")));
        let lines = log.lines().filter(|line| of(line) == is_of_a_node);
        lines.filter_map(|line| line.split(' ').nth(1)).collect()
    };
    assert_eq!(Vec::from_iter(channels(true)), ["body", "vehicle"]);
    assert_eq!(Vec::from_iter(channels(false)), ["vehicle"]);
    let shown = within(&hil, &["show", "run", "--device", "stranger"]).exits(0);
    assert!(shown.out.lines().count() > 1_000, "{}", shown.out.lines().count());
    // The log of the run says the same as the run.
    within(&hil, &["import", "loaded.log", "--plan", "two.toml", "--out", "again"]).exits(0);
    assert_eq!(figures(&hil, "again"), figures(&hil, "run"));
}

/// A rig of two ovens on two buses, and its plan `two.toml`.
fn two_buses() -> Hil {
    let hil = Hil::new();
    hil.run(&["new", "oven"]).exits(0);
    let node = |name: &str, line: &str| {
        format!(
            "[[line]]\nname = \"{line}\"\ncan = {{}}\n\
             [[node]]\nname = \"{name}\"\nat = \"{line}\"\nemulate = \"oven\"\n"
        )
    };
    fs::create_dir_all(hil.path("oven/rigs")).unwrap();
    let rig = node("first", "body") + &node("second", "vehicle");
    fs::write(hil.path("oven/rigs/two.toml"), rig).unwrap();
    let measured = |name: &str| {
        format!(
            "[[measurement]]\nname = \"{name}\"\ndoc = \"Its temperature\"\nunit = \"degC\"\n\
             quantity = \"{name}.Temperature\"\ncheck = {{ all_within = [0, 100] }}\n"
        )
    };
    let plan =
        "name = \"two\"\ntitle = \"\"\nrig = \"two\"\nsteps = [{ wait = { duration_s = 3 } }]\n";
    let plan = format!("{plan}{}{}", measured("first"), measured("second"));
    fs::write(hil.path("oven/two.toml"), plan).unwrap();
    hil
}

/// Formats that number their channels lose the names of the lines.
#[test]
fn each_line_of_a_rig_has_its_channel_of_a_log() {
    let hil = two_buses();
    within(&hil, &["run", "two.toml", "--out", "run", "--record", "full"]).exits(0);
    for log in ["two.log", "two.asc"] {
        within(&hil, &["export", "run", "--bus", log]).exits(0);
    }
    let import = |arguments: &[&str]| {
        within(&hil, &[&["import", "--plan", "two.toml", "--out", "again"], arguments].concat())
    };
    import(&["two.log"]).exits(0);
    let by_name = figures(&hil, "again");
    let asked = import(&["two.asc"]).exits(2).err;
    assert!(asked.contains("which channel of the log is the line `body`?"), "{asked}");
    assert!(asked.contains("--channel body=CHANNEL"), "{asked}");
    let away = import(&["two.asc", "--channel", "body=vcan8"]).exits(2).err;
    assert!(
        away.contains("the log has no channel `vcan8`") && away.contains("can0, can1"),
        "{away}"
    );
    // The only bus of a log may be that of another line.
    let log = fs::read_to_string(hil.path("oven/two.log")).unwrap();
    let body: Vec<&str> = log.lines().filter(|line| line.contains(" body ")).collect();
    fs::write(hil.path("oven/body.log"), body.join("\n")).unwrap();
    for stated in [&["body.log"][..], &["body.log", "--channel", "body=body"]] {
        let asked = import(stated).exits(2).err;
        assert!(asked.contains("which channel of the log is the line `vehicle`?"), "{asked}");
    }
    import(&["two.asc", "--channel", "body=can0", "--channel", "vehicle=can1"]).exits(0);
    let counts = |figures: &[(String, Option<f64>, u64)]| -> Vec<u64> {
        figures.iter().map(|(.., observations)| *observations).collect()
    };
    assert_eq!(counts(&figures(&hil, "again")), counts(&by_name));
    let wrong = import(&["two.asc", "--channel", "bdy=can0"]).exits(2).err;
    assert!(wrong.contains("no line `bdy`") && wrong.contains("did you mean `body`?"), "{wrong}");
}
