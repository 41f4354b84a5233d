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

/// Found by a user: a wait for a signal of one node ended with the next frame of another, by a value from before the step: a
/// controller that hung passed.
#[test]
fn a_wait_ends_with_a_value_of_its_own_time() {
    let device = |name: &str, period: f64| {
        format!(
            "name = \"{name}\"\ntitle = \"\"\n[signal.P]\nexpression = \"1\"\n[[message]]\nname = \"M\"\nsent_by = \"device\"\n\
             can_id = {}\nperiod_s = {period}\nfields = [{{ name = \"P\", type = \"u8\" }}]\n",
            if name == "k" { 0x100 } else { 0x50 }
        )
    };
    let node =
        |name: &str| format!("[[node]]\nname = \"{name}\"\nat = \"can0\"\nemulate = \"{name}\"\n");
    let rig = format!("[[line]]\nname = \"can0\"\ncan = {{}}\n{}{}", node("k"), node("j"));
    for (condition, least_s) in [
        ("above = { quantity = \"k.P\", limit = 0.5 }", 0.09),
        ("steady = { quantity = \"k.P\", change_at_most = 0.1, over_s = 0.5 }", 0.09),
        ("above = { quantity = \"k.P\", limit = 0.5, for_s = 0.5 }", 0.09),
    ] {
        let plan = format!(
            "name = \"waits\"\ntitle = \"\"\nrig = \"two\"\nsteps = [{{ wait = {{ duration_s = 1 }} }}, \
             {{ power_cycle = {{ device = \"k\", off_s = 5 }} }}, \
             {{ wait_until = {{ {condition} }}, label = \"back\", time_limit_s = 3 }}]\n\
             [[measurement]]\nname = \"took\"\ndoc = \"\"\nquantity = \"step.duration\"\n\
             where = {{ \"during.back\" = 1 }}\nunit = \"s\"\ncheck = {{ all_within = [0, 3] }}\n"
        );
        let folder = project::of([
            ("devices/k.toml", device("k", 0.1)),
            ("devices/j.toml", device("j", 0.03)),
            ("rigs/two.toml", rig.clone()),
            ("plan.toml", plan),
        ]);
        let run = project::load(&folder, "plan.toml").unwrap().run().unwrap();
        let took = run.value("took").unwrap();
        assert!(took >= least_s && run.passed(), "{condition}: {took}");
    }
}
