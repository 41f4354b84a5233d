//! A described device as an FMU: FMPy and our own import get the numbers of the device itself.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use described::{Description, Device, Files, Fmu, Outbox, Sender, Steps};
use fmu_device::{DEVICE, IDENTIFIER, LIBRARY, Version, model_description, packed};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, OnceLock};
use tempfile::TempDir;
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

const TEXT: &str = r#"
name = "oven"
title = "Oven <\"A&B\">"
[parameter.ambient]
value = 20
unit = "degC"
maximum = 50
[table.curve]
csv = "data/curve.csv"
[state.temperature]
start = "ambient"
rate = "(Power * curve(Gain) - (temperature - ambient)) / 30"
[signal.Temperature]
expression = "temperature"
noise = 0.2
[signal.Power2]
expression = "Command.Power"
[[message]]
name = "Status"
sent_by = "device"
can_id = 0x100
period_s = 0.1
counter = { signal = "Alive" }
fields = [{ name = "Temperature", type = "f32", unit = "degC" }, { name = "Power2", type = "u8", unit = "W" }, { name = "Alive", type = "u8" }]
[[message]]
name = "Command"
sent_by = "host"
can_id = 0x200
timeout_s = 0.5
initial = { Power = 10 }
counter = { signal = "Count" }
fields = [{ name = "Power", type = "u8", unit = "W" }, { name = "Count", type = "u8" }]
[[message]]
name = "Tune"
sent_by = "host"
can_id = 0x201
fields = [{ name = "Gain", type = "u8", scale = 0.01 }]
"#;

const CURVE: &str = "x,y\n0,1\n2,3\n";

struct Beside(PathBuf);

impl Files for Beside {
    fn text(&mut self, name: &str) -> Result<String, String> {
        if name == "data/curve.csv" { Ok(CURVE.to_owned()) } else { Err("no such file".to_owned()) }
    }

    fn errors(&mut self, _: &str, _: &str) -> Result<Steps, String> {
        Err("no models here".to_owned())
    }

    fn fmu(&mut self, name: &str) -> Result<Arc<dyn Fmu>, String> {
        Ok(Arc::new(fmu::Unit::open(&self.0.join(name))?.0))
    }
}

fn described(text: &str, folder: &Path) -> Arc<Description> {
    let mut files = Beside(folder.to_owned());
    Arc::new(Description::parse_with("oven.toml", text, &mut files).unwrap())
}

/// The library without its symbols: with them it takes seconds to pack.
fn code() -> &'static [u8] {
    static CODE: OnceLock<Vec<u8>> = OnceLock::new();
    CODE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let stripped = folder.path().join(LIBRARY);
        let whole = std::env::current_exe().unwrap().with_file_name(LIBRARY);
        let done = Command::new("strip").arg(&whole).arg("-o").arg(&stripped).status();
        let is_done = done.is_ok_and(|status| status.success());
        std::fs::read(if is_done { stripped } else { whole }).unwrap()
    })
}

/// A folder with the device as `oven.fmu`.
fn exported(version: Version) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let description = described(TEXT, folder.path());
    let xml = model_description(&description, version, "{1234}");
    let code = code();
    let files = [
        ("modelDescription.xml", xml.as_bytes()),
        (&fmu::library_path(version == Version::Three, IDENTIFIER), code),
        (&format!("resources/{DEVICE}"), TEXT.as_bytes()),
        (&format!("resources/{}", packed("data/curve.csv")), CURVE.as_bytes()),
    ];
    fmu::write(&folder.path().join("oven.fmu"), files).unwrap();
    folder
}

const VERSIONS: [Version; 2] = [Version::Two, Version::Three];

/// When the host sends `Command` with this power, and `Tune` with this gain.
const SENT: [(f64, f64, f64); 3] = [(0.0, 100.0, 0.0), (0.56, 100.0, 1.5), (1.16, 30.0, 1.5)];

fn at(seconds: f64) -> Timestamp {
    Timestamp::ZERO + Span::from_secs_f64(seconds)
}

/// Temperature, power and counter as the device says them at each tenth of a second, from the device alone.
fn expected(seed: u64, ticks: u32) -> Vec<[f64; 3]> {
    let description = described(TEXT, Path::new(""));
    let mut device = Device::new(Arc::clone(&description), seed);
    let layout = description.layout();
    let (mut host, mut decoder) =
        (Outbox::new(layout.clone(), Sender::Host, 9), layout.decoder_for(Sender::Device));
    let (mut rows, mut row, mut gain) = (Vec::new(), [20.0, 10.0, 0.0], 0.0);
    for tick in 0..=ticks {
        let now = at(f64::from(tick) * 0.1);
        let until = |device: &mut Device, end: Timestamp| {
            while device.next_wakeup() <= end {
                device.wake(device.next_wakeup());
            }
        };
        until(&mut device, now);
        while let Some(Transmit::Frame(frame)) = device.transmit() {
            let said = decoder.frame(&frame).unwrap();
            row = [0, 1, 2].map(|place| said.values[place].unwrap());
        }
        rows.push(row);
        // The command comes in each step, since the device would miss it; the other one when it changes.
        let (_, power, wanted) = SENT.iter().rev().find(|(from, ..)| at(*from) <= now).unwrap();
        host.send(now, 1, &[*power, 0.0], |_| false).unwrap();
        if *wanted != gain {
            gain = *wanted;
            host.send(now, 2, &[gain], |_| false).unwrap();
        }
        while let Some(Transmit::Frame(frame)) = host.transmit() {
            device.receive_frame(now, &frame);
        }
    }
    rows
}

fn python() -> Option<String> {
    let python = std::env::var("HIL_TESTS_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let loaded = Command::new(&python).args(["-c", "import fmpy"]).output();
    if loaded.is_ok_and(|loaded| loaded.status.success()) {
        return Some(python);
    }
    let why = format!("{python} has no fmpy");
    let how = "tests/interop/README.md says how to install it";
    skips::skip_unless("HIL_TESTS_NEED_PYTHON", why, how);
    None
}

fn script(python: &str, name: &str, arguments: &[&str]) -> String {
    let script = format!("{}/../../tests/interop/{name}", env!("CARGO_MANIFEST_DIR"));
    let told = Command::new(python).arg(script).args(arguments).output().unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    String::from_utf8(told.stdout).unwrap()
}

#[test]
fn fmpy_finds_nothing_wrong_and_gets_the_numbers_of_the_device() {
    let Some(python) = python() else { return };
    for version in VERSIONS {
        let folder = exported(version);
        let unit = folder.path().join("oven.fmu").display().to_string();
        let problems = script(&python, "fmu_rows.py", &["--validate", &unit]);
        assert_eq!(problems.trim(), "", "{version:?}");
        let inputs = folder.path().join("inputs.csv");
        // FMPy makes a step of its own to each change between two of the others.
        let rows = SENT.map(|(from, power, gain)| (format!("{from:.1}"), power, gain));
        let rows = rows.map(|(from, power, gain)| format!("{from},{power},{gain}\n")).concat();
        std::fs::write(&inputs, format!("time,Command.Power,Tune.Gain\n{rows}")).unwrap();
        let names = "Status.Temperature,Status.Power2,Status.Alive";
        let inputs = inputs.display().to_string();
        let arguments = [unit.as_str(), "0.1", "2.5", names, &inputs, "hil.seed=7"];
        let told = script(&python, "fmu_rows.py", &arguments);
        let theirs: Vec<Vec<f64>> = told
            .lines()
            .map(|line| line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect())
            .collect();
        assert_eq!(theirs.len(), 26);
        for (theirs, ours) in theirs.iter().zip(expected(7, 25)).skip(1) {
            assert_eq!(*theirs, ours, "{version:?}");
        }
    }
}

#[test]
fn fmpy_goes_back_to_a_state_and_to_the_beginning() {
    let Some(python) = python() else { return };
    for version in VERSIONS {
        let folder = exported(version);
        let unit = folder.path().join("oven.fmu").display().to_string();
        let told = script(&python, "fmu_state.py", &[&unit, "Status.Temperature"]);
        let told: Vec<&str> = told.lines().collect();
        assert_eq!(told.len(), 12);
        assert_ne!(told[..3], told[3..6]);
        assert_eq!(told[3..6], told[6..9]);
        assert_eq!(told[..3], told[9..]);
    }
}

/// A device whose physics is the exported one.
const AGAIN: &str = r#"
name = "again"
[parameter.seed]
value = 7
[parameter.room]
value = 20
[fmu]
file = "oven.fmu"
step_s = 0.1
parameters = { "hil.seed" = "seed", ambient = "room" }
inputs = { "Command.Power" = "if(t < 1.16, 100, 30)", "Tune.Gain" = "if(t < 0.56, 0, 1.5)" }
outputs = { temperature = "Status.Temperature", power = "Status.Power2", alive = "Status.Alive" }
[[message]]
name = "None"
sent_by = "host"
can_id = 1
"#;

#[test]
fn imported_again_it_is_the_device() {
    for version in VERSIONS {
        let folder = exported(version);
        let description = described(AGAIN, folder.path());
        assert_eq!(description.unit("temperature"), Some("degC"));
        let mut device = Device::new(description, 1);
        for (tick, expected) in expected(7, 25).iter().enumerate().skip(1) {
            device.wake(at(tick as f64 * 0.1));
            assert_eq!(device.failure(at(0.0)), None);
            let found = ["temperature", "power", "alive"].map(|name| device.value(name).unwrap());
            assert_eq!(found, *expected, "{version:?}, {tick}");
        }
    }
}

#[test]
fn a_parameter_changes_in_a_run_and_has_its_range() {
    let folder = exported(Version::Three);
    let xml = model_description(&described(TEXT, folder.path()), Version::Two, "{1234}");
    assert!(xml.contains("start=\"20\" max=\"50\" unit=\"degC\""), "{xml}");
    let description = described(AGAIN, folder.path());
    let mut device = Device::new(Arc::clone(&description), 1);
    let mut other = Device::new(description, 1);
    device.wake(at(1.0));
    other.wake(at(1.0));
    assert_eq!(device.value("temperature"), other.value("temperature"));
    assert!(device.set_parameter(at(1.0), "room", 50.0));
    device.wake(at(2.0));
    other.wake(at(2.0));
    let [warm, cool] = [&device, &other].map(|device| device.value("temperature").unwrap());
    assert!((0.2..3.0).contains(&(warm - cool)), "{warm} {cool}");
    assert!(device.set_parameter(at(2.0), "room", 51.0));
    device.wake(at(3.0));
    let why = device.failure(at(3.0)).unwrap();
    assert!(why.contains("Error: `ambient` cannot be 51 degC: it is at most 50 degC"), "{why}");
}
