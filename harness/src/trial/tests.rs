use super::{Trial, TrialError};
use crate::faults::{Fault, FaultKind, Target};
use crate::plan::{Always, Plan, Property};
use crate::record::sink::Level;
use controller::config::Config;
use controller::mission::{Mission, Report};
use controller::{Controller, Input, Output, Port};
use rig::hosted::HostedController;
use std::panic::{AssertUnwindSafe, catch_unwind};
use wire::time::Timestamp;

/// The paper's line of a metre and a half, which ends within 2 mm.
const LINE: &str = r#"
name = "line"
title = "One straight line"
devices = "paper"
steps = [
    { bias_test = { duration_s = 5 } },
    { straight = { distance_m = 1, speed_m_per_s = 0.2 } },
]

[[measurement]]
name = "stop_error"
doc = "Travelled minus commanded"
quantity = "straight.stop_error"
unit = "m"
check = { all_within = [-0.002, 0.002] }
"#;

fn line() -> Trial {
    Trial::parse("plans/line.toml", LINE).unwrap()
}

#[test]
fn what_a_run_measured_can_be_asked_and_a_folder_goes_with_it() {
    let run = line().run().unwrap();
    assert!(run.passed(), "{run}");
    assert!(run.value("stop_error").is_some_and(|error_m| error_m.abs() < 0.002));
    assert!(run.value("stopping_error").is_none());
    let folder = run.folder().to_owned();
    assert!(folder.join("report.html").is_file());
    drop(run);
    assert!(!folder.exists());
}

#[test]
fn what_failed_is_printed_and_its_folder_stays() {
    let narrow = LINE.replace("[-0.002, 0.002]", "[0.1, 0.2]");
    let run = Trial::parse("plans/line.toml", &narrow).unwrap().run().unwrap();
    assert!(!run.passed());
    let printed = run.to_string();
    let folder = run.folder().to_owned();
    drop(run);
    assert!(folder.join("summary.json").is_file());
    std::fs::remove_dir_all(&folder).unwrap();
    let printed = printed.replace(folder.to_str().unwrap(), "FOLDER");
    insta::with_settings!({ filters => [(r"in [0-9.]+ m?s;", "in WALL;")] }, {
        insta::assert_snapshot!(printed);
    });
}

#[test]
fn a_mistake_prints_with_its_place() {
    let error = Trial::parse("plans/line.toml", &LINE.replace("bias_test", "bias_tset"));
    insta::assert_snapshot!(format!("{:?}", error.unwrap_err()));
}

#[test]
fn a_plan_can_be_changed_in_code() {
    let mut plan = Plan::parse("line.toml", LINE).unwrap();
    plan.measurements.clear();
    let error = Trial::of(plan.clone()).unwrap_err().to_string();
    assert!(error.contains("judges nothing"), "{error}");

    let plan = Plan::parse("line.toml", LINE).unwrap();
    let drop_outs = Fault::new(Target::Gyro, FaultKind::typical("drop").unwrap());
    let finite = Property::Always(Always::FiniteOutputs {});
    let run = Trial::of(plan).unwrap().with_faults([drop_outs]).with_properties([finite]).run();
    let run = run.unwrap();
    assert_eq!(run.summary().faults.len(), 1, "{run}");
    assert!(run.property("finite_outputs").is_some(), "{run}");
}

#[test]
fn what_is_added_must_fit_the_bench() {
    let of_device = Fault::new(Target::Table, FaultKind::typical("drop").unwrap());
    let error = line().with_faults([of_device]).run().unwrap_err();
    assert!(matches!(error, TrialError::Prepare(_)), "{error:?}");
}

/// Our controller, but it panics on a lost sample.
#[derive(Debug)]
struct Fragile(Controller);

impl HostedController for Fragile {
    fn receive(&mut self, now: Timestamp, port: Port, input: Input<'_>) {
        self.0.receive(now, port, input);
    }

    fn command(&mut self, now: Timestamp, mission: Mission) {
        self.0.command(now, mission);
    }

    fn wake(&mut self, now: Timestamp) {
        self.0.wake(now);
    }

    fn next_wakeup(&self) -> Timestamp {
        self.0.next_wakeup()
    }

    fn transmit(&mut self, now: Timestamp) -> Option<Output> {
        self.0.transmit(now)
    }

    fn report(&mut self) -> Option<Report> {
        let report = self.0.report()?;
        if let Report::State(state) = &report {
            assert!(state.samples_lost == 0, "a sample was lost");
        }
        Some(report)
    }
}

fn fragile(config: &Config) -> Fragile {
    Fragile(Controller::new(*config, Timestamp::ZERO))
}

#[test]
fn a_controller_of_ones_own_hears_and_says_what_ours_would() {
    let record = |trial: Trial| {
        let run = trial.with_record(Level::Full).run().unwrap();
        assert!(run.passed(), "{run}");
        std::fs::read(run.folder().join("record.hilrec")).unwrap()
    };
    assert_eq!(record(line()), record(line().with_controller(fragile)));
}

#[test]
fn a_campaign_gives_the_smallest_case_as_a_plan() {
    let trial = line().with_controller(fragile);
    let findings = trial.campaign().faults(&["drop"]).cases(8).run().unwrap();
    let [smallest] = findings.smallest() else { panic!("{findings}") };
    let smallest = smallest.clone();
    assert_eq!(smallest.property, "no_panic");
    assert!(findings.to_string().contains(&smallest.plan), "{findings}");
    let folder = findings.folder().to_owned();
    drop(findings);
    // The saved plan fails again by itself.
    let again = Trial::load(smallest.path.to_str().unwrap()).unwrap().with_seed(smallest.seed);
    let again = again.with_controller(fragile);
    assert!(catch_unwind(AssertUnwindSafe(|| again.run().map(drop))).is_err());
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_campaign_that_breaks_nothing_leaves_nothing() {
    let campaign = line().campaign().faults(&["drop"]).cases(4);
    let findings = campaign.run().unwrap();
    assert!(findings.held(), "{findings}");
    assert_eq!(findings.campaign().tally.cases, 4);
    let folder = findings.folder().to_owned();
    drop(findings);
    assert!(!folder.exists());
    let unknown = campaign.faults(&["drip"]).run().unwrap_err();
    assert!(unknown.to_string().contains("\"drip\""), "{unknown}");
}

/// Otherwise judging the record again would take the original text for the plan that was run.
#[test]
fn a_plan_that_was_changed_in_code_leaves_no_text_in_the_record() {
    let held = |trial: &Trial| trial.prepared.header(1).files.plan().map(str::to_owned);
    assert_eq!(held(&line()).as_deref(), Some(LINE));
    let drop = FaultKind::typical("drop").unwrap();
    let struck = line().with_faults([Fault::new(Target::Gyro, drop)]);
    assert_eq!(held(&struck), None);
    assert!(!struck.prepared.header(1).files.0.is_empty(), "what it names is as it was");
}
