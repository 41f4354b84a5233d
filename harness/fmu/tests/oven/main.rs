//! An oven in C as an FMU, simulated by devices and by FMPy, and FMUs with every kind of mistake.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod faults;
mod fmpy;
mod mistakes;
mod running;

use described::{Description, Device, FileError, Files, Fmu, Steps};
use fmu::Unit;
use fmu::samples;
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;
use wire::time::{Span, Timestamp};

/// A device around the oven of `version`, in `folder/oven.fmu`.
const DEVICE: &str = r#"
name = "oven"
step_s = 0.01
[parameter.room]
value = 18
[parameter.load]
value = 250
[fmu]
file = "oven.fmu"
parameters = { ambient = "room", "load.capacity" = "load", "load.loss" = 2 }
inputs = { power = "if(t >= 0.5, 1000, 400)", enabled = "t < 2" }
outputs = { inside = "temperature", is_hot = "hot", done = "steps" }
[[message]]
name = "Status"
sent_by = "device"
can_id = 0x100
period_s = 0.02
fields = [{ name = "Temperature", type = "f64", unit = "degC" }]
[[message]]
name = "Request"
sent_by = "host"
can_id = 0x200
fields = [{ name = "Power", type = "u16" }]
[signal.Temperature]
expression = "inside"
"#;

struct Beside<'a>(&'a Path);

impl Files for Beside<'_> {
    fn text(&mut self, name: &str) -> Result<String, String> {
        std::fs::read_to_string(self.0.join(name)).map_err(|error| error.to_string())
    }

    fn errors(&mut self, _: &str, _: &str) -> Result<Steps, String> {
        Err("no models here".to_owned())
    }

    fn fmu(&mut self, name: &str) -> Result<Arc<dyn Fmu>, String> {
        Ok(Arc::new(Unit::open(&self.0.join(name))?.0))
    }

    fn differ(&mut self, one: &str, other: &str) -> bool {
        !one.is_empty() && !other.is_empty() && one != other
    }
}

/// A folder with the oven of `version`.
fn folder(version: usize) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    samples::oven(&folder.path().join("oven.fmu"), version, str::to_owned);
    folder
}

fn read(folder: &TempDir, text: &str) -> Result<Arc<Description>, FileError> {
    Description::parse_with("oven.toml", text, &mut Beside(folder.path())).map(Arc::new)
}

fn device(folder: &TempDir, text: &str) -> Device {
    Device::new(read(folder, text).unwrap(), 1)
}

fn at(seconds: f64) -> Timestamp {
    Timestamp::ZERO + Span::from_secs_f64(seconds)
}

/// Runs the device until `until`, and returns what it sends and when.
fn run(device: &mut Device, until: Timestamp) -> Vec<(Timestamp, Vec<u8>)> {
    let mut sent = Vec::new();
    loop {
        while let Some(what) = device.transmit() {
            if let wire::device::Transmit::Frame(frame) = what {
                sent.push((device.next_wakeup(), frame.data().to_vec()));
            }
        }
        let next = device.next_wakeup();
        if next > until {
            return sent;
        }
        device.wake(next);
        if let Some(why) = device.failure(next) {
            panic!("{why}");
        }
    }
}
