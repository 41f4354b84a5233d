//! A run on an interface that is down for a second: it is waited for, counted and judged by what it did to the traffic.

use super::link::Link;
use super::run;
use std::process::{Command, Stdio};
use std::time::Duration;

const PLAN: &str = r#"
name = "talks"
title = "It talks"
device = "oven"
steps = [{ do = "where" }, { wait = { duration_s = 5 } }]
[[measurement]]
name = "status_period"
doc = "Time between two Status messages, of 0.1 s: a second of the five is lost, and what the bus takes to return"
quantity = "period.Status"
unit = "1"
check = { share_within = { share = 0.5, band = [0, 0.5] } }
observations_min = 20
"#;

fn hil(arguments: &[&str], folder: &std::path::Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
    command.args(arguments).current_dir(folder).stdout(Stdio::null()).stdin(Stdio::null());
    command
}

#[test]
fn a_second_without_the_bus_is_waited_for_and_told() {
    run(async {
        let Some(link) = Link::make("hilgone").await else { return };
        let folder = tempfile::tempdir().unwrap();
        assert!(hil(&["new", "oven"], folder.path()).status().unwrap().success());
        let oven = folder.path().join("oven");
        std::fs::write(oven.join("talks.toml"), PLAN).unwrap();
        let bench = "[device]\nport = \"can:hilgone\"\n\
                     [command.where]\nrun = [\"sh\", \"-c\", 'echo \"$HIL_LINES\"']\n";
        std::fs::write(oven.join("bench.toml"), bench).unwrap();
        let emulate = ["emulate", "device", "devices/oven.toml", "--port", "can:hilgone"];
        let mut emulator = hil(&emulate, &oven).spawn().unwrap();
        let bench =
            ["run", "talks.toml", "--clock", "real", "--bench", "bench.toml", "--out", "run"];
        let mut ran = hil(&bench, &oven).spawn().unwrap();
        tokio::time::sleep(Duration::from_secs(2)).await;
        link.set("down").await.unwrap();
        tokio::time::sleep(Duration::from_secs(1)).await;
        link.set("up").await.unwrap();
        let status = ran.wait().unwrap();
        emulator.kill().unwrap();
        emulator.wait().unwrap();
        // Others can be on the bus too.
        let told = std::fs::read_to_string(oven.join("run/command-where.log")).unwrap();
        assert!(told.contains(r#"{"device":{"port":"can:hilgone","bit_rate":500000}}"#), "{told}");
        let summary = std::fs::read(oven.join("run/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
        assert_eq!((status.code(), &summary["outcome"]), (Some(0), &"passed".into()), "{summary}");
        let port = &summary["ports"][0];
        assert_eq!((&port["lost"], &port["counters"]["returns"]), (&1.into(), &1.into()), "{port}");
        // The message after the gap came late.
        let share = summary["measurements"][0]["value"].as_f64().unwrap();
        assert!(share < 1.0, "{summary}");
    });
}
