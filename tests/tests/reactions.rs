//! The step `reaction`: it waits for a trigger and its response, and reports which of the two is missing.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::TrialRun;
use record::outcome::Outcome;
use tests::project;

/// Sends its mass ten times a second, and its alarm four times.
const SCALE: &str = r#"
name = "scale"
title = "A scale"
[serial]
baud = 9600
[parameter.load]
value = 5.0
unit = "kg"
[[message]]
name = "Reading"
sent_by = "device"
text = "M{Mass:.2}\r\n"
period_s = 0.1
[[message]]
name = "Warning"
sent_by = "device"
text = "W{Alarm:.0}\r\n"
period_s = 0.25
[signal.Mass]
expression = "load"
[signal.Alarm]
expression = "load > 6"
"#;

const RIG: &str = r#"
title = "A scale alone"
[[line]]
name = "uart"
serial = {}
[[node]]
name = "scale"
at = "uart"
emulate = "scale"
"#;

fn run(steps: &str, to: &str) -> TrialRun {
    let plan = format!(
        r#"
name = "plan"
title = "It warns"
rig = "weighing"
# Before the first reading nothing can become true.
steps = [{{ wait = {{ duration_s = 0.15 }} }}, {steps}]
[[reaction]]
name = "warning"
from = "scale.Mass > 6"
to = "{to}"
[[measurement]]
name = "warns_in"
doc = "From the reading to the warning"
quantity = "reaction.warning"
where = {{ "during.overload" = 1 }}
unit = "s"
check = {{ all_within = [0, 0.25] }}
observations_min = 3
"#
    );
    let folder = project::of([
        ("rigs/weighing.toml", RIG),
        ("devices/scale.toml", SCALE),
        ("plan.toml", &plan),
    ]);
    project::load(&folder, "plan.toml").unwrap().run().unwrap()
}

const LOADED: &str = "{ set_parameter = { parameter = \"scale.load\", value = 9 } }";
const AWAITED: &str = "{ reaction = \"warning\", label = \"overload\", time_limit_s = 2 }";

#[test]
fn it_waits_for_one_that_began_in_it_and_what_it_took_has_its_label() {
    let steps = format!(
        "{{ repeat = {{ times = 3, steps = [{LOADED}, {AWAITED}, \
         {{ set_parameter = {{ parameter = \"scale.load\", value = 5 }} }}, {{ wait = {{ duration_s = 0.33 }} }}] }} }}, \
         {LOADED}, {{ wait = {{ duration_s = 1 }} }}"
    );
    let run = run(&steps, "scale.Alarm == 1");
    assert!(run.passed(), "{run}");
    let judged = run.measurement("warns_in").unwrap();
    // The fourth does not belong to a `reaction` step.
    assert_eq!(judged.observations, 3, "{run}");
}

#[test]
fn what_did_not_come_is_said() {
    for (steps, to, expected) in [
        (format!("{LOADED}, {AWAITED}"), "scale.Alarm > 2", ": what it waits for did not come"),
        (AWAITED.to_owned(), "scale.Alarm == 1", ": nothing asked for it"),
        // Triggered before the step began, and answered within it.
        (
            format!("{LOADED}, {{ wait = {{ duration_s = 0.12 }} }}, {AWAITED}"),
            "scale.Alarm == 1",
            ": nothing asked for it",
        ),
    ] {
        let run = run(&steps, to);
        assert_eq!(run.summary().outcome, Outcome::Timeout, "{run}");
        let said = run.summary().reason.as_deref().unwrap_or_default();
        assert!(said.contains("wait for the reaction warning"), "{said}");
        assert!(said.ends_with(expected), "{said}");
    }
}
