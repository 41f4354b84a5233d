//! The loop closed on a user's own sensor: it has an undeclared error, another node's readings are the reference, `hil identify`
//! finds the error, and the readings are compensated.

use harness::run::{Ended, Prepared, simulate};
use identification::finding::Finding;
use plan::made::Made;
use plan::observation::Observed;
use record::outcome::Outcome;
use record::sink::NullSink;
use rig::operator::Answers;
use tempfile::TempDir;

/// Reads an angle 120 ms late, with two cycles a turn and an offset: in the emulator alone, as an expression.
const RESOLVER: &str = r#"
name = "resolver"
title = "A resolver that errs"
step_s = 0.05
[[message]]
name = "Reading"
sent_by = "device"
can_id = 0x100
period_s = 0.05
fields = [{ name = "Angle", type = "u16", scale = 0.01, maximum = 360, unit = "deg" }]
[state.late]
value = "t - 0.12"
[state.shaft]
value = "40 * late + 120 * sin(0.2 * late) + 50 * sin(0.53 * late)"
[state.read]
value = "shaft + 0.3 + 0.8 * sin(2 * shaft * pi / 180 + 0.5)"
[signal.Angle]
expression = "read - 360 * floor(read / 360)"
noise = 0.05
"#;

/// What is true: the same shaft.
const ENCODER: &str = r#"
name = "encoder"
title = "An encoder that knows the angle"
step_s = 0.05
[[message]]
name = "Truth"
sent_by = "device"
can_id = 0x101
period_s = 0.05
fields = [{ name = "Angle", type = "u16", scale = 0.01, maximum = 360, unit = "deg" }]
[state.shaft]
value = "40 * t + 120 * sin(0.2 * t) + 50 * sin(0.53 * t)"
[signal.Angle]
expression = "shaft - 360 * floor(shaft / 360)"
"#;

/// The same resolver, whose errors are a model that was found.
const LEARNED: &str = r#"
name = "resolver"
title = "A resolver that errs as a model says"
step_s = 0.05
[[message]]
name = "Reading"
sent_by = "device"
can_id = 0x100
period_s = 0.05
fields = [{ name = "Angle", type = "f32", unit = "deg" }]
[state.shaft]
value = "40 * t + 120 * sin(0.2 * t) + 50 * sin(0.53 * t)"
[signal.Angle]
expression = "shaft"
model = "found.model.toml"
"#;

const RIG: &str = r#"
title = "A resolver beside an encoder"
[[line]]
name = "can0"
can = { bit_rate = 500_000 }
[[node]]
name = "resolver"
at = "can0"
emulate = "resolver"
[[node]]
name = "encoder"
at = "can0"
emulate = "encoder"
"#;

const LOOP: &str = r#"
name = "loop"
title = "A resolver, identified and corrected"
rig = "bench"
steps = [
    { wait = { duration_s = 2 } },
    { repeat = { times = 6, steps = [{ wait = { duration_s = 20 } }] }, label = "before" },
    { identify = { from = "sensor", measured = "resolver.Angle", reference = "encoder.Angle", name = "shape", over = "before" } },
    { use_model = "shape" },
    { repeat = { times = 2, steps = [{ wait = { duration_s = 20 } }] }, label = "after" },
    { use_model = "none" },
    { wait = { duration_s = 20 }, label = "plain" },
]
[[measurement]]
name = "kept"
doc = "The part of the error that the compensation leaves"
quantity = "identification.error_kept"
unit = "1"
check = { all_within = [0, 0.2] }
"#;

const LISTEN: &str = r#"
name = "listen"
title = "What the resolver says"
rig = "bench"
steps = [{ wait = { duration_s = 60 } }]
[[measurement]]
name = "angle"
doc = "What the resolver says"
quantity = "resolver.Angle"
unit = "deg"
check = { all_within = [-400, 1e6] }
"#;

fn project(plan: &str, files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let fixed = [("rigs/bench.toml", RIG), ("devices/encoder.toml", ENCODER), ("plan.toml", plan)];
    for (path, text) in fixed.iter().chain(files) {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().expect("in the folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    }
    folder
}

fn load(project: &TempDir) -> Prepared {
    let plan = project.path().join("plan.toml");
    let plan = plan.to_str().expect("text");
    match Prepared::load(plan, &Made::default()) {
        Ok(prepared) => prepared,
        Err(error) => panic!("{:?}", miette::Report::new(error)),
    }
}

fn run(prepared: &Prepared, seed: u64) -> Ended {
    simulate(prepared, seed, &Answers::default(), &mut NullSink, &mut |_| true)
}

/// The angle of the shaft that is read, deg. A motion of one tone alone does not tell a delay from a period.
fn shaft(t: f64) -> f64 {
    40.0 * t + 120.0 * (0.2 * t).sin() + 50.0 * (0.53 * t).sin()
}

/// Errors of the readings during a label, deg, with when they were.
fn errors(done: &Ended, during: Option<&str>) -> Vec<(f64, f64)> {
    let is_meant = |one: &Observed<'_>| {
        during.is_none_or(|label| one.tag(&format!("during.{label}")).is_some())
    };
    let readings = done.observations.of("resolver.Angle").filter(is_meant);
    let error = |one: Observed<'_>| {
        let at = one.time().expect("each was made at some time");
        let error = one.value() - shaft(at);
        (at, error - 360.0 * (error / 360.0).round())
    };
    readings.map(error).collect()
}

fn rms(errors: &[(f64, f64)]) -> f64 {
    assert!(!errors.is_empty());
    (errors.iter().map(|(_, error)| error * error).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn an_error_that_nobody_declared_is_found_taken_off_and_emulated() {
    let project_of_loop = project(LOOP, &[("devices/resolver.toml", RESOLVER)]);
    let done = run(&load(&project_of_loop), 1);
    assert_eq!(done.ending.outcome, Outcome::Passed, "{:?}", done.ending);
    let finding: &Finding = &done.made.findings["shape"];
    let names: Vec<&str> = finding.effects.iter().map(|effect| &*effect.name).collect();
    assert!(names.contains(&"twice_a_turn"), "{names:?}");
    assert!(names.contains(&"delay"), "{names:?}");

    let [before, after, plain] =
        ["before", "after", "plain"].map(|label| errors(&done, Some(label)));
    // A slope is known a few readings after the correction began.
    let [before, after, plain] = [before, after, plain].map(|errors| rms(&errors[20..]));
    assert!(before > 1.0 && plain > 1.0, "{before} {plain}");
    // Noise of 0.05 deg, and what leading it by its slope adds.
    assert!(after < 0.15 * before, "{before} -> {after}");
    let told = finding.compensation.as_ref().expect("a compensation");
    assert_eq!((&*told.of, &*told.unit), ("resolver.Angle", "deg"));
    assert!((told.held_out.after / after - 1.0).abs() < 0.3, "{} {after}", told.held_out.after);

    // The emulated sensor takes the model that was found, latency and all.
    let model = plan::models::to_toml(&done.made.models["shape"], "found in a test");
    let files = [("devices/resolver.toml", LEARNED), ("devices/found.model.toml", &model)];
    let learned = run(&load(&project(LISTEN, &files)), 1);
    let learned = errors(&learned, None);
    let truly = |at: f64| {
        let late = shaft(at - 0.12);
        late - shaft(at) + 0.3 + 0.8 * (2.0 * late.to_radians() + 0.5).sin()
    };
    let off: Vec<(f64, f64)> = learned
        .iter()
        .filter(|(at, _)| *at > 1.0)
        .map(|(at, error)| (*at, error - truly(*at)))
        .collect();
    // The model's cycles go with the angle now, those of the resolver with the angle then: 0.07 deg apart.
    assert!(rms(&off) < 0.1, "{}", rms(&off));
}

#[test]
fn what_a_plan_says_of_a_sensor_is_checked_before_it_runs() {
    let refused = |from: &str, to: &str| {
        assert!(LOOP.contains(from), "{from}");
        let text = LOOP.replacen(from, to, 1);
        let project = project(&text, &[("devices/resolver.toml", RESOLVER)]);
        let plan = project.path().join("plan.toml");
        let plan = plan.to_str().expect("text");
        let error = Prepared::load(plan, &Made::default()).err();
        error.expect("a mistake").to_string()
    };
    for (from, to, said) in [
        ("reference = \"encoder.Angle\", ", "", "missing field `reference`"),
        ("\"encoder.Angle\"", "\"encoder.Speed\"", "no signal `Speed` in the layout of `encoder`"),
        ("\"encoder.Angle\"", "\"resolver.Angle\"", "the reference is what is measured itself"),
        ("\"sensor\", measured", "\"turns\", measured", "`measured` has no meaning from turns"),
        (
            "\"encoder.Angle\"",
            "\"period.encoder.Truth\"",
            "`period.encoder.Truth` is no signal of a node",
        ),
    ] {
        let found = refused(from, to);
        assert!(found.contains(said), "{to}: {found}");
    }
}
