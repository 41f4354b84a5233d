//! Ports that appear and disappear in the middle of a run.

use crate::can::plan;
use crate::{hil, out, record, summary};
use ports::slcan::SlcanAdapter;
use ports::{FrameEvent, pty::PtyPort};
use skips::in_time;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::time::Duration;

/// Time limit for another process to respond. The machine may be busy with other work.
const LIMIT: Duration = Duration::from_secs(60);

/// A plan that waits and judges nothing.
fn waiting(devices: &str, seconds: u32) -> String {
    format!(
        r#"
name = "waiting"
title = "Time passes"
devices = "{devices}"
steps = [{{ wait = {{ duration_s = {seconds} }} }}]

[[measurement]]
name = "faults"
doc = "Times that the controller was at fault"
quantity = "health.fault"
unit = "1"
check = {{ all_within = [0, 100] }}
paper = "none"
"#
    )
}

fn start(folder: &Path, out: &PathBuf, plan_text: &str, bench: &str) -> Child {
    start_with("in-process", folder, out, plan_text, bench)
}

fn start_with(
    controller: &str,
    folder: &Path,
    out: &PathBuf,
    plan_text: &str,
    bench: &str,
) -> Child {
    let plan = plan(folder, plan_text);
    let file = folder.join("bench.toml");
    std::fs::write(&file, bench).unwrap();
    let mut run = hil();
    run.args(["run", plan.to_str().unwrap(), "--clock", "real", "--controller", controller]);
    run.arg("--bench").arg(file).arg("--quiet").arg("--out").arg(out);
    run.spawn().unwrap()
}

fn block_on<T>(test: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async { tokio::time::timeout(LIMIT, test).await.expect("it happens") })
}

/// Unplugs the adapter of a real gyro, and plugs it in again if `again` is set.
fn unplugged(controller: &str, again: bool) -> (Option<i32>, serde_json::Value, String) {
    let (folder, out) = out("unplugged");
    let link = folder.path().join("ttyUSB0");
    let port = block_on(async { PtyPort::open(Some(&link)).unwrap() });
    let bench = format!("[gyro]\nport = \"serial:{}\"\n", link.display());
    let plan = waiting("paper-table", 8);
    let mut child = start_with(controller, folder.path(), &out, &plan, &bench);
    let back = block_on(async {
        // The run has opened the port: it begins the record before.
        while !out.join("record.hilrec").is_file() {
            assert_eq!(child.try_wait().unwrap(), None, "the run ended before it began");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        tokio::time::sleep(Duration::from_secs(2)).await;
        drop(port);
        again.then(|| PtyPort::open(Some(&link)).unwrap())
    });
    let status = child.wait().unwrap().code();
    drop(back);
    (status, summary(&out), record(&out))
}

#[test]
fn a_port_that_is_plugged_in_again_is_used_again() {
    in_time(|| {
        let (status, summary, record) = unplugged("in-process", true);
        assert_eq!(status, Some(0), "{summary}");
        assert!(record.contains("is lost: the device was unplugged"), "{record}");
        assert!(record.contains("is back"), "{record}");
        let port = &summary["ports"][0];
        assert_eq!(
            (&port["lost"], &port["counters"]["returns"]),
            (&1.into(), &1.into()),
            "{summary}"
        );
        assert_eq!(
            (&port["role"], &port["side"]),
            (&"gyro".into(), &"controller".into()),
            "{summary}"
        );
    });
}

#[test]
fn a_port_that_never_returns_ends_the_run_by_its_name() {
    in_time(|| {
        let (status, summary, record) = unplugged("in-process", false);
        assert_eq!((status, &summary["outcome"]), (Some(3), &"error".into()), "{summary}");
        let reason = summary["reason"].as_str().unwrap();
        assert!(reason.contains("ttyUSB0") && reason.contains("is lost"), "{reason}");
        assert!(record.contains("is lost"), "{record}");
    });
}

/// The controller has the port alone: the harness sees only that its path leads nowhere.
#[test]
fn a_port_that_only_the_controller_has_ends_the_run_by_its_name_too() {
    in_time(|| {
        let (status, summary, _) = unplugged("process", false);
        assert_eq!((status, &summary["outcome"]), (Some(3), &"error".into()), "{summary}");
        let reason = summary["reason"].as_str().unwrap();
        assert!(reason.contains("ttyUSB0 is gone"), "{reason}");
    });
}

#[test]
fn an_adapter_that_vanishes_ends_the_run_by_its_name() {
    in_time(|| {
        let (folder, out) = out("adapter");
        let link = folder.path().join("ttyACM0");
        let status = block_on(async {
            let mut adapter = SlcanAdapter::open(Some(&link)).unwrap();
            let bench = format!("[base]\nport = \"slcan:{}\"\n", link.display());
            let mut child = start(folder.path(), &out, &waiting("paper", 6), &bench);
            // The controller opens the bus.
            while adapter.receive().await != Ok(FrameEvent::Up) {}
            // Served for a while, as a real adapter would be.
            let _ = tokio::time::timeout(Duration::from_secs(2), async {
                while adapter.receive().await.is_ok() {}
            })
            .await;
            drop(adapter);
            tokio::task::spawn_blocking(move || child.wait().unwrap().code()).await.unwrap()
        });
        let summary = summary(&out);
        assert_eq!((status, &summary["outcome"]), (Some(3), &"error".into()), "{summary}");
        let reason = summary["reason"].as_str().unwrap();
        assert!(reason.contains("ttyACM0") && reason.contains("is lost"), "{reason}");
    });
}
