//! The times of a log: where the plan begins in it, and what is unknown behind its end.

use super::hil::{Hil, Ran};
use std::fs;

const DEVICE: &str = r#"name = "dev"
title = "A device with a level"
[parameter.level]
value = 0
unit = "1"
minimum = 0
maximum = 100
[signal.Level]
expression = "level"
[[message]]
name = "Status"
sent_by = "device"
can_id = 0x100
period_s = 0.1
fields = [{ name = "Level", type = "u16", scale = 0.1, unit = "1" }]
"#;

fn in_project(hil: &Hil, arguments: &[&str]) -> Ran {
    Ran::of(hil.command(arguments).current_dir(hil.path("project")).output().unwrap())
}

fn project() -> Hil {
    let hil = Hil::new();
    fs::create_dir_all(hil.path("project/devices")).unwrap();
    fs::write(hil.path("project/devices/dev.toml"), DEVICE).unwrap();
    hil
}

fn plan(hil: &Hil, name: &str, rest: &str) {
    let plan = format!("name = \"{name}\"\ntitle = \"\"\ndevice = \"dev\"\n{rest}");
    fs::write(hil.path("project").join(format!("{name}.toml")), plan).unwrap();
}

/// Found by a user: every step was earlier by the silence before the first frame, 0.1 s, so that the level of the step before
/// counted, or that of the step itself did not.
#[test]
fn an_exported_log_keeps_its_zero() {
    let hil = project();
    for (wait_s, status) in [(1.0, 1), (1.05, 0)] {
        plan(
            &hil,
            "levels",
            &format!(
                "steps = [{{ wait = {{ duration_s = {wait_s} }} }},\n\
                 {{ set_parameter = {{ parameter = \"device.level\", value = 0.7 }} }},\n\
                 {{ wait = {{ duration_s = 1 }}, label = \"a\" }}]\n\
                 [[measurement]]\nname = \"a\"\ndoc = \"\"\nquantity = \"signal.Level\"\nunit = \"1\"\n\
                 check = {{ never_outside = {{ band = [0.7, 0.7], during = \"a\" }} }}\n\
                 [[measurement]]\nname = \"period\"\ndoc = \"\"\nquantity = \"period.Status\"\nunit = \"s\"\n\
                 check = {{ all_within = [0.1, 0.1] }}\n"
            ),
        );
        in_project(&hil, &["run", "levels.toml", "--record", "full", "--out", "r"]).exits(status);
        for log in ["b.pcapng", "b.log", "b.asc", "b.blf", "b.trc", "b.mf4"] {
            in_project(&hil, &["export", "r", "--bus", log]).exits(0);
            let ran = in_project(&hil, &["import", log, "--plan", "levels.toml", "--out", "i"]);
            let level = |text: &str| {
                let line = text.lines().find(|line| line.contains(" a ")).map(str::to_owned);
                line.unwrap_or_else(|| panic!("{log}: {text}"))
            };
            assert!(
                level(&ran.out).ends_with(["pass", "fail"][status as usize]),
                "{log}: {}",
                ran.out
            );
            // Of these only pcapng has all the digits of the times.
            if log == "b.pcapng" {
                ran.exits(status);
            }
            for file in ["i", "b.log", "b.asc", "b.blf", "b.trc", "b.mf4", "b.pcapng"] {
                let file = hil.path("project").join(file);
                _ = fs::remove_dir_all(&file).or_else(|_| fs::remove_file(&file));
            }
        }
        fs::remove_dir_all(hil.path("project/r")).unwrap();
    }
}

/// A log that was cut says nothing of what followed: it was taken for silence.
#[test]
fn what_follows_the_end_of_a_log_is_unknown() {
    let hil = project();
    plan(
        &hil,
        "tail",
        "steps = [{ wait = { duration_s = 3 } }]\n\
         [[reaction]]\nname = \"r\"\nfrom = \"device.Level > 5\"\nto = \"device.Level > 9\"\n\
         [[measurement]]\nname = \"reacts\"\ndoc = \"\"\nquantity = \"reaction.r\"\nunit = \"s\"\n\
         check = { all_within = { at_most = 0.5 } }\n\
         [[property]]\nname = \"sleeps\"\nsometimes = \"for 300 ms: not sent(device.Status)\"\n\
         [[property]]\nname = \"talks\"\nalways = \"sent(device.Status) -> eventually [1 ms, 150 ms]: sent(device.Status)\"\n\
         [[property]]\nname = \"silence\"\nalways = \"not (for 300 ms: not sent(device.Status))\"\n",
    );
    let log = |silent_s: f64| -> String {
        let at = |i: u32| 0.1 * f64::from(i) + if i > 12 { silent_s } else { 0.0 };
        // From 6 on it is asked, 0.2 s before the end, for 10.
        let level = |i: u32| if i > 23 { "3C00" } else { "0000" };
        (0..26).map(|i| format!("({:.6}) can0 100#{}\n", at(i), level(i))).collect()
    };
    let judged = |silent_s: f64| {
        fs::write(hil.path("project/t.log"), log(silent_s)).unwrap();
        let import = ["import", "t.log", "--plan", "tail.toml", "--out", "i"];
        let imported = in_project(&hil, &import).exits(1).out;
        let summary = || -> serde_json::Value {
            let text = fs::read(hil.path("project/i/summary.json")).unwrap();
            serde_json::from_slice(&text).unwrap()
        };
        let held = |summary: &serde_json::Value| {
            let all = summary["properties"].as_array().unwrap();
            all.iter().map(|one| one["held"].as_bool()).collect::<Vec<_>>()
        };
        let was = summary();
        in_project(&hil, &["check", "i"]).exits(1);
        assert_eq!(held(&was), held(&summary()), "the import and its check");
        fs::remove_dir_all(hil.path("project/i")).unwrap();
        let waited = was["measurements"][0]["value"].as_f64();
        assert!(waited.is_none_or(|s| s < 0.2), "{waited:?}: {imported}");
        held(&was)
    };
    assert_eq!(judged(0.0), [Some(false), Some(true), Some(true)]);
    assert_eq!(judged(0.35), [Some(true), Some(false), Some(false)]);
}
