//! Tests the model on real runs in virtual time.

use harness::operator::Answers;
use harness::run::{Ended, Prepared, simulate};
use plan::Plan;
use plan::made::Made;
use record::Progress;
use record::RecordKind;
use record::sink::{Level, MemorySink, NullSink, RecordSink as _};
use views::watch::{Feed, Model, NewsKind, Watched};
use wire::time::Timestamp;

/// A lap on a square, with a fault on the way.
pub(crate) const LAP: &str = r#"
name = "lap"
title = "One lap and losses on the gyro's line"
devices = "paper"
steps = [
    { bias_test = { duration_s = 5 } },
    { lap = { direction = "cw" } },
]

[[fault]]
target = "gyro"
toward = "host"
what = { drop = { loss_percent = 1 } }
when = { at_s = 20 }
duration_s = 4

[[property]]
always = { fresh_heading = {} }

[[measurement]]
name = "return_orientation"
doc = "Heading at the end of a lap"
quantity = "lap.gyro_error"
unit = "deg"
check = { all_within = [-1, 1] }
"#;

/// Prepares the plan and the files that it names.
pub(crate) fn prepared(text: &str) -> Prepared {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("plan.toml");
    std::fs::write(&path, text).unwrap();
    Prepared::load(path.to_str().unwrap(), &Made::default()).unwrap()
}

/// Runs a plan to its end; returns the final model and the results.
pub(crate) fn watched(prepared: &Prepared) -> (Model, Ended, MemorySink) {
    let feed = Feed::new(&prepared.plan, &prepared.header(1));
    let mut sink = Watched::new(MemorySink::new(Level::Events), Some(&feed));
    let mut pulse = |progress| {
        feed.progress(progress);
        true
    };
    let run = simulate(prepared, 1, &Answers::default(), &mut sink, &mut pulse);
    (feed.snapshot(), run, sink.into_inner())
}

/// The model of a run at the instant `until_s`; `steps` are the steps done by then, and the total.
pub(crate) fn midway(prepared: &Prepared, until_s: f64, steps: (u64, u64)) -> Model {
    let mut sink = MemorySink::new(Level::Full);
    simulate(prepared, 1, &Answers::default(), &mut sink, &mut |_| true);
    let feed = Feed::new(&prepared.plan, &prepared.header(1));
    let mut watched = Watched::new(NullSink, Some(&feed));
    let now = Timestamp::from_secs_f64(until_s);
    for record in sink.into_records().into_iter().take_while(|record| record.at <= now) {
        match record.kind {
            RecordKind::Bytes(bytes) => watched.bytes(record.at, record.device, &bytes),
            RecordKind::Frame(frame) => {
                watched.frame(record.at, record.device, frame);
            }
            _ => watched.record(record),
        }
    }
    feed.progress(Progress { now, steps_done: steps.0, steps: steps.1 });
    feed.snapshot()
}

#[test]
fn the_model_ends_with_the_numbers_of_the_summary() {
    let prepared = prepared(LAP);
    let (model, run, _) = watched(&prepared);
    let summary = harness::run::summarise(&prepared, 1, &run);
    let end_s = summary.simulated_s;
    assert!(model.now.as_secs_f64() <= end_s && model.now.as_secs_f64() > end_s - 1.0);
    assert_eq!((model.steps_done, model.under_way.is_none()), (2, true));
    let [gauge] = &model.gauges[..] else { panic!("one quantity: {:#?}", model.gauges) };
    let [measurement] = &summary.measurements[..] else { panic!("{summary:#?}") };
    assert_eq!(gauge.series.count(), measurement.observations);
    assert_eq!(gauge.last(), measurement.value, "the only lap is the worst");
    assert_eq!(gauge.outside == 0, measurement.verdict.is_acceptable());
    let [fault] = &summary.faults[..] else { panic!("{summary:#?}") };
    assert!(fault.begun && model.faults.is_empty(), "it is over");
    let faults = model.news.latest().filter(|piece| piece.kind == NewsKind::Fault).count();
    assert_eq!(faults, 2, "its begin and its end");
    assert_eq!(model.estimate.left_s(model.now), Some(0.0));
    assert_eq!(model.robot.commanded.len(), 5, "a square is closed");
}

#[test]
fn a_run_is_the_same_whether_anybody_watches_or_not() {
    let prepared = prepared(LAP);
    let (model, _, seen) = watched(&prepared);
    let mut alone = MemorySink::new(Level::Events);
    simulate(&prepared, 1, &Answers::default(), &mut alone, &mut |_| true);
    // Records below the level of the sink also reach the model.
    assert!(model.records >= alone.records().len() as u64);
    assert_eq!(seen.records(), alone.records());
}

#[test]
fn frames_are_counted_without_a_full_record() {
    let (model, ..) = watched(&prepared(LAP));
    let senders: Vec<_> = model.traffic.senders().map(|(device, _, way)| (device, *way)).collect();
    let names: Vec<_> = senders.iter().map(|(device, _)| device.name()).collect();
    assert_eq!(names, ["controller", "gyro", "base"]);
    let gyro = senders[1].1;
    assert!(gyro.bytes > 1_000 && gyro.frames == 0, "{gyro:?}");
    assert!(senders[2].1.frames > 1_000, "{:?}", senders[2]);
    assert!(model.traffic.bus_load.is_some_and(|load| load > 0.0 && load < 1.0));
}

#[test]
fn an_estimate_of_the_papers_plans_is_near() {
    for name in ["laps-corrected", "verification", "warm-up"] {
        let prepared = Prepared::load(name, &Made::default()).unwrap();
        let header = prepared.header(1);
        let nominal_s = Model::new(&prepared.plan, &header).estimate.nominal_s();
        let (_, run, _) = watched(&prepared);
        let took_s = run.end.as_secs_f64();
        let ratio = took_s / nominal_s;
        assert!((0.8..1.4).contains(&ratio), "{name}: {nominal_s} s nominal, {took_s} s taken");
    }
}

#[test]
fn a_plan_in_memory_has_a_model_before_it_runs() {
    let plan = Plan::parse("lap.toml", LAP).unwrap();
    let header = harness::run::header(&plan, 7, &[]);
    let model = Model::new(&plan, &header);
    assert_eq!((model.plan.as_str(), model.seed, model.steps), ("lap", 7, 0));
    assert_eq!(model.estimate.share(model.now), Some(0.0));
}
