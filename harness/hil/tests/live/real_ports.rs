//! Real devices of a rig: the harness has their ports, and a run does not pass over what was lost there.

use crate::{hil, out, summary};
use ports::FrameEvent;
use ports::pty::PtyPort;
use ports::slcan::SlcanAdapter;
use serde_json::Value;
use skips::in_time;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::Duration;
use tempfile::TempDir;
use wire::can::{CanFrame, StandardId};
use wire::time::Timestamp;

/// Time limit of a run. The machine may be busy with other work.
const LIMIT: Duration = Duration::from_secs(60);
const TURN: Duration = Duration::from_millis(50);
/// To the end of the run.
const ALL: u32 = u32::MAX;
/// Of a run that is not about lateness, ms.
const PATIENT: u32 = 5_000;

const DRIVE: &str = r#"
name = "drive"
title = "A drive"
[serial]
baud = 115200
[[message]]
name = "Set"
sent_by = "host"
text = "SET {Sp:.0}\n"
fields = [{ name = "Sp", unit = "rpm" }]
[[message]]
name = "Status"
sent_by = "device"
text = "ST {Speed:.1}\n"
period_s = 0.05
fields = [{ name = "Speed", unit = "rpm" }]
[signal.Speed]
expression = "Set.Sp"
"#;

const CHARGER: &str = r#"
name = "charger"
title = "A charger"
[[message]]
name = "Status"
sent_by = "device"
can_id = 0x200
period_s = 0.05
fields = [{ name = "Amps", type = "u8", unit = "A" }]
[[message]]
name = "Set"
sent_by = "host"
can_id = 0x300
fields = [{ name = "Sp", type = "u8", unit = "A" }]
[signal.Amps]
expression = "Set.Sp"
"#;

/// The plan of properties alone sends ten requests a second.
fn project(folder: &Path, device: &str, line: &str, always: &str) -> PathBuf {
    let rig = format!(
        r#"
        [[line]]
        name = "line"
        {line}
        [[node]]
        name = "d"
        at = "line"
        under_test = {{ attached = true }}
        described_by = "device"
        [[node]]
        name = "tester"
        at = "line"
        tester = true
        "#
    );
    let plan = format!(
        r#"
        name = "plan"
        title = "Requests"
        rig = "real"
        steps = [
            {{ send = {{ message = "Set", set = {{ Sp = 12 }}, every_s = 0.1 }} }},
            {{ wait = {{ duration_s = 4 }} }},
        ]
        [[property]]
        name = "slow"
        always = "{always}"
        "#
    );
    for (path, text) in
        [("devices/device.toml", device), ("rigs/real.toml", &rig), ("plan.toml", &plan)]
    {
        let path = folder.join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    folder.join("plan.toml")
}

/// A run, with a real device at the path of a port.
pub struct Bench {
    pub folder: TempDir,
    pub out: PathBuf,
    link: PathBuf,
    plan: PathBuf,
}

impl Bench {
    fn with_a_drive(late_ms_max: u32) -> Self {
        let (folder, out) = out("run");
        let plan = project(folder.path(), DRIVE, "serial = {}", "d.Speed < 100 rpm");
        Self::at("serial", late_ms_max, (folder, out), plan)
    }

    pub fn with_a_charger() -> Self {
        let (folder, out) = out("run");
        let line = "can = { bit_rate = 250_000 }";
        let plan = project(folder.path(), CHARGER, line, "d.Amps < 100 A");
        Self::at("slcan", PATIENT, (folder, out), plan)
    }

    fn at(kind: &str, late_ms_max: u32, (folder, out): (TempDir, PathBuf), plan: PathBuf) -> Self {
        let link = folder.path().join("tty");
        let bench = format!(
            "[line.line]\nport = \"{kind}:{}\"\n[timing]\nlate_ms_max = {late_ms_max}\n",
            link.display()
        );
        std::fs::write(folder.path().join("bench.toml"), bench).unwrap();
        Self { folder, out, link, plan }
    }

    /// The device is emulated, unless the bench file says that it is real.
    pub fn emulates_in_its_rig_file(&self) {
        let rig = self.folder.path().join("rigs/real.toml");
        let text = std::fs::read_to_string(&rig).unwrap();
        let emulated =
            text.replace("under_test = { attached = true }", "").replace("described_by", "emulate");
        std::fs::write(&rig, emulated).unwrap();
    }

    pub fn command(&self) -> Command {
        let mut run = hil();
        run.arg("run").arg(&self.plan).args(["--clock", "real", "--quiet", "--bench"]);
        run.arg(self.folder.path().join("bench.toml")).arg("--out").arg(&self.out);
        run
    }

    fn start(&self) -> Child {
        self.command().spawn().unwrap()
    }

    fn drive(&self) -> PtyPort {
        PtyPort::open(Some(&self.link)).unwrap()
    }

    fn adapter(&self) -> SlcanAdapter {
        SlcanAdapter::open(Some(&self.link)).unwrap()
    }

    /// A run with an adapter behind which `turn` plays the device.
    pub fn served(&self, turn: impl AsyncFn(&mut SlcanAdapter)) -> Child {
        block_on(async {
            let mut port = self.adapter();
            let mut child = self.start();
            serve(&mut child, ALL, &mut port, turn).await;
            child
        })
    }

    /// The summary of a run that ended as an error of the bench, and its reason.
    fn broke(&self, child: &mut Child) -> (Value, String) {
        let status = child.wait().unwrap().code();
        let summary = summary(&self.out);
        assert_eq!((status, &summary["outcome"]), (Some(3), &"error".into()), "{summary}");
        let reason = summary["reason"].as_str().unwrap().to_owned();
        (summary, reason)
    }
}

fn block_on<T>(test: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async { tokio::time::timeout(LIMIT, test).await.expect("the run ends") })
}

/// Serves a device for so many turns, or until the run has ended.
async fn serve<P>(child: &mut Child, turns: u32, port: &mut P, turn: impl AsyncFn(&mut P)) {
    for _ in 0..turns {
        if child.try_wait().unwrap().is_some() {
            return;
        }
        let _ = tokio::time::timeout(TURN, turn(port)).await;
    }
}

/// Says how fast it is, and hears what comes until the turn is over.
async fn drives(port: &mut PtyPort) {
    port.send(b"ST 12.0\n");
    while port.receive().await.is_ok() {}
}

pub async fn charges(adapter: &mut SlcanAdapter) {
    let status = CanFrame::new(StandardId::new(0x200).unwrap(), &[12]).unwrap();
    adapter.send(Timestamp::ZERO, &status);
    while adapter.receive().await.is_ok() {}
}

/// Found by a user: the device was blamed for requests that it had never got.
#[test]
fn what_was_sent_while_a_port_was_away_is_no_fault_of_the_device() {
    in_time(|| {
        let bench = Bench::with_a_drive(PATIENT);
        let mut child = block_on(async {
            let mut port = bench.drive();
            let mut child = bench.start();
            serve(&mut child, 40, &mut port, drives).await;
            drop(port);
            tokio::time::sleep(Duration::from_secs(1)).await;
            serve(&mut child, ALL, &mut bench.drive(), drives).await;
            child
        });
        let (summary, why) = bench.broke(&mut child);
        assert!(why.contains("was away from") && why.contains("lost meanwhile"), "{why}");
        assert_eq!(summary["notes"][0], why, "{summary}");
        assert_eq!(summary["ports"][0]["counters"]["returns"], 1, "{summary}");
    });
}

/// Found by a user: an adapter that was plugged in again was never opened again.
#[test]
fn an_adapter_that_was_away_is_used_again_and_said_to_have_been_away() {
    in_time(|| {
        let bench = Bench::with_a_charger();
        let (mut child, heard) = block_on(async {
            let mut port = bench.adapter();
            let mut child = bench.start();
            while port.receive().await != Ok(FrameEvent::Up) {}
            serve(&mut child, 20, &mut port, charges).await;
            drop(port);
            tokio::time::sleep(Duration::from_millis(300)).await;
            let mut port = bench.adapter();
            serve(&mut child, ALL, &mut port, charges).await;
            (child, port.counters().frames_in)
        });
        let (summary, why) = bench.broke(&mut child);
        assert!(why.contains("was away from"), "{why}");
        assert!(heard > 3, "{heard} requests after it came back");
        assert_eq!(summary["ports"][0]["counters"]["returns"], 1, "{summary}");
    });
}

/// Found by a user: the bench file named the port of a line whose device was still emulated, and the run said nothing of the
/// real one.
#[test]
fn a_real_device_beside_its_emulation_is_noted() {
    in_time(|| {
        let bench = Bench::with_a_charger();
        bench.emulates_in_its_rig_file();
        let mut child = bench.served(charges);
        assert_eq!(child.wait().unwrap().code(), Some(0));
        let notes = summary(&bench.out)["notes"].to_string();
        assert!(
            notes.contains("with the identifier 0x200 of d, which this run sends itself"),
            "{notes}"
        );
    });
}

/// It counts there: a bus does not tell who sent a frame.
#[test]
fn a_frame_of_an_emulated_node_beside_a_real_one_is_noted_once() {
    in_time(|| {
        let bench = Bench::with_a_charger();
        let within = |path: &str| bench.folder.path().join(path);
        let rig = std::fs::read_to_string(within("rigs/real.toml")).unwrap();
        let node = "[[node]]\nname = \"e\"\nat = \"line\"\nemulate = \"other\"\n";
        std::fs::write(within("rigs/real.toml"), format!("{rig}\n{node}")).unwrap();
        let other = CHARGER.replace("0x300", "0x301").replace("Set", "Order");
        std::fs::write(within("devices/other.toml"), other).unwrap();
        let ours = CHARGER.replace("0x200", "0x201");
        std::fs::write(within("devices/device.toml"), ours).unwrap();
        let mut child = bench.served(charges);
        child.wait().unwrap();
        let notes = summary(&bench.out)["notes"].to_string();
        assert_eq!(notes.matches("with the identifier 0x200 of e").count(), 1, "{notes}");
        assert!(!notes.contains("sends itself"), "{notes}");
    });
}

/// An adapter that answers each line with what `answer` says to its first letter.
fn adapter_that(answer: impl Fn(u8) -> &'static [u8]) -> (Bench, Value, String) {
    let bench = Bench::with_a_charger();
    let mut child = block_on(async {
        let mut port = bench.drive();
        let mut child = bench.start();
        serve(&mut child, ALL, &mut port, async |port: &mut PtyPort| {
            while let Ok(heard) = port.receive().await {
                for line in heard.as_slice().split(|byte| *byte == b'\r') {
                    line.first().map(|first| port.send(answer(*first)));
                }
            }
        })
        .await;
        child
    });
    let (summary, why) = bench.broke(&mut child);
    (bench, summary, why)
}

/// Found by a user: frames that an adapter refused counted as sent, and a lost line was told by a counter alone.
#[test]
fn frames_that_an_adapter_refuses_are_no_fault_of_the_device() {
    in_time(|| {
        let (_, summary, why) = adapter_that(|first| match first {
            b't' => b"\x07rubbish\r",
            _ => b"\r",
        });
        assert!(why.contains("the adapter at the line's port slcan:"), "{why}");
        assert!(why.contains("refused") && why.contains("frames"), "{why}");
        let notes = [0, 1].map(|place| summary["notes"][place].as_str().unwrap());
        assert!(why.starts_with(notes[0]), "{notes:?}");
        assert!(notes[1].contains("did not follow the SLCAN protocol"), "{notes:?}");
    });
}

#[test]
fn a_dead_adapter_is_no_fault_of_the_device() {
    in_time(|| {
        let (_, _, why) = adapter_that(|_| b"");
        assert!(why.contains("has never answered"), "{why}");
    });
}

/// Found by a user: a plan of properties alone passed, although the harness had been stopped meanwhile and had heard
/// at one time what was said in seconds.
#[test]
fn properties_are_not_judged_by_a_harness_that_was_stopped() {
    let bench = Bench::with_a_drive(100);
    let mut child = block_on(async {
        let mut port = bench.drive();
        let mut child = bench.start();
        serve(&mut child, 40, &mut port, drives).await;
        let signal = |name: &str| {
            let id = child.id().to_string();
            assert!(Command::new("kill").args([name, id.as_str()]).status().unwrap().success());
        };
        signal("-STOP");
        tokio::time::sleep(Duration::from_millis(500)).await;
        signal("-CONT");
        serve(&mut child, ALL, &mut port, drives).await;
        child
    });
    let (summary, why) = bench.broke(&mut child);
    assert!(why.contains("did not keep real time") && why.contains("judged"), "{why}");
    assert_ne!(summary["timing"]["misses_judged"], 0);
}
