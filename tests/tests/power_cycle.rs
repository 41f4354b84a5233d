//! A device that is switched off and on again in virtual time: the step ends when it is on, and the plan goes on from
//! there, whether or not anything is sent.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::TrialRun;
use tests::project;

/// Sends nothing by itself.
const QUIET: &str = r#"
name = "quiet"
title = "It only answers"
[parameter.level]
value = 1
[[message]]
name = "Ask"
sent_by = "host"
can_id = 0x10
[[message]]
name = "Answer"
sent_by = "device"
can_id = 0x11
answers = "Ask"
fields = [{ name = "Level", type = "u8" }]
[signal.Level]
expression = "level"
"#;

/// The same, and twenty frames a second.
fn busy() -> String {
    let beat = "[[message]]\nname = \"Beat\"\nsent_by = \"device\"\ncan_id = 0x12\nperiod_s = 0.05\nfields = []\n";
    format!("{}{beat}", QUIET.replace("quiet", "busy"))
}

/// Runs these steps after a second without power.
fn run(device: &str, steps: &str) -> TrialRun {
    let plan = format!(
        r#"
name = "cycle"
title = "Off and on"
device = "{device}"
steps = [{{ power_cycle = {{ device = "device", off_s = 1 }}, label = "off" }}, {steps}]
[[measurement]]
name = "off"
doc = "Time without power"
quantity = "step.duration"
unit = "s"
where = {{ "during.off" = 1 }}
check = {{ all_within = [1, 1] }}
[[measurement]]
name = "rest"
doc = "Time of the steps after it"
quantity = "step.duration"
unit = "s"
where = {{ "during.rest" = 1 }}
check = {{ all_within = [0, 5] }}
"#
    );
    let folder = project::of([
        ("devices/quiet.toml", QUIET.to_owned()),
        ("devices/busy.toml", busy()),
        ("plan.toml", plan),
    ]);
    project::load(&folder, "plan.toml").unwrap().run().unwrap()
}

#[test]
fn the_plan_goes_on_when_the_device_is_on_again() {
    let wait = "{ wait = { duration_s = 5 }, label = \"rest\" }";
    let set = "{ set_parameter = { parameter = \"device.level\", value = 2 }, label = \"rest\" }";
    for device in ["quiet", "busy"] {
        for (steps, end_s) in [(wait, 6.0), (set, 1.0)] {
            let run = run(device, steps);
            assert!(run.passed(), "{device} {steps}: {run}");
            let lasted_s = run.summary().simulated_s;
            assert!((lasted_s - end_s).abs() < 1.1, "{device} {steps}: {lasted_s} s");
        }
    }
}
