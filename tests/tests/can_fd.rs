//! A CAN FD bus: long messages from a DBC and from a device's file, judged, struck by faults and recorded.

use harness::Trial;
use harness::run::Prepared;
use plan::made::Made;
use record::RecordKind;
use tempfile::TempDir;
use tests::project;
use wire::can::{BitRates, CanFrame};
use wire::time::Timestamp;

const DBC: &str = r#"VERSION ""

NS_ :

BS_:

BU_: CELLS MANAGER

BO_ 1024 CellVoltages: 64 CELLS
 SG_ First : 0|16@1+ (0.001,0) [0|5] "V" MANAGER
 SG_ Middle : 250|12@1+ (0.001,0) [0|4] "V" MANAGER
 SG_ Last : 503|16@0+ (0.001,0) [0|5] "V" MANAGER

BO_ 1025 Limits: 12 MANAGER
 SG_ Current : 64|16@1+ (0.1,0) [0|500] "A" CELLS

BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","StandardCAN_FD","ExtendedCAN_FD";
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_DEF_ "VFrameFormat" "StandardCAN";
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_ "VFrameFormat" BO_ 1024 2;
BA_ "VFrameFormat" BO_ 1025 2;
BA_ "GenMsgCycleTime" BO_ 1024 10;
"#;

const CELLS: &str = r#"
name = "cells"
title = "Cells that say their voltages in long messages"
dbc = "pack.dbc"
node = "CELLS"
[signal.First]
expression = "3.7"
[signal.Middle]
expression = "3.8"
[signal.Last]
expression = "3 + 0.001 * Current"
"#;

const RIG: &str = r#"
title = "Cells on a bus of CAN FD"
[[line]]
name = "can0"
can = { bit_rate = 500_000, data_bit_rate = 2_000_000, dbc = "../devices/pack.dbc" }
[[node]]
name = "cells"
at = "can0"
emulate = "cells"
[[node]]
name = "manager"
at = "can0"
tester = true
"#;

const PLAN: &str = r#"
name = "long"
title = "The last of sixty-four bytes is right"
rig = "long"
steps = [
    { send = { message = "Limits", set = { Current = 200 } } },
    { wait = { duration_s = 1 }, label = "told" },
]
[[property]]
name = "all at once"
always = "cells.Last > 3.1 V -> cells.First > 3.6 V and cells.Middle > 3.7 V"
[[measurement]]
name = "last"
doc = ""
quantity = "cells.Last"
where = { "during.told" = 1 }
unit = "V"
check = { all_within = [3.195, 3.205] }
observations_min = 90
"#;

fn project(rig: &str, plan: &str) -> TempDir {
    project::of([
        ("devices/pack.dbc", DBC),
        ("devices/cells.toml", CELLS),
        ("rigs/long.toml", rig),
        ("long.toml", plan),
    ])
}

fn load(folder: &TempDir) -> Result<Trial, String> {
    project::load(folder, "long.toml").map_err(|error| format!("{error:?}"))
}

#[test]
fn long_messages_are_sent_judged_and_written_down() {
    let folder = project(RIG, PLAN);
    let run = load(&folder).unwrap().run().unwrap();
    assert!(run.passed(), "{run}");
    let path = folder.path().join("long.toml");
    let prepared = Prepared::load(path.to_str().unwrap(), &Made::default()).unwrap();
    let frames: Vec<(Timestamp, CanFrame)> = tests::plans::run(&prepared, 1)
        .records
        .into_iter()
        .filter_map(|record| match record.kind {
            RecordKind::Frame(frame) => Some((record.at, frame)),
            _ => None,
        })
        .collect();
    let long: Vec<_> = frames.iter().filter(|(_, frame)| frame.data().len() == 64).collect();
    assert!(
        long.len() >= 100
            && long.iter().all(|(_, frame)| frame.fd_flags().unwrap().bit_rate_switch)
    );
    // 29 bits of arbitration, 550 of data, and stuff bits that depend on the content.
    let (at, frame) = long.first().unwrap();
    let first = at.as_nanos() % 10_000_000;
    let stuffed = first - (29 * 2_000 + 550 * 500);
    assert!(stuffed % 500 == 0 && (0..=500 * 517 / 4).contains(&stuffed), "{first}");
    let rates = BitRates { nominal: 500_000, data: Some(2_000_000) };
    assert_eq!(first, frame.duration(rates).as_nanos());
}

#[test]
fn faults_strike_long_messages_and_their_signals() {
    let with = |fault: &str| {
        let folder = project(
            RIG,
            &format!("{PLAN}\n[[fault]]\ntarget = \"{fault}\nwhen = {{ at_s = 0.5 }}\n"),
        );
        load(&folder).unwrap().run().unwrap()
    };
    let offset = with("cells.Last\"\nwhat = { signal_offset = { range_percent = 20 } }");
    assert_eq!(offset.summary().outcome.name(), "failed", "{offset}");
    let struck = with("cells\"\nwhat = { corrupt = { corrupt_percent = 100 } }");
    assert_eq!(struck.summary().outcome.name(), "failed", "{struck}");
}

#[test]
fn a_classic_bus_has_no_long_messages() {
    let refused = |rig: String| load(&project(&rig, PLAN)).unwrap_err();
    let classic = refused(RIG.replace("data_bit_rate = 2_000_000, ", ""));
    assert!(classic.contains("`CellVoltages` is a CAN FD message"), "{classic}");
    assert!(classic.contains("data_bit_rate"), "{classic}");
    let slow = refused(RIG.replace("2_000_000", "250_000"));
    assert!(slow.contains("from `bit_rate` to 8,000,000"), "{slow}");
}
