//! A node on two lines that says the same message on each.

use harness::{Trial, TrialError};
use tempfile::TempDir;
use tests::project;

const DBC: &str = "VERSION \"\"\nNS_ :\nBS_:\nBU_: MOTOR\n\
    BO_ 256 MotorStatus: 2 MOTOR\n SG_ Speed : 0|16@1+ (1,0) [0|10000] \"rpm\" Vector__XXX\n";

const RIG: &str = r#"
[[line]]
name = "front"
can = { dbc = "../motor.dbc" }
[[line]]
name = "rear"
can = { dbc = "../motor.dbc" }
[[node]]
name = "motor"
at = ["front", "rear"]
replay = { log = "../motor.log" }
"#;

/// 1000 rpm on one, 5000 on the other.
const LOG: &str = "(0.0) front 100#E803\n(0.0) rear 100#8813\n\
                   (0.1) front 100#E803\n(0.2) rear 100#8813\n";

fn load(quantity: &str, always: &str) -> (TempDir, Result<Trial, TrialError>) {
    let of_period = quantity.starts_with("period.");
    let unit = if of_period { "s" } else { "rpm" };
    let plan = format!(
        "name = \"plan\"\ntitle = \"How fast it is\"\nrig = \"motor\"\nsteps = [{{ wait = {{ duration_s = 1 }} }}]\n\
         [[measurement]]\nname = \"it\"\ndoc = \"What it is\"\nquantity = \"{quantity}\"\nunit = \"{unit}\"\n\
         observations_min = 1\ncheck = {{ all_within = {{ at_least = 0 }} }}\n\
         [[property]]\nname = \"holds\"\nalways = \"{always}\"\n"
    );
    let folder = project::of([
        ("motor.dbc", DBC),
        ("motor.log", LOG),
        ("rigs/motor.toml", RIG),
        ("plan.toml", &*plan),
    ]);
    let trial = project::load(&folder, "plan.toml");
    (folder, trial)
}

#[test]
fn the_line_says_which_of_them_is_judged() {
    let value = |quantity, always| {
        let (_folder, trial) = load(quantity, always);
        let trial = trial.unwrap_or_else(|error| panic!("{}", project::why(&error)));
        let run = trial.run().unwrap();
        (run.value("it").unwrap(), run.property("holds").unwrap().held)
    };
    let (speed, held) = value("motor.front.Speed", "motor.front.Speed == 1000 rpm");
    assert_eq!((speed, held), (1_000.0, Some(true)));
    let (speed, held) = value("motor.rear.MotorStatus.Speed", "motor.rear.Speed == 1000 rpm");
    assert_eq!((speed, held), (5_000.0, Some(false)));
    let (period, _) = value("period.motor.rear.MotorStatus", "motor.rear.Speed == 5000 rpm");
    assert!((period - 0.2).abs() < 1e-3, "{period}");
}

#[test]
fn without_a_line_the_name_is_refused() {
    let always = "motor.rear.Speed > 0";
    for (quantity, always, expected) in [
        ("motor.Speed", always, "`motor` sends `Speed` on several lines"),
        ("period.motor.MotorStatus", always, "`motor` sends `MotorStatus` on several lines"),
        ("motor.rear.Speed", "motor.Speed > 0", "`motor` sends `Speed` on several lines"),
        ("motor.left.Speed", always, "no signal `left.Speed`"),
    ] {
        let (_folder, trial) = load(quantity, always);
        let why = project::why(&trial.err().unwrap());
        assert!(why.contains(expected), "{quantity}, {always}: {why}");
    }
}
