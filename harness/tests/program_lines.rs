//! A program in virtual time on a serial line of a rig: what it asks of its port is what the line does.

#![cfg(feature = "programs")]

use harness::Trial;
use record::outcome::Outcome;
use std::fs;

const SENSOR: &str = r#"
name = "sensor"
title = "It sends ten readings a second, and is set"
[serial]
baud = 4800
parity = "even"
[[message]]
name = "Set"
sent_by = "host"
start = [0x55]
fields = [{ name = "To", type = "u8" }]
initial = { To = 0 }
[[message]]
name = "Reading"
sent_by = "device"
start = [0x56]
fields = [{ name = "At", type = "u8" }]
period_s = 0.1
[signal.At]
expression = "Set.To"
"#;

/// Sets the sensor to how long its last request took to leave, in tenths of a millisecond.
const MASTER: &str = r#"
import os, sys, termios, time

port = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
settings = termios.tcgetattr(port)
settings[2] = termios.CS8 | termios.PARENB | termios.CLOCAL | termios.CREAD
settings[4] = settings[5] = termios.B4800
termios.tcsetattr(port, termios.TCSANOW, settings)
took = 0.0
while True:
    start = time.monotonic()
    os.write(port, bytes([0x55, round(took * 10_000)]))
    termios.tcdrain(port)
    took = time.monotonic() - start
    time.sleep(0.2)
"#;

const RIG: &str = r#"
title = "A sensor and its program"
[[line]]
name = "uart"
serial = {}
[[node]]
name = "sensor"
at = "uart"
emulate = "sensor"
[[node]]
name = "master"
at = "uart"
under_test = { command = ["python3", "MASTER", "{uart}"] }
"#;

/// Two bytes of eleven bits at 4800 Bd take 4.58 ms.
const PLAN: &str = r#"
name = "sets"
title = "The program sets the sensor"
rig = "sets"
steps = [{ wait = { duration_s = 1 } }, { wait = { duration_s = 2 }, label = "on" }]
[[measurement]]
name = "took"
doc = "How long tcdrain took"
quantity = "sensor.At"
unit = "1"
where = { "during.on" = 1 }
check = { all_within = [46, 46] }
observations_min = 10
"#;

#[test]
fn a_request_has_left_after_the_time_that_the_line_takes() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::create_dir(path("rigs")).unwrap();
    fs::create_dir(path("devices")).unwrap();
    fs::write(path("devices/sensor.toml"), SENSOR).unwrap();
    fs::write(path("master.py"), MASTER).unwrap();
    fs::write(path("rigs/sets.toml"), RIG.replace("MASTER", &path("master.py"))).unwrap();
    fs::write(path("plan.toml"), PLAN).unwrap();
    let run = Trial::load(&path("plan.toml")).unwrap().run().unwrap();
    assert_eq!(run.summary().outcome, Outcome::Passed, "{run}");
}
