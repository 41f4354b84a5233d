//! Rigs: errors in a file are reported at their place; two buses and a gateway; a node that nothing emulates; faults
//! that name nodes and lines.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::run::Prepared;
use harness::{Trial, TrialError, TrialRun};
use plan::made::Made;
use tempfile::TempDir;
use tests::plans::{plan_of, record_file};
use tests::project;
use wire::device::{Device, PortId, Transmit};
use wire::time::Timestamp;

pub const PACK: &str = include_str!("../../examples/battery-pack/rigs/pack.toml");
const DBC: &str = include_str!("../../examples/battery-pack/devices/pack.dbc");
const CELLS: &str = include_str!("../../examples/battery-pack/devices/cells.toml");
const CHARGER: &str = include_str!("../../examples/battery-pack/devices/charger.toml");

/// A device with a text protocol on a serial line.
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
text = "{Mass:.2}\r\n"
period_s = 0.1
[signal.Mass]
expression = "load"
"#;

/// Another DBC of the same bus: the manager has one more message, and both files contain the cells' message, with
/// different comments.
const MORE: &str = r#"VERSION ""
NS_ :
BS_:
BU_: MANAGER Cells
BO_ 784 Report: 1 MANAGER
 SG_ Level : 0|8@1+ (1,0) [0|100] "%" Vector__XXX
BO_ 256 CellStatus: 8 Cells
 SG_ TemperatureMax : 32|8@1- (1,0) [-40|120] "degC" MANAGER
 SG_ VoltageMax : 0|16@1+ (0.001,0) [0|6] "V" MANAGER
 SG_ VoltageMin : 16|16@1+ (0.001,0) [0|6] "V" MANAGER
 SG_ Alive : 40|4@1+ (1,0) [0|15] "" MANAGER
 SG_ Crc : 56|8@1+ (1,0) [0|255] "" MANAGER
CM_ SG_ 256 VoltageMax "As measured.";
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 10000;
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_ "GenMsgCycleTime" BO_ 256 100;
"#;

/// Creates a project with this rig and this plan.
pub fn project(rig: &str, plan: &str) -> TempDir {
    project_with(MORE, rig, plan)
}

fn project_with(more: &str, rig: &str, plan: &str) -> TempDir {
    project::of([
        ("rigs/pack.toml", rig),
        ("devices/pack.dbc", DBC),
        ("devices/more.dbc", more),
        ("devices/cells.toml", CELLS),
        ("devices/charger.toml", CHARGER),
        ("devices/scale.toml", SCALE),
        ("plan.toml", plan),
    ])
}

pub fn load(folder: &TempDir) -> Result<Trial, TrialError> {
    project::load(folder, "plan.toml")
}

/// A plan that measures one quantity.
fn plan(steps: &str, quantity: &str, unit: &str, check: &str) -> String {
    format!(
        "name = \"plan\"\ntitle = \"\"\nrig = \"pack\"\nsteps = [{steps}]\n[[measurement]]\nname = \"it\"\ndoc = \"\"\n\
         quantity = \"{quantity}\"\nunit = \"{unit}\"\ncheck = {{ {check} }}\n"
    )
}

const WAIT: &str = "{ wait = { duration_s = 2 } }";

pub fn cells() -> String {
    plan(WAIT, "cells.VoltageMax", "V", "all_within = [3, 4.2]")
}

/// Error message for a rig, or for a plan on it.
fn refused(rig: &str, plan: &str) -> String {
    why_not(&project(rig, plan))
}

fn why_not(project: &TempDir) -> String {
    let Err(error) = load(project) else { panic!("taken") };
    let mut said = error.to_string();
    let mut cause = std::error::Error::source(&error);
    while let Some(one) = cause {
        said = format!("{said}: {one}");
        cause = one.source();
    }
    said
}

#[test]
fn what_is_wrong_with_a_rig_is_refused() {
    let node = |more: &str| format!("{PACK}\n[[node]]\n{more}");
    let serial = "[[line]]\nname = \"uart\"\nserial = {}\n";
    let third = "[[node]]\nname = \"a\"\nat = \"uart\"\nemulate = \"scale\"\n\
                 [[node]]\nname = \"b\"\nat = \"uart\"\ntester = true\n\
                 [[node]]\nname = \"c\"\nat = \"uart\"\ntester = true\n";
    for (rig, expected) in [
        (
            node("name = \"cells\"\nat = \"can0\"\nemulate = \"cells\""),
            "two nodes are called `cells`",
        ),
        (
            node("name = \"extra\"\nat = \"can7\"\nemulate = \"cells\""),
            "no line `can7` for `extra`",
        ),
        (node("name = \"extra\"\nat = []\nemulate = \"cells\""), "`extra` is on no line"),
        (format!("{serial}{third}"), "a second host on the serial line `uart` of 3 ends"),
        (PACK.replace("\"manager\"", "\"manger\""), "no node `manger` in"),
        (
            node("name = \"gyro\"\nat = \"can0\"\nemulate = \"cells\""),
            "`gyro` has a meaning of its own",
        ),
        (
            node("name = \"extra\"\nat = \"can0\""),
            "needs exactly one of `emulate`, `under_test`, `tester = true` and `replay`",
        ),
        (
            node("name = \"extra\"\nat = \"can0\"\ntester = false"),
            "`extra` needs exactly one of `emulate`",
        ),
        (PACK.replace("250_000", "12"), "expected 10,000 to 1,000,000 bits per second"),
        (
            node("name = \"b\"\nat = \"can0\"\nemulate = \"cells\"\nset = { ofset = 1 }"),
            "no parameter `ofset`: did you mean `offset`?",
        ),
        (
            node("name = \"b\"\nat = \"can0\"\ntester = true\nset = { offset = 1 }"),
            "`b` is not emulated from a file",
        ),
        (node("name = \"extra\"\nat = \"can0\"\nemulate = \"scale\""), "on the other kind of line"),
        (format!("{PACK}\n[[line]]\nname = \"can0\"\ncan = {{}}\n"), "two lines are called `can0`"),
        (format!("{PACK}\n[[line]]\nname = \"host\"\ncan = {{}}\n"), "`host` has a meaning of"),
        (PACK.replace("pack.dbc", "none.dbc"), "none.dbc"),
        (
            PACK.replace("\"python3\", \"manager.py\", \"{can0}\"", ""),
            "no program in the command of `manager`",
        ),
        ("title = \"nothing\"".to_owned(), "a rig without a node"),
    ] {
        let said = refused(&rig, &cells());
        assert!(said.contains(expected), "{expected}\n{said}");
    }
}

#[test]
fn what_a_plan_says_of_nodes_that_are_not_there_is_refused() {
    let unit = |quantity: &str| plan(WAIT, quantity, "V", "all_within = [0, 9]");
    let steps = |steps: &str| plan(steps, "cells.VoltageMax", "V", "all_within = [0, 9]");
    for (plan, expected) in [
        (unit("cell.VoltageMax"), "no node `cell` whose messages are known"),
        (unit("cells.VoltgeMax"), "no signal `VoltgeMax` in the layout of `cells`"),
        (unit("cells.ContactorClosed"), "`ContactorClosed` is sent to `cells`, and not by it"),
        (unit("cells.TemperatureMax"), "unit `V`, expected `degC`"),
        (unit("period.cells.CellStats"), "no message `CellStats` that `cells` sends"),
        (
            steps("{ send = { message = \"CellStatus\" } }"),
            "`CellStatus` is sent by `cells` itself",
        ),
        (steps("{ power_cycle = { device = \"cell\", off_s = 1 } }"), "no `cell` on this bench"),
        // Found by a user: it was said that there is no such node.
        (
            steps("{ set_parameter = { parameter = \"manager.offset\", value = 1 } }"),
            "cannot reach into `manager`, which is not emulated",
        ),
        (steps("{ turn = { angle_deg = 90 } }"), "`turn` is for a gyro on a robot or a table"),
        (
            format!(
                "{}[[fault]]\ntarget = \"can7\"\nwhat = {{ drop = {{ loss_percent = 5 }} }}\n",
                cells()
            ),
            "no node and no line `can7` in this rig",
        ),
        (
            format!(
                "{}[[fault]]\ntarget = \"can0\"\nwhat = {{ flip = {{ flip_percent = 5 }} }}\n",
                cells()
            ),
            "`flip` is of a serial line, and `can0` is on CAN",
        ),
    ] {
        let said = refused(PACK, &plan);
        assert!(said.contains(expected), "{expected}\n{said}");
    }
}

#[test]
fn a_signal_that_a_formula_misspells_is_found_within_its_node() {
    let judged = format!("{}[[property]]\nalways = \"cells.voltagemax < 4.3 V\"\n", cells());
    let Err(error) = load(&project(PACK, &judged)) else { panic!("taken") };
    assert!(format!("{error:?}").contains("did you mean `cells.VoltageMax`?"), "{error:?}");
}

/// The plan sends as the manager, with messages of both files.
fn two_files() -> String {
    let both = "[\"../devices/pack.dbc\", \"../devices/more.dbc\"]";
    PACK.replace("\"../devices/pack.dbc\"", both).replace(
        "under_test = { command = [\"python3\", \"manager.py\", \"{can0}\"] }",
        "tester = true",
    )
}

#[test]
fn messages_of_several_files_are_those_of_the_line() {
    let steps = "{ send = { message = \"Report\", set = { Level = 40 }, every_s = 0.1 } }, \
                 { send = { message = \"ManagerCommand\", set = { CurrentLimit = 9 }, every_s = 0.1 } }, \
                 { wait = { duration_s = 2 } }";
    for (quantity, unit, check) in [
        ("manager.Level", "%", "all_within = [40, 40]"),
        ("manager.CurrentLimit", "A", "all_within = [9, 9]"),
        ("cells.VoltageMax", "V", "all_within = [3, 4.2]"),
    ] {
        let run = load(&project(&two_files(), &plan(steps, quantity, unit, check))).unwrap().run();
        assert!(run.unwrap().passed(), "{quantity}");
    }
}

#[test]
fn files_that_contradict_each_other_are_refused() {
    for (from, to, expected) in [
        ("BO_ 784 Report", "BO_ 768 Report", "have one identifier"),
        ("256", "257", "have one name and two identifiers"),
        ("CellStatus: 8", "CellStatus: 7", "have one identifier and two lengths"),
        ("CellStatus: 8 Cells", "CellStatus: 8 MANAGER", "have one identifier and two senders"),
        ("BO_ 256 100", "BO_ 256 200", "have one identifier and two cycle times"),
        ("0.001,0) [0|6] \"V\"", "0.002,0) [0|6] \"V\"", "two definitions of `VoltageMax`"),
    ] {
        let said = why_not(&project_with(&MORE.replace(from, to), &two_files(), &cells()));
        assert!(said.contains(expected) && said.contains("pack.dbc, line"), "{expected}\n{said}");
    }
    let said = why_not(&project_with(&MORE.replace("BO_ 784", "BO_"), &two_files(), &cells()));
    assert!(said.contains("failed to read the DBC"), "{said}");
    // The last node is the tester.
    let said = refused(&(two_files() + "dbc_node = \"Display\""), &cells());
    assert!(said.contains("no node `Display` in ") && said.contains("more.dbc"), "{said}");
}

#[test]
fn what_is_attached_has_no_place_in_virtual_time() {
    let attached = PACK.replace(
        r#"under_test = { command = ["python3", "manager.py", "{can0}"] }"#,
        "under_test = { attached = true }",
    );
    assert_ne!(attached, PACK);
    let folder = project(&attached, &cells());
    let run = load(&folder).unwrap().run().unwrap();
    assert_eq!(run.summary().outcome.name(), "error");
    let why = run.summary().reason.clone().unwrap();
    assert!(why.contains("`manager` is under test, and nothing plays it in virtual time"), "{why}");
}

#[test]
fn the_papers_robot_is_one_rig_file_among_others() {
    let steps = "{ bias_test = { duration_s = 20 } }, { place = { x_m = 0, y_m = 0, heading_deg = 0 } }, \
                 { lap = { direction = \"cw\", side_m = 0.5 } }";
    let faults = "[[fault]]\ntarget = \"gyro\"\nwhat = { drop = { loss_percent = 1 } }\n";
    let record = |named: &str| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.toml");
        let plan = plan_of(steps).replace("devices = \"none\"", named) + faults;
        std::fs::write(&path, plan).unwrap();
        let prepared = Prepared::load(path.to_str().unwrap(), &Made::default()).unwrap();
        record_file(&prepared, 1)
    };
    let (rig, short) = (record("rig = \"paper\""), record("devices = \"paper\""));
    assert!(short.len() > 10_000 && rig == short, "{} and {} bytes", rig.len(), short.len());
}

/// Forwards frames from its first line to its second, or in both directions.
#[derive(Debug, Default)]
struct Gateway {
    both_ways: bool,
    outgoing: Vec<(PortId, Transmit)>,
}

impl Device for Gateway {
    fn receive(&mut self, _: Timestamp, port: PortId, what: &Transmit) {
        if port == PortId(0) || self.both_ways {
            self.outgoing.push((PortId(1 - port.0), *what));
        }
    }

    fn wake(&mut self, _: Timestamp) {}

    fn next_wakeup(&self) -> Timestamp {
        Timestamp::MAX
    }

    fn transmit(&mut self, _: Timestamp) -> Option<(PortId, Transmit)> {
        self.outgoing.pop()
    }
}

/// Two buses, and a gateway between them.
const BUSES: &str = r#"
[[line]]
name = "can0"
can = { bit_rate = 500_000 }
[[line]]
name = "can1"
can = { bit_rate = 125_000, dbc = "../devices/pack.dbc" }
[[node]]
name = "cells"
at = "can0"
emulate = "cells"
[[node]]
name = "gateway"
at = ["can0", "can1"]
dbc_node = "Cells"
under_test = { in_process = true }
[[node]]
name = "charger"
at = "can1"
emulate = "charger"
"#;

fn across(steps: &str, faults: &str, both_ways: bool) -> TrialRun {
    let plan = plan(steps, "gateway.VoltageMax", "V", "all_within = [3, 4.2]");
    let folder = project(BUSES, &format!("{plan}observations_min = 15\n{faults}"));
    let trial = load(&folder).unwrap();
    trial.with_node("gateway", move || Gateway { both_ways, ..Gateway::default() }).run().unwrap()
}

#[test]
fn a_gateway_passes_on_what_the_other_bus_says() {
    let run = across(WAIT, "", false);
    assert!(run.passed(), "{run}");
}

#[test]
fn a_line_is_struck_by_its_name_and_no_other() {
    let fault = |target: &str, toward: &str| {
        format!(
            "[[fault]]\ntarget = \"{target}\"\ntoward = \"{toward}\"\n\
             what = {{ drop = {{ loss_percent = 100 }} }}\n"
        )
    };
    for (target, toward, passes) in [
        ("can0", "both", false),
        ("cells", "host", false),
        ("can1", "both", false),
        ("charger", "host", true),
        // What it loses was on the bus.
        ("charger", "device", true),
    ] {
        let run = across(WAIT, &fault(target, toward), false);
        assert_eq!(run.passed(), passes, "{target}, {toward}: {run}");
    }
}

#[test]
fn a_gateway_that_echoes_for_ever_does_not_hang_a_run() {
    // No node echoes the gateway's frames, so that each bus carries each frame once.
    let run = across(WAIT, "", true);
    assert!(run.passed(), "{run}");
}

#[test]
fn two_serial_devices_have_a_line_each() {
    let rig = "[[line]]\nname = \"left\"\nserial = {}\n[[line]]\nname = \"right\"\nserial = {}\n\
               [[node]]\nname = \"one\"\nat = \"left\"\nemulate = \"scale\"\n\
               [[node]]\nname = \"two\"\nat = \"right\"\nemulate = \"scale\"\n";
    let steps = "{ set_parameter = { parameter = \"two.load\", value = 7 } }, { wait = { duration_s = 1 } }";
    let one = plan(steps, "one.Mass", "1", "all_within = [5, 5]");
    assert!(load(&project(rig, &one)).unwrap().run().unwrap().passed());
    // Before it is set it sends 5.
    let two = plan(steps, "two.Mass", "1", "mean_within = [6, 7]");
    assert!(load(&project(rig, &two)).unwrap().run().unwrap().passed());
}

#[test]
fn nodes_of_one_description_have_parameters_of_their_own() {
    let rig = "[[line]]\nname = \"left\"\nserial = {}\n[[line]]\nname = \"right\"\nserial = {}\n\
               [[node]]\nname = \"one\"\nat = \"left\"\nemulate = \"scale\"\n\
               [[node]]\nname = \"two\"\nat = \"right\"\nemulate = \"scale\"\nset = { load = 8 }\n";
    for (name, mass) in [("one", 5), ("two", 8)] {
        let all = format!("all_within = [{mass}, {mass}]");
        let plan = plan(WAIT, &format!("{name}.Mass"), "1", &all);
        let run = load(&project(rig, &plan)).unwrap().run().unwrap();
        assert!(run.passed(), "{run}");
    }
}
