//! What a program in virtual time asks of its serial port is what the line does. Set otherwise than its line, what it sends would
//! be noise on a real one, so the run says nothing.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::TrialRun;
use record::outcome::Outcome;
use tests::project;

const SENSOR: &str = r#"
name = "sensor"
title = "It sends ten readings a second, and is set"
[serial]
baud = 19200
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
name = "program"
at = "uart"
under_test = { command = ['python3', '-c', '''HOST''', '{uart}'] }
"#;

const PLAN: &str = r#"
name = "sets"
title = "The program sets the sensor"
rig = "sets"
steps = [{ wait = { duration_s = 1 } }, { wait = { duration_s = 2 }, label = "on" }]
[[measurement]]
name = "set"
doc = "What the sensor was set to"
quantity = "sensor.At"
unit = "1"
where = { "during.on" = 1 }
check = { all_within = [7, 7] }
observations_min = 10
"#;

/// Runs a program that sets the rate `speed` and these control modes, after `first`.
fn run(speed: &str, modes: &str, first: &str) -> TrialRun {
    let host = format!(
        "import os, sys, termios, time\n\
         port = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)\n\
         {first}\n\
         settings = termios.tcgetattr(port)\n\
         settings[2] = {modes} | termios.CLOCAL | termios.CREAD\n\
         settings[4] = settings[5] = {speed}\n\
         termios.tcsetattr(port, termios.TCSANOW, settings)\n\
         while True:\n    os.write(port, bytes([0x55, 7]))\n    time.sleep(0.2)\n"
    );
    run_on(SENSOR, &host, PLAN)
}

pub fn run_on(sensor: &str, host: &str, plan: &str) -> TrialRun {
    let folder = project::of([
        ("devices/sensor.toml", sensor),
        ("rigs/sets.toml", &RIG.replace("HOST", host)),
        ("plan.toml", plan),
    ]);
    project::load(&folder, "plan.toml").unwrap().run().unwrap()
}

#[test]
fn settings_that_a_line_does_not_carry_end_the_run() {
    for (speed, modes, said) in [
        ("termios.B9600", "termios.CS8", "9600 8N1"),
        ("termios.B19200", "termios.CS8 | termios.PARENB", "19200 8E1"),
        ("termios.B19200", "termios.CS7", "19200 7N1"),
    ] {
        let run = run(speed, modes, "");
        let reason = run.summary().reason.as_deref().unwrap_or_default();
        assert_eq!(run.summary().outcome, Outcome::Error, "{run}");
        let expected = format!(
            "`program` has set its port on the line \"uart\" to {said}, and the line is set to 19200 8N1"
        );
        assert!(reason.starts_with(&expected), "{reason}");
    }
}

#[test]
fn settings_that_it_carries_do_not() {
    // One that only opens its port, one that takes half a second to set it, and one with another stop bit.
    let later = "time.sleep(0.5)";
    for (speed, modes, first) in [
        ("settings[4]", "settings[2]", ""),
        ("termios.B19200", "termios.CS8", later),
        ("termios.B19200", "termios.CS8 | termios.CSTOPB", ""),
    ] {
        let run = run(speed, modes, first);
        assert!(run.passed(), "{modes}: {run}");
    }
}

/// Sets the sensor to how long its last request took to leave, in tenths of a millisecond.
const DRAINS: &str = r#"
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

/// Found by a user: it took no time, so that a master that waited for its answer from then on always gave up. Two bytes of eleven
/// bits at 4800 Bd take 4.58 ms.
#[test]
fn a_request_has_left_after_the_time_that_the_line_takes() {
    let sensor = SENSOR.replace("baud = 19200", "baud = 4800\nparity = \"even\"");
    let run = run_on(&sensor, DRAINS, &PLAN.replace("[7, 7]", "[46, 46]"));
    assert!(run.passed(), "{run}");
}
