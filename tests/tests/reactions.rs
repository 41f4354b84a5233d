//! The step `reaction`: it waits for a trigger and its response, and reports which of the two is missing.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::TrialRun;
use record::outcome::{Outcome, Verdict};
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

fn run(steps: &str, to: &str, least: u32) -> TrialRun {
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
observations_min = {least}
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
    let run = run(&steps, "scale.Alarm == 1", 3);
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
        let run = run(&steps, to, 3);
        assert_eq!(run.summary().outcome, Outcome::Timeout, "{run}");
        let said = run.summary().reason.as_deref().unwrap_or_default();
        assert!(said.contains("wait for the reaction warning"), "{said}");
        assert!(said.ends_with(expected), "{said}");
    }
}

/// Loads the scale before a wait of 0.12 s with the label, after which the run goes on for `more_s`.
fn waits(to: &str, more_s: f64) -> TrialRun {
    let wait = |duration_s: f64, label: &str| {
        format!("{{ wait = {{ duration_s = {duration_s} }}, label = \"{label}\" }}")
    };
    let steps =
        [wait(0.5, "before"), LOADED.to_owned(), wait(0.12, "overload"), wait(more_s, "after")];
    run(&steps.join(", "), to, 1)
}

#[test]
fn a_reaction_belongs_to_the_step_in_which_it_was_asked_for() {
    // The alarm is sent four times a second, the mass ten times: the answer comes after the labelled step.
    let ran = waits("scale.Alarm == 1", 1.0);
    let warns = ran.measurement("warns_in").unwrap();
    assert_eq!(warns.observations, 1, "{warns:?}");
}

#[test]
fn an_answer_that_never_came_is_no_reaction_time() {
    // The run ends before the limit of 0.25 s is over.
    let short = waits("scale.Alarm == 2", 0.05);
    let warns = short.measurement("warns_in").unwrap();
    assert_eq!(warns.value, None, "{warns:?}");
    assert!(warns.statistic.starts_with("no answer in the 0."), "{warns:?}");
    // And after it.
    let long = waits("scale.Alarm == 2", 1.0);
    let warns = long.measurement("warns_in").unwrap();
    assert!(warns.value.is_some_and(|waited| waited > 1.0), "{warns:?}");
    assert_eq!(warns.verdict, Verdict::Fail, "{warns:?}");
}
