//! The standard CAN tools: cansend, candump, cangen, canplayer.

use super::rig::{Emulated, GUEST, number, said};
use serde_json::json;
use skips::{Vcan0, in_time};
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

/// MOTION of `wire/dbc/k2a.dbc`, and its status byte with the flags "moving" and "command timed out".
const MOTION: &str = "181";
const STATUS_AT: usize = 6;
const MOVING: u8 = 1;
const TIMED_OUT: u8 = 2;
/// Commands of 0.2 m/s in a log, one period of the host loop apart.
const COMMANDS: u32 = 60;
const COMMAND_PERIOD_US: u32 = 27_000;

/// Returns the status bytes of the MOTION frames in candump's `-L` output.
fn statuses(line: &str) -> Option<u8> {
    let (id, data) = line.split_whitespace().last()?.split_once('#')?;
    let byte = data.get(2 * STATUS_AT..2 * STATUS_AT + 2)?;
    (id == MOTION).then(|| u8::from_str_radix(byte, 16).unwrap())
}

#[test]
fn guest_can_utils_talk_to_the_base() {
    in_time(|| {
        let Some(_bus) = Vcan0::take(GUEST) else { return };
        let interface = Vcan0::NAME;
        let folder = tempfile::tempdir().unwrap();
        let (mut base, ready) = Emulated::start(folder.path(), &["base", "--can", interface]);
        assert_eq!(ready["port"], interface);

        // One velocity, 0.1 m/s; no other follows, and the base stops by itself.
        let mut dump = Command::new("candump")
            .args(["-L", "-T", "20000", interface])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(dump.stdout.take().unwrap()).lines();
        said(Command::new("cansend").args([interface, "101#E8030000"]));
        let (mut moved, mut stopped) = (false, false);
        for status in lines.map_while(Result::ok).filter_map(|line| statuses(&line)) {
            moved |= status & MOVING != 0;
            stopped = moved && status & (MOVING | TIMED_OUT) == TIMED_OUT;
            if stopped {
                break;
            }
        }
        let _ = dump.kill();
        dump.wait().unwrap();
        assert!(moved && stopped, "moved: {moved}, stopped: {stopped}");
        let after_one = number(&base.truth()["base"]["x_m"]);
        assert!((0.01..0.2).contains(&after_one), "{after_one} m");

        // Playback of a recording: 0.2 m/s for 1.6 s.
        let mut log = String::new();
        for number in 0..COMMANDS {
            let us = number * COMMAND_PERIOD_US;
            log +=
                &format!("({}.{:06}) {interface} 101#D0070000\n", us / 1_000_000, us % 1_000_000);
        }
        let path = folder.path().join("drive.log");
        std::fs::write(&path, log).unwrap();
        said(Command::new("canplayer").arg("-I").arg(&path));
        said(Command::new("cansend").args([interface, "104#00"]));
        let after_log = number(&base.truth()["base"]["x_m"]) - after_one;
        assert!((0.1..0.6).contains(&after_log), "{after_log} m");

        // A storm of frames that mean nothing to the base, or something else: it survives and counts them.
        said(
            Command::new("cangen")
                .args([interface, "-g", "0", "-n", "2000", "-I", "7A0", "-L", "8"]),
        );
        said(Command::new("cansend").args([interface, "101#E803"]));
        let counters = base.ask(json!({ "get": "counters" }))["ok"]["base"]["device"].take();
        let ignored = number(&counters["frames_ignored"]);
        assert!(ignored > 0.0, "{counters}");
        said(Command::new("cansend").args([interface, "101#E8030000"]));
        let ended = base.end();
        let seen = number(&ended["ports"]["base"]["frames_in"]);
        assert!(seen >= ignored, "{ended}");
    });
}
