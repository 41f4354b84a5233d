//! `hil check` gives no verdict that the record does not bear out.

use crate::hil::{Hil, Ran};
use std::fs;

/// A project, with `property.toml`: its plan, and a property.
fn with_property(always: &str) -> Hil {
    let hil = Hil::new();
    hil.run(&["new", "oven"]).exits(0);
    with_plan(&hil, "property.toml", always);
    hil
}

fn with_plan(hil: &Hil, name: &str, always: &str) {
    let plan = fs::read_to_string(hil.path("oven/settles.toml")).unwrap();
    let property = format!("\n[[property]]\nname = \"cool\"\nalways = '{always}'\n");
    fs::write(hil.path("oven").join(name), plan + &property).unwrap();
}

fn within(hil: &Hil, arguments: &[&str]) -> Ran {
    Ran::of(hil.command(arguments).current_dir(hil.path("oven")).output().unwrap())
}

/// Found by a user: the property was broken in the run, and its verdict gone after another plan had judged the record.
#[test]
fn a_property_of_which_there_is_no_verdict_does_not_hold() {
    let hil = with_property("device.Temperature < 60 degC");
    within(&hil, &["run", "property.toml", "--out", "run"]).exits(1);
    let check = |arguments: &[&str]| within(&hil, &[&["check", "run"], arguments].concat());
    let kept = check(&[]).exits(1);
    assert!(kept.err.contains("cool keeps the verdict of the run"), "{}", kept.err);
    for _ in 0..2 {
        check(&["--plan", "settles.toml"]).exits(0);
        for _ in 0..2 {
            let gone = check(&[]).exits(1);
            assert_eq!(gone.out.matches("cool is not judged").count(), 1, "{}", gone.out);
        }
    }
}

#[test]
fn a_plan_that_does_not_fit_judges_nothing() {
    let hil = with_property("device.Temperature < 100 degC");
    within(&hil, &["run", "property.toml", "--out", "run", "--record", "full"]).exits(0);
    let was = fs::read(hil.path("oven/run/summary.json")).unwrap();
    for always in [
        "device.Temperature < ",
        "device.Tempratur < 100 degC",
        "device.Temperature < 100 A",
        "device.Temperature",
    ] {
        with_plan(&hil, "bad.toml", always);
        let ran = within(&hil, &["run", "bad.toml"]).exits(2);
        let checked = within(&hil, &["check", "run", "--plan", "bad.toml"]).exits(2);
        assert_eq!(checked.err, ran.err);
    }
    let plan = fs::read_to_string(hil.path("oven/settles.toml")).unwrap();
    fs::write(hil.path("oven/bad.toml"), plan.replace("\"degC\"", "\"kV\"")).unwrap();
    let checked = within(&hil, &["check", "run", "--plan", "bad.toml"]).exits(2);
    assert!(checked.err.contains("kV"), "{}", checked.err);
    assert_eq!(fs::read(hil.path("oven/run/summary.json")).unwrap(), was);
}

/// Found by random faults: the record ends with the last message, and the property was not judged beyond it.
#[test]
fn a_device_that_falls_silent_is_judged_to_the_end_of_the_run() {
    let hil = Hil::new();
    hil.run(&["new", "oven", "--serial"]).exits(0);
    let always = "device.HeaterOn == 1 -> within 30 s: device.Temperature > 50 degC";
    with_plan(&hil, "property.toml", always);
    let plan = fs::read_to_string(hil.path("oven/property.toml")).unwrap();
    let silent = "\n[[fault]]\ntarget = \"device\"\ntoward = \"host\"\nwhat = { drop = { loss_percent = 100 } }\nwhen = { at_s = 1 }\n";
    fs::write(hil.path("oven/property.toml"), plan + silent).unwrap();
    let broke = "broke cool at 0.1";
    let run = within(&hil, &["run", "property.toml", "--out", "run", "--record", "full"]);
    assert!(run.out.contains(broke), "{}", run.out);
    let again = within(&hil, &["check", "run"]);
    assert!(again.out.contains(broke), "{}", again.out);
}

#[test]
fn a_run_that_was_killed_is_compared_once_it_is_judged() {
    let hil = with_property("device.Temperature < 100 degC");
    within(&hil, &["run", "property.toml", "--out", "run"]).exits(0);
    fs::create_dir(hil.path("oven/killed")).unwrap();
    fs::copy(hil.path("oven/run/record.hilrec"), hil.path("oven/killed/record.hilrec")).unwrap();
    let told = within(&hil, &["diff", "run", "killed"]).exits(2);
    assert!(
        told.err.contains("the run was killed") && told.err.contains("hil check RUN"),
        "{}",
        told.err
    );
}

/// Found by a user: it stood for a difference between the runs.
#[test]
fn a_controller_that_cannot_be_started_is_no_difference() {
    let hil = Hil::new();
    let run = ["run", "live-table-run", "--record", "full", "--out", "run", "--quiet"];
    hil.run(&run).exits(0);
    hil.run(&["rerun", "run", "--controller", "in-process"]).exits(0);
    let missing = hil.run(&["rerun", "run", "--controller", "nonexist {gyro}"]).exits(2);
    assert!(missing.err.contains("nonexist"), "{}", missing.err);
}

#[test]
fn an_option_of_another_export_is_not_ignored() {
    let hil = with_property("device.Temperature < 100 degC");
    within(&hil, &["run", "property.toml", "--out", "run"]).exits(0);
    let refused = within(&hil, &["export", "run", "--fmi", "2", "--mcap", "x.mcap"]).exits(2);
    assert!(refused.err.contains("--fmi"), "{}", refused.err);
    assert!(!hil.path("oven/x.mcap").exists());
}

/// The last moment and what is beyond it have a state, as in `hil show`.
#[test]
fn at_the_end_of_a_run_its_last_state_is_told() {
    let hil = with_property("device.Temperature < 100 degC");
    within(&hil, &["run", "property.toml", "--out", "run", "--record", "full"]).exits(0);
    let shown = within(&hil, &["show", "run", "--at", "1e9"]).exits(0);
    let told = within(&hil, &["debug", "run", "--at", "1e9"]).exits(0);
    let last = shown.out.lines().find(|line| line.contains("Temperature")).unwrap();
    assert!(told.out.contains(last), "{last}\n{}", told.out);
}

/// Found by a user: the DBC had been corrected, and one report held figures of both.
#[test]
fn messages_that_have_changed_since_the_run_are_told() {
    let hil = with_property("device.Temperature < 100 degC");
    within(&hil, &["run", "property.toml", "--out", "run", "--record", "full"]).exits(0);
    let unchanged = within(&hil, &["check", "run", "--plan", "settles.toml"]).exits(0);
    assert!(!unchanged.err.contains("have changed"), "{}", unchanged.err);
    let dbc = hil.path("oven/devices/oven.dbc");
    let was = fs::read_to_string(&dbc).unwrap();
    let is = was.replace("0|16@1- (0.01,0)", "0|16@1- (0.01,-10)");
    assert_ne!(was, is);
    fs::write(dbc, is).unwrap();
    let ran = within(&hil, &["check", "run", "--plan", "settles.toml"]);
    let note = "the messages of `device` have changed since the run";
    assert!(ran.err.contains(note), "{}", ran.err);
}

/// Found by a user: the verdict of a lenient plan stood in the files of a failed run as that of its own.
#[test]
fn a_verdict_of_another_plan_says_whose_it_is() {
    let hil = with_property("device.Temperature < 100 degC");
    within(&hil, &["run", "settles.toml", "--out", "run"]).exits(0);
    let settles = fs::read_to_string(hil.path("oven/settles.toml")).unwrap();
    let changed = settles.replace("[58, 61]", "[50, 70]");
    assert_ne!(settles, changed);
    let said = |plan: &str, name: &str| {
        fs::write(hil.path("oven/other.toml"), plan.replace("\"settles\"", name)).unwrap();
        within(&hil, &["check", "run", "--plan", "other.toml"]).exits(0);
        fs::read_to_string(hil.path("oven/run/junit.xml")).unwrap()
    };
    let same = said(&settles, "\"settles\"");
    assert!(!same.contains("judged again"), "{same}");
    let lenient = said(&changed, "\"settles\"");
    assert!(lenient.contains("judged again by settles as it is now"), "{lenient}");
    let another = said(&changed, "\"easy\"");
    let told = "judged again by easy, and not by settles, the plan of the run";
    assert!(another.contains(told) && !another.contains("as it is now"), "{another}");
    within(&hil, &["check", "run"]).exits(0);
    let own = fs::read_to_string(hil.path("oven/run/summary.json")).unwrap();
    assert!(!own.contains("judged again"), "{own}");
}

/// Found by a user: what the run did not measure had no observation, and no reason.
#[test]
fn what_another_plan_judges_and_the_run_did_not_measure_has_its_reason() {
    let hil = with_property("device.Temperature < 100 degC");
    let settles = fs::read_to_string(hil.path("oven/settles.toml")).unwrap();
    let reaction = |from: &str| {
        format!(
            "{settles}\n[[reaction]]\nname = \"warm\"\nfrom = \"device.Temperature > {from} degC\"\n\
             to = \"device.Temperature > 50 degC\"\n[[measurement]]\nname = \"warms\"\ndoc = \"\"\n\
             quantity = \"reaction.warm\"\nunit = \"s\"\ncheck = {{ all_within = {{ at_most = 300 }} }}\n"
        )
    };
    fs::write(hil.path("oven/run.toml"), reaction("40")).unwrap();
    within(&hil, &["run", "run.toml", "--out", "run"]).exits(0);
    let since = |plan: String| {
        plan.replacen("\"period.Status\"", "\"period.Status\"\nsince = \"start\"", 1)
    };
    for (plan, status, why) in [
        (reaction("40"), 0, "passed"),
        (reaction("30"), 1, "warms unset: the run measured another reaction warm"),
        (
            since(reaction("40")),
            1,
            "unset: the run did not measure how long period.Status took to begin since start",
        ),
        (
            reaction("40").replace("\"holding\"", "\"hot\""),
            1,
            "unset: the plan of the run had no step or label hot",
        ),
        (
            reaction("40")
                + "[[measurement]]\nname = \"strange\"\ndoc = \"\"\nquantity = \"unexpected.device\"\n\
                unit = \"1\"\ncheck = { all_within = { at_most = 0 } }\n",
            1,
            "strange unset: the record has no unexpected.device: the plan of the run did not measure it",
        ),
    ] {
        fs::write(hil.path("oven/other.toml"), plan).unwrap();
        let ran = within(&hil, &["check", "run", "--plan", "other.toml"]).exits(status);
        let told = ran.out.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(told.contains(why), "{why}: {}", ran.out);
    }
}
