//! Virtual time across the kernel: the same verdicts and the same record as in memory, on every bus.

use crate::hil::{Hil, TURN};
use ports::can_socket::kernel_has_can;
use skips::Vcan0;
use std::fs;

/// Tests that need a bus of the kernel.
const TESTS: &str = "--test cli -- crossing::";

/// Results of a run: every byte and frame, and the summary.
struct Left {
    record: Vec<u8>,
    summary: serde_json::Value,
}

fn run(hil: &Hil, bus: &str) -> Left {
    let arguments = ["run", "turn.toml", "--bus", bus, "--record", "full", "--out", bus];
    hil.run(&arguments).exits(0);
    let summary = fs::read(hil.path(bus).join("summary.json")).unwrap();
    Left {
        record: fs::read(hil.path(bus).join("record.hilrec")).unwrap(),
        summary: serde_json::from_slice(&summary).unwrap(),
    }
}

/// Compares a run of `plan` on this bus with one in memory.
fn compare(plan: &str, bus: &str) {
    let hil = Hil::with_plan(plan);
    let (memory, crossed) = (run(&hil, "memory"), run(&hil, bus));
    assert_eq!(memory.summary["bus"], "memory");
    assert_eq!(crossed.summary["bus"], bus);
    assert_eq!(crossed.summary["clock"], "virtual");
    for part in ["measurements", "simulated_s", "events"] {
        assert_eq!(memory.summary[part], crossed.summary[part], "{part}");
    }
    assert!(memory.record.len() > 10_000, "the gyro alone sends more");
    assert!(memory.record == crossed.record, "the records differ");
}

#[test]
fn a_base_on_a_serial_line_crosses_ptys() {
    compare(&TURN.replace("\"paper\"", "\"paper-serial\""), "pty");
}

#[test]
fn a_base_on_can_crosses_an_adapter() {
    compare(TURN, "slcan");
}

#[test]
fn a_base_on_can_crosses_a_vcan() {
    let Some(_bus) = Vcan0::take(TESTS) else { return };
    compare(TURN, "vcan");
}

#[test]
fn a_frame_of_another_program_is_an_error() {
    use socketcan::{CanSocket, EmbeddedFrame as _, Socket as _, StandardId};
    let Some(_bus) = Vcan0::take(TESTS) else { return };
    let stranger = CanSocket::open("vcan0").unwrap();
    let frame = socketcan::CanFrame::new(StandardId::new(0x7ff).unwrap(), b"stray").unwrap();
    // A plan that lasts until the other program has sent a frame.
    let hil = Hil::with_plan(&TURN.replace("duration_s = 5", "duration_s = 100"));
    let mut child = hil.command(&["run", "turn.toml", "--bus", "vcan"]);
    let child = child.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    let mut child = child.spawn().unwrap();
    while child.try_wait().unwrap().is_none() {
        // A full queue is temporary: keep sending.
        let _ = stranger.write_frame(&frame);
    }
    let ran = crate::hil::Ran::of(child.wait_with_output().unwrap()).exits(3);
    assert!(ran.out.contains("frame 7FF#7374726179 came out"), "{}", ran.out);
}

#[test]
fn a_machine_without_can_says_what_it_lacks() {
    if kernel_has_can().is_ok() {
        skips::skip("this kernel has CAN", "on one without");
        return;
    }
    let hil = Hil::with_plan(TURN);
    let ran = hil.run(&["run", "turn.toml", "--bus", "vcan"]).exits(3);
    assert!(ran.err.contains("this kernel has no CAN sockets"), "{}", ran.err);
    assert!(ran.err.contains("slcan-pty"), "{}", ran.err);
    assert!(!hil.path("runs").exists());
}

/// Found by a user: the run began, and blamed another program; the doctor called the bench good.
#[test]
fn an_adapter_carries_no_can_fd() {
    let hil = Hil::new();
    let files = [
        (
            "devices/fd.toml",
            "name = \"fd\"\ntitle = \"\"\nsource = \"invented\"\n[signal.S]\nexpression = \"1\"\n\
             [[message]]\nname = \"M\"\nsent_by = \"device\"\ncan_id = 0x100\nfd = true\nperiod_s = 0.1\n\
             fields = [{ name = \"S\", type = \"u8\" }]\n",
        ),
        (
            "rigs/fd.toml",
            "[[line]]\nname = \"can0\"\ncan = { bit_rate = 500_000, data_bit_rate = 2_000_000 }\n\
             [[node]]\nname = \"fd\"\nat = \"can0\"\nemulate = \"fd\"\n\
             [[node]]\nname = \"own\"\nat = \"can0\"\nunder_test = { command = [\"true\"] }\n",
        ),
        (
            "fd.toml",
            "name = \"fd\"\ntitle = \"\"\nrig = \"fd\"\nsteps = [{ wait = { duration_s = 1 } }]\n\
             [[measurement]]\nname = \"s\"\ndoc = \"\"\nquantity = \"fd.S\"\nunit = \"1\"\n\
             check = { all_within = [1, 1] }\n",
        ),
        ("slcan.toml", "[line.can0]\nport = \"slcan-pty\"\n"),
    ];
    for (name, text) in files {
        fs::create_dir_all(hil.path(name).parent().unwrap()).unwrap();
        fs::write(hil.path(name), text).unwrap();
    }
    let crossed = hil.run(&["run", "./fd.toml", "--bus", "slcan"]).exits(2);
    assert!(crossed.err.contains("SLCAN carries classic frames"), "{}", crossed.err);
    let seen = hil.run(&["doctor", "./fd.toml", "--bench", "./slcan.toml"]);
    assert!(seen.out.contains("SLCAN carries classic frames"), "{}", seen.out);
    assert!(!seen.out.contains("provides all that the plans need"), "{}", seen.out);
}
