//! Programs on serial lines: each runs several times, and sends the same at the same nanosecond.

use crate::common::{c, compiled, example, gyro, python_with, same_each_time, source, text};
use lockstep::Program;
use wire::serial::SerialSettings;

#[test]
fn a_controller_in_c_with_poll() {
    let path = c("poll.c");
    let words = [path.as_str(), "/dev/ttyHIL0", "/dev/ttyHIL1"];
    let program = || Program::new(words).serial("/dev/ttyHIL0").serial("/dev/ttyHIL1");
    let events = same_each_time(3, 400, &[gyro(0)], program);
    assert_eq!(events.len(), 400 * 50);
    let text = text(&events, 1);
    // At each instant it has all samples up to then; the last one is reported at the instant at which it arrives.
    assert!(text.starts_with("1 1 0.0092 20000000\n"), "{text:.40}");
    assert!(text.contains("\n20000 "), "the end is told");
}

/// Two serial lines: a gyro, and a base.
fn two(words: &[&str]) -> Program {
    let ports = ["/dev/ttyHIL0", "/dev/ttyHIL1"];
    let words = words.iter().copied().chain(ports);
    Program::new(words).serial(ports[0]).serial(ports[1]).env("PYTHONHASHSEED", "0")
}

#[test]
fn threads_and_a_condition_variable_in_cpp() {
    let path = compiled("g++", "condition.cpp", &["-std=c++17"]);
    let events = same_each_time(3, 50, &[gyro(0)], || two(&[&path]));
    let text = text(&events, 1);
    // First 35 ms without ten samples, then at the tenth.
    assert!(text.starts_with("0 late 3 0.0"), "{text:.60}");
    assert!(text.contains(" told "), "{text:.600}");
}

#[test]
fn threads_of_rust() {
    let path = example("rust_threads");
    let events = same_each_time(3, 50, &[gyro(0)], || two(&[&path]));
    let text = text(&events, 1);
    assert!(text.starts_with("0.0000 1 1 11500000\n0.0092 1 1 13500000\n"), "{text:.80}");
}

#[test]
fn tokio_on_two_threads() {
    let path = example("rust_tokio");
    let events = same_each_time(3, 50, &[gyro(0)], || two(&[&path]));
    let text = text(&events, 1);
    assert!(text.starts_with("0.0000 "), "{text:.80}");
    assert_eq!(text.lines().count(), 2_001, "a line each 25 ms, and one at first");
}

#[test]
fn pyserial() {
    let Some(python) = python_with("serial") else { return };
    let script = source("reader.py");
    let words = [python.as_str(), script.to_str().unwrap()];
    let events = same_each_time(3, 50, &[gyro(0)], || two(&words));
    let text = text(&events, 1);
    assert!(text.starts_with("2 0.0176 0.020000000\n"), "{text:.80}");
    assert_eq!(text.lines().count(), 2_500, "one for two samples");
}

/// On a line of 10 kBd a byte takes a millisecond.
#[test]
fn what_is_written_leaves_at_the_rate_of_the_line() {
    let run = |path: &str, how: &str| {
        let line = SerialSettings::new_8n1(10_000);
        let words = [path, "/dev/ttyHIL0", "/dev/ttyHIL1", how];
        let program = || Program::new(words).serial_at("/dev/ttyHIL0", line).serial("/dev/ttyHIL1");
        text(&same_each_time(2, 1, &[], program), 1)
    };
    let expected = "nothing 0 at 0, unsent 0\n\
                    written 0 at 0, unsent 8\n\
                    drained 0 at 8000000, unsent 0\n\
                    later 0 at 12500000, unsent 4\n\
                    set 0 at 16000000, unsent 0\n\
                    set at once 0 at 16000000, unsent 4\n\
                    flushed 0 at 20000000, unsent 0\n\
                    request 0 at 28000000, unsent 0\n\
                    interrupted -1 at 30000000, unsent 6\n\
                    restarted 0 at 36000000, unsent 0\n\
                    of another 0 at 44000000, unsent 0\n";
    let (with_shim, with_tracer) = (c("drain.c"), compiled("gcc", "drain.c", &["-static"]));
    for path in [&with_shim, &with_tracer] {
        for how in ["raw", "cooked"] {
            assert_eq!(run(path, how), expected, "{path} {how}");
        }
    }
}

/// `flush` and `out_waiting`, as a master on RS-485 uses them.
#[test]
fn pyserial_waits_until_its_bytes_have_left() {
    let Some(python) = python_with("serial") else { return };
    let script = "import serial, time\n\
                  line = serial.Serial('/dev/ttyHIL0', 9600)\n\
                  say = serial.Serial('/dev/ttyHIL1')\n\
                  start = time.monotonic_ns()\n\
                  def tell(): say.write(b'%d %d\\n' % (time.monotonic_ns() - start, line.out_waiting))\n\
                  line.write(b'12345678'); tell()\n\
                  time.sleep(0.005); tell()\n\
                  line.flush(); tell()";
    let line = SerialSettings::new_8n1(9_600);
    let words = [python.as_str(), "-c", script];
    let program = || Program::new(words).serial_at("/dev/ttyHIL0", line).serial("/dev/ttyHIL1");
    let events = same_each_time(2, 1, &[], program);
    assert_eq!(text(&events, 1), "0 8\n5000000 4\n8333333 0\n");
}

#[test]
fn the_mode_of_rs_485_is_kept() {
    let expected = "first 0: 0 0 0\n\
                    set 0: 15 2 3\n\
                    kept 0: 15 2 3\n\
                    opened again 0: 15 2 3\n\
                    put right 0: 3 2 100\n\
                    off 0: 0 0 0\n\
                    of another 0: 0 0 0\n";
    for path in [c("rs485.c"), compiled("gcc", "rs485.c", &["-static"])] {
        assert_eq!(text(&same_each_time(2, 1, &[], || two(&[&path])), 1), expected, "{path}");
    }
    let Some(python) = python_with("serial.rs485") else { return };
    let script = "import serial, serial.rs485, sys\n\
                  line, say = serial.Serial(sys.argv[1], 9600), serial.Serial(sys.argv[2])\n\
                  line.rs485_mode = serial.rs485.RS485Settings(delay_before_tx=0.002)\n\
                  line.baudrate = 19200\n\
                  line.write(b'sent')\n\
                  say.write(b'as set')";
    let events = same_each_time(2, 1, &[], || two(&[&python, "-c", script]));
    assert_eq!((&*text(&events, 0), &*text(&events, 1)), ("sent", "as set"));
}
