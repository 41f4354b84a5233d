//! Repeats a recorded run for its device under test: the same controller gives the same output, differences are
//! reported.

use controller::Controller;
use harness::hosted::Hosting;
use harness::run::{Clock, Prepared, RerunError, rerun};
use plan::library::{Kind, Library, names};
use plan::made::Made;
use record::{Record, RecordKind};
use tests::devices::shipped;
use tests::plans::{plan_of, prepared, run};
use wire::time::Timestamp;
use wire::units::Speed;

const DRIVES: &str = "{ bias_test = { duration_s = 3 } }, { place = { x_m = 0, y_m = 0, heading_deg = 0 } }, \
                      { straight = { distance_m = 1, speed_m_per_s = 0.4 } }, \
                      { turn = { angle_deg = 90, rate_deg_per_s = 30 } }";

fn again(prepared: &Prepared, records: &[Record]) -> Result<harness::run::Rerun, RerunError> {
    rerun(prepared, 1, Clock::Virtual, records.iter().cloned().map(Ok))
}

#[test]
fn the_same_controller_says_the_same() {
    for devices in ["paper", "paper-serial"] {
        let prepared = prepared(&plan_of(DRIVES), shipped(devices));
        let came = again(&prepared, &run(&prepared, 1).records).unwrap();
        assert_eq!(came.difference, None, "{devices}");
        assert_eq!((came.recorded.reports, came.recorded.reports > 20), (came.now.reports, true));
        assert!(came.now.outputs.abs_diff(came.recorded.outputs) <= 2, "{came:?}");
        assert!(came.recorded.outputs > 100, "{came:?}");
    }
}

#[test]
fn one_that_drives_slower_is_told_by_its_first_order() {
    let good = prepared(&plan_of(DRIVES), shipped("paper-serial"));
    let records = run(&good, 1).records;
    let slow = Hosting::of(|config| {
        let mut config = *config;
        if let Some(base) = &mut config.base {
            base.speed_max = Speed::from_m_per_s(0.2);
        }
        Controller::new(config, Timestamp::ZERO)
    });
    let came = again(&Prepared { hosting: slow, ..good }, &records).unwrap();
    let difference = came.difference.unwrap();
    let (then, now) = (difference.recorded.unwrap(), difference.now.unwrap());
    let begun = records.iter().find(|record| {
        matches!(&record.kind, RecordKind::StepBegan { title, .. } if title.contains("straight"))
    });
    let begun = begun.unwrap().at;
    assert!(then.at >= begun && now.at >= begun, "{then:?} {now:?}");
}

#[test]
fn a_record_that_does_not_hold_what_was_heard_is_refused() {
    let prepared = prepared(&plan_of(DRIVES), shipped("paper"));
    let mut records = run(&prepared, 1).records;
    records.retain(|record| !matches!(record.kind, RecordKind::Bytes(_) | RecordKind::Frame(_)));
    assert!(matches!(again(&prepared, &records), Err(RerunError::NoBytes)));
}

#[test]
fn faults_of_a_line_are_what_was_heard_and_faults_of_the_machine_are_refused() {
    let of = |target: &str, what: &str| {
        let fault = format!(
            "\n[[fault]]\ntarget = \"{target}\"\nwhat = {{ {what} }}\nwhen = {{ step = \"straight\", after_s = 1 }}\n"
        );
        let prepared = prepared(&(plan_of(DRIVES) + &fault), shipped("paper"));
        let records = run(&prepared, 1).records;
        again(&prepared, &records)
    };
    assert_eq!(of("gyro", "drop = { loss_percent = 20 }").unwrap().difference, None);
    // These strike what the controller itself sends, on its bus.
    for what in [
        "drop = { loss_percent = 20 }",
        "duplicate = { duplicate_percent = 20 }",
        "reorder = { reorder_percent = 20 }",
        "corrupt = { corrupt_percent = 20 }",
        "delay = { by_s = 0.03 }",
        "lost_arbitration = { lose_percent = 20 }",
        "bus_load = { load_percent = 40 }",
    ] {
        let came = of("base", what).unwrap();
        assert_eq!(came.difference, None, "{what}");
        assert!(came.now.outputs.abs_diff(came.recorded.outputs) <= 2, "{what}: {came:?}");
    }
    let stalled = of("host", "scheduler_stall = { for_s = 0.2 }");
    assert!(matches!(stalled, Err(RerunError::HostFault { .. })), "{stalled:?}");
}

/// Others have no controller, or a program that is not built here.
#[test]
fn shipped_plans_of_a_robot_on_a_square_are_the_same() {
    let library = Library::shipped();
    for name in names(Kind::Plan).into_iter().filter(|name| name.starts_with("live-")) {
        let prepared = Prepared::load_from(&library, &name, &Made::default()).unwrap();
        if prepared.rig.robot.is_some() && prepared.plan.faults.is_empty() {
            let came = again(&prepared, &run(&prepared, 1).records).unwrap();
            assert_eq!(came.difference, None, "{name}");
        }
    }
}
