//! A base on CAN: behind an adapter on a pty, and on a virtual interface.

use crate::{hil, out, record, run, shown, summary};
use skips::{Vcan0, in_time};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A side of one metre and a corner: some 20 s of real time.
pub const SIDE: &str = r#"
name = "short-side"
title = "A metre and a corner, the base on CAN"
devices = "paper"
steps = [
    { bias_test = { duration_s = 5 } },
    { straight = { distance_m = 1, speed_m_per_s = 0.4 } },
    { turn = { angle_deg = 90, rate_deg_per_s = 30 } },
]

[[measurement]]
name = "straight_stop_error"
doc = "Travelled minus commanded distance, at rest"
quantity = "straight.stop_error"
unit = "m"
check = { all_within = [-0.01, 0.01] }
paper = "none"

[[measurement]]
name = "turn_stop_error"
doc = "Turned minus commanded angle, by the gyro, at rest"
quantity = "turn.stop_error"
unit = "deg"
check = { all_within = [-0.5, 0.5] }
paper = "none"
"#;

/// Tests that need a bus of the kernel.
const TESTS: &str = "--test live -- can::";

pub fn plan(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("plan.toml");
    std::fs::write(&path, text).unwrap();
    path
}

fn drives_on(bus: &str, kinds: &str, controller: &str) {
    let (folder, out) = out("side");
    let plan = plan(folder.path(), SIDE);
    let plan = plan.to_str().unwrap();
    let arguments = [
        "run",
        plan,
        "--clock",
        "real",
        "--bus",
        bus,
        "--controller",
        controller,
        "--record",
        "full",
    ];
    let output = run(&arguments, &out);
    assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
    let summary = summary(&out);
    assert_eq!((&summary["outcome"], &summary["bus"]), (&"passed".into(), &kinds.into()));
    let base = summary["ports"].as_array().unwrap().iter().find(|port| port["role"] == "base");
    let counters = &base.unwrap()["counters"];
    assert!(counters["frames_in"].as_u64().unwrap() > 20, "{counters}");
    assert!(counters["frames_out"].as_u64().unwrap() > 100, "{counters}");
    let record = record(&out);
    for (by, id) in [("controller", "101"), ("base", "181")] {
        let kept = |line: &str| line.contains(by) && line.contains(id) && line.contains("frame");
        assert!(record.lines().any(kept), "no frame {id} of the {by} in the record");
    }
}

#[test]
fn an_adapter_on_a_pty_with_the_controller_in_the_process() {
    in_time(|| {
        drives_on("slcan", "pty+slcan-pty", "in-process");
    });
}

#[test]
fn an_adapter_on_a_pty_with_the_controller_as_a_process() {
    in_time(|| {
        drives_on("slcan", "pty+slcan-pty", "process");
    });
}

#[test]
fn a_bus_of_the_kernel_is_struck() {
    in_time(|| {
        if let Some(_bus) = Vcan0::take(TESTS) {
            crate::faults::bus_is_struck("vcan");
        }
    });
}

#[test]
fn a_virtual_interface_with_the_controller_in_the_process() {
    in_time(|| {
        if let Some(_bus) = Vcan0::take(TESTS) {
            drives_on("vcan", "pty+can", "in-process");
        }
    });
}

#[test]
fn a_virtual_interface_with_the_controller_as_a_process() {
    in_time(|| {
        if let Some(_bus) = Vcan0::take(TESTS) {
            drives_on("vcan", "pty+can", "process");
        }
    });
}

#[test]
fn a_machine_without_that_interface_is_told_what_to_do() {
    let (folder, out) = out("none");
    let plan = plan(folder.path(), SIDE);
    let bench = folder.path().join("bench.toml");
    std::fs::write(&bench, "[base]\nport = \"can:hilnone\"\nemulated = true\n").unwrap();
    let arguments =
        ["run", plan.to_str().unwrap(), "--clock", "real", "--bench", bench.to_str().unwrap()];
    let output = run(&arguments, &out);
    assert_eq!(output.status.code(), Some(3), "{}", shown(&output));
    assert!(shown(&output).contains("the CAN interface hilnone"), "{}", shown(&output));
}

/// Runs the plan on vcan0; `disturb` runs once the bus is in use.
fn disturbed(controller: &str, disturb: &str) -> (serde_json::Value, String) {
    let (folder, out) = out("disturbed");
    let plan = plan(folder.path(), SIDE);
    let mut run = hil();
    run.args(["run", plan.to_str().unwrap(), "--clock", "real", "--bus", "vcan", "--quiet"]);
    run.args(["--controller", controller, "--out"]).arg(&out);
    let mut child = run.spawn().unwrap();
    // The first frame shows that the run is under way.
    let first = Command::new("candump").args(["-n", "1", "-T", "60000", "vcan0"]).status().unwrap();
    assert!(first.success());
    let disturbed = Command::new("bash").args(["-c", disturb]).status().unwrap();
    assert!(disturbed.success(), "{disturb}");
    let status = child.wait().unwrap();
    let summary = summary(&out);
    assert_ne!((status.code(), summary["reason"].is_null()), (Some(3), true));
    (summary, record(&out))
}

#[test]
fn a_second_base_on_the_bus_is_told_from_ours() {
    in_time(|| {
        let Some(_bus) = Vcan0::take(TESTS) else { return };
        let (summary, record) = disturbed("in-process", "cansend vcan0 181#0000000000000000");
        let reason = summary["reason"].as_str().unwrap();
        assert_eq!(summary["outcome"], "error", "{reason}");
        assert!(
            reason.contains("another node on can:vcan0") && reason.contains("0x181"),
            "{reason}"
        );
        assert!(record.contains("another node on can:vcan0"), "no note of it");
    });
}

/// Unrelated frames at full speed: any outcome has a name and is recorded.
#[test]
fn a_flooded_bus_has_a_named_outcome() {
    in_time(|| {
        let Some(_bus) = Vcan0::take(TESTS) else { return };
        let (summary, _) =
            disturbed("in-process", "timeout 4 cangen vcan0 -g 0 -I 7FF -L 8 -i; true");
        let base = summary["ports"].as_array().unwrap().iter().find(|port| port["role"] == "base");
        let frames = base.unwrap()["counters"]["frames_in"].as_u64().unwrap();
        assert!(frames > 100, "{summary}");
        // A controller that withstands it passes; one that does not is not to blame.
        let reason = summary["reason"].as_str().unwrap_or_default();
        let named =
            reason.contains("can:vcan0 was flooded") || reason.contains("did not keep real time");
        let outcome = &summary["outcome"];
        assert!(outcome == "passed" || (outcome == "error" && named), "{summary}");
    });
}
