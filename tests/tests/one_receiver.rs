//! A CAN fault of one node: the others go on hearing each other.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::first_answers::BEAT;
use crate::rigs::{PACK, load, project};

/// The plan commands a current as the manager. The charger is struck after 3 s.
fn run(fault: &str) -> harness::TrialRun {
    let manager = "under_test = { command = [\"python3\", \"manager.py\", \"{can0}\"] }";
    let rig = PACK.replace(manager, "tester = true");
    assert_ne!(rig, PACK);
    let measured = |name: &str, quantity: &str, unit: &str| {
        format!(
            "[[measurement]]\nname = \"{name}\"\ndoc = \"Of one node\"\nquantity = \"{quantity}\"\nunit = \"{unit}\"\n\
             check = {{ all_within = {{ at_most = 0.12 }} }}\n"
        )
    };
    let plan = format!(
        "name = \"plan\"\ntitle = \"One node is struck\"\nrig = \"pack\"\nsteps = [\n\
         {{ send = {{ message = \"ManagerCommand\", set = {{ CurrentLimit = 9, ContactorClosed = 1 }}, every_s = 0.05 }} }},\n\
         {{ wait = {{ duration_s = 5 }} }}]\n\
         [[fault]]\ntarget = \"charger\"\n{fault}\nwhen = {{ at_s = 3.02 }}\n\
         [[property]]\nname = \"charges\"\nalways = \"charger.Current > 1 A -> always [0 s, 4 s]: charger.Current > 1 A\"\n{}{}{}",
        measured("cells", "period.cells.CellStatus", "s"),
        measured("manager", "period.manager.ManagerCommand", "s"),
        measured("charger", "period.charger.ChargerStatus", "s"),
    );
    load(&project(&rig, &plan)).unwrap().run().unwrap()
}

#[test]
fn who_is_unplugged_is_alone() {
    let run = run("what = { disconnect = { for_s = 1 } }");
    assert!(run.value("cells").unwrap() < 0.12 && run.value("manager").unwrap() < 0.12, "{run}");
    assert!(run.value("charger").unwrap() > 0.9, "{run}");
}

/// It hears no command, and ceases to charge by itself; its own messages are there.
#[test]
fn what_one_loses_the_others_hear() {
    let run = run("toward = \"device\"\nduration_s = 1\nwhat = { drop = { loss_percent = 100 } }");
    for name in ["cells", "manager", "charger"] {
        assert!(run.value(name).unwrap() < 0.12, "{name}: {run}");
    }
    assert_eq!(run.property("charges").unwrap().held, Some(false), "{run}");
}

/// Two nodes alone on a bus: what one of them loses was on it all the same, and is judged.
#[test]
fn what_the_only_other_node_loses_is_judged() {
    let rig = "[[line]]\nname = \"can0\"\ncan = {}\n[[node]]\nname = \"beat\"\nat = \"can0\"\nemulate = \"beat\"\n\
         [[node]]\nname = \"desk\"\nat = \"can0\"\ntester = true\n";
    let plan = "name = \"plan\"\ntitle = \"The host is unplugged\"\nrig = \"two\"\nsteps = [{ wait = { duration_s = 2.05 } }]\n\
         [[property]]\nname = \"low\"\nalways = \"beat.N < 150\"\n\
         [[property]]\nname = \"heard\"\nalways = \"not (historically [0 s, 500 ms]: not changes(beat.N))\"\n\
         [[fault]]\ntarget = \"desk\"\ntoward = \"device\"\nwhat = { disconnect = { for_s = 0.7 } }\nwhen = { at_s = 1.4 }\n";
    let folder = tests::project::of([
        ("devices/beat.toml", BEAT),
        ("rigs/two.toml", rig),
        ("plan.toml", plan),
    ]);
    let run = tests::project::load(&folder, "plan.toml").unwrap().run().unwrap();
    assert_eq!(run.property("low").unwrap().held, Some(false), "{run}");
    assert_eq!(run.property("heard").unwrap().held, Some(true), "{run}");
}
