//! A gateway on two buses: what tells the bus of a frame, and a rerun of such a program.

use super::hil::{Hil, Ran};
use skips::in_time;
use std::fs;

const RIG: &str = r#"
title = "A gateway"
[[line]]
name = "pt"
can = { bit_rate = 125_000, dbc = "../pt.dbc" }
message.Busy = { counter = { signal = "Alive", modulo = 200 } }
[[line]]
name = "body"
can = { bit_rate = 125_000, dbc = "../body.dbc" }
[[node]]
name = "gw"
at = ["pt", "body"]
under_test = { command = ["python3", "./gw.py", "{pt}", "{body}"] }
isotp = { request_id = 0x7E0, response_id = 0x7E8 }
[[node]]
name = "tst"
at = "pt"
tester = true
"#;

const DBC: &str = "VERSION \"\"\nBU_: gw tst\nBO_ 528 Load: 1 gw\n SG_ Count : 0|8@1+ (1,0) [0|0] \"\" Vector__XXX\n";

const BUSY: &str = "BO_ 256 Busy: 8 tst\n SG_ Alive : 0|8@1+ (1,0) [0|0] \"\" Vector__XXX\n";

const PLAN: &str = r#"
name = "gateway"
title = "A gateway"
rig = "gateway"
steps = [
    { send = { message = "Busy", every_s = 0.02 } },
    { wait_until = { above = { quantity = "gw.body.Count", limit = 0.5 } } },
    { wait = { duration_s = 1 } },
    { uds = { node = "gw", request = [0x3E, 0] } },
    { wait = { duration_s = 0.5 } },
]
[[measurement]]
name = "count"
doc = "What it counts"
quantity = "gw.body.Count"
unit = "1"
check = { all_within = { at_least = 0 } }
"#;

/// Says one message on both buses, 50 times a second; in real time (at the pty of an adapter), what it heard.
const GATEWAY: &str = r"
import os, select, socket, struct, sys, time, tty

class Socket:
    def __init__(self, name):
        self.file = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self.file.bind((name,))
    def read(self):
        who, length, data = struct.unpack('=IB3x8s', self.file.recv(16))
        return [(who, data[:length])]
    def say(self, who, data):
        self.file.send(struct.pack('=IB3x8s', who, len(data), data))

class Adapter:
    def __init__(self, path):
        self.file, self.rest = os.open(path, os.O_RDWR | os.O_NOCTTY), b''
        tty.setraw(self.file)
        os.write(self.file, b'C\rS4\r\rO\r')
    def read(self):
        self.rest = (self.rest + os.read(self.file, 4096)).replace(b'\a', b'')
        *lines, self.rest = self.rest.split(b'\r')
        lines = [line.decode() for line in lines if line[:1] == b't']
        return [(int(line[1:4], 16), bytes.fromhex(line[5:])) for line in lines]
    def say(self, who, data):
        os.write(self.file, b't%03X%d%s\r' % (who, len(data), data.hex().upper().encode()))

is_real = '/' in sys.argv[1]
if is_real:
    time.sleep(0.4)
pt, body = [(Adapter if is_real else Socket)(name.removeprefix('slcan:')) for name in sys.argv[1:]]
count, due = 0, time.monotonic() + 0.02
while True:
    if select.select([pt.file], [], [], max(0, due - time.monotonic()))[0]:
        for who, data in pt.read():
            if who == 0x7E0:
                pt.say(0x7E8, bytes([2, 0x7E, 0]))
            elif ECHOES:
                body.say(0x210, data[:1])
    if time.monotonic() >= due:
        due += 0.02
        count += 1
        for bus in [] if ECHOES else [pt, body]:
            bus.say(0x210, bytes([count % 256]))
";

fn project(echoes: bool, rest: &str) -> Hil {
    let hil = Hil::new();
    fs::create_dir(hil.path("rigs")).unwrap();
    fs::write(hil.path("rigs/gateway.toml"), RIG).unwrap();
    fs::write(hil.path("pt.dbc"), format!("{DBC}{BUSY}")).unwrap();
    fs::write(hil.path("body.dbc"), DBC).unwrap();
    fs::write(hil.path("gateway.toml"), format!("{PLAN}{rest}")).unwrap();
    let echoes = if echoes { "True" } else { "False" };
    fs::write(hil.path("gw.py"), GATEWAY.replace("ECHOES", echoes)).unwrap();
    hil
}

fn run(hil: &Hil, arguments: &[&str]) -> Ran {
    hil.run(&[&["run", "gateway.toml", "--record", "full", "--out", "run"], arguments].concat())
}

#[test]
fn one_identifier_on_two_buses_is_the_same_in_a_rerun() {
    let hil = project(false, "");
    run(&hil, &[]).exits(0);
    let same = hil.run(&["rerun", "run"]).exits(0).out;
    assert!(same.contains("the same: "), "{same}");
}

#[test]
fn a_rerun_after_a_fault_that_filled_the_bus_is_refused_where_it_cannot_tell() {
    let fault = |what: &str| {
        format!(
            "[[fault]]\ntarget = \"pt\"\nwhat = {{ {what} }}\nwhen = {{ at_s = 0.3 }}\nduration_s = 0.3\n"
        )
    };
    let hil = project(false, &fault("babble = { frames_per_s = 10_000 }"));
    run(&hil, &[]).exits(0);
    let refused = hil.run(&["rerun", "run"]).exits(2).err;
    assert!(
        refused.contains("a fault held messages on a line of the device under test up from 0.3 s"),
        "{refused}"
    );
    let hil = project(false, &fault("bus_load = { load_percent = 20 }"));
    run(&hil, &[]).exits(0);
    hil.run(&["rerun", "run"]).exits(0);
}

#[test]
fn the_line_of_a_frame_is_shown_where_there_are_several() {
    let hil = project(false, "");
    run(&hil, &[]).exits(0);
    let shown = hil.run(&["show", "run"]).exits(0).out;
    for line in ["gw         frame 210#01 on pt", "gw         frame 210#01 on body"] {
        assert!(shown.contains(line), "{line}: {shown}");
    }
    let at = hil.run(&["show", "run", "--at", "1"]).exits(0).out;
    assert!(at.contains("pt.Load: Count 4") && at.contains("body.Load: Count 4"), "{at}");
}

#[test]
fn exports_tell_the_lines_of_a_message_apart() {
    let hil = project(false, "");
    run(&hil, &[]).exits(0);
    for (format, names) in [
        ("mf4", ["messages/gw.pt.Load", "messages/gw.body.Load", "messages/tst.Busy"]),
        ("mcap", ["/messages/pt/Load", "/messages/body/Load", "/messages/Busy"]),
    ] {
        let file = format!("gw.{format}");
        hil.run(&["export", "run", &format!("--{format}"), &file]).exits(0);
        let bytes = fs::read(hil.path(&file)).unwrap();
        for name in names {
            let is_there = bytes.windows(name.len()).any(|found| found == name.as_bytes());
            assert!(is_there, "{file} has no {name}");
        }
    }
}

#[test]
fn what_the_harness_sent_is_sent_in_a_log() {
    let hil = project(false, "");
    run(&hil, &[]).exits(0);
    hil.run(&["export", "run", "--bus", "gw.asc"]).exits(0);
    let log = fs::read_to_string(hil.path("gw.asc")).unwrap();
    let ways = |id: &str| -> Vec<&str> {
        let words = log.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
        words
            .filter(|words| words.get(2) == Some(&id))
            .filter_map(|words| words.get(3).copied())
            .collect()
    };
    for (id, way) in [("100", "Tx"), ("7E0", "Tx"), ("210", "Rx"), ("7E8", "Rx")] {
        let ways = ways(id);
        assert!(!ways.is_empty() && ways.iter().all(|one| *one == way), "{id}: {ways:?}\n{log}");
    }
}

#[test]
fn requests_on_a_declared_channel_are_known() {
    let hil = project(false, "");
    let ran = run(&hil, &[]).exits(0);
    assert!(!ran.out.contains("0x7e0"), "{}", ran.out);
    hil.run(&["export", "run", "--bus", "gw.log"]).exits(0);
    let imported =
        hil.run(&["import", "gw.log", "--plan", "gateway.toml", "--out", "import"]).exits(0);
    assert!(!imported.out.contains("0x7e0"), "{}", imported.out);
    let shown = hil.run(&["show", "import"]).exits(0).out;
    assert!(shown.contains("tst        frame 7E0#023E00"), "{shown}");
}

/// Whether the outputs are the same depends on the machine: the timers of a program may fall elsewhere among its inputs.
#[test]
fn a_rerun_of_a_run_in_real_time_begins_where_the_program_opened_its_bus() {
    in_time(|| {
        let hil = project(true, "");
        let bench = "[line.pt]\nport = \"slcan-pty\"\n[line.body]\nport = \"slcan-pty\"\n[timing]\nlate_ms_max = 5000\n";
        fs::write(hil.path("bench.toml"), bench).unwrap();
        let ran = run(&hil, &["--clock", "real", "--bench", "bench.toml"]);
        assert!(
            !ran.out.contains("SLCAN"),
            "an empty line is none of a wrong protocol: {}",
            ran.out
        );
        let shown = hil.run(&["show", "run"]).exits(0).out;
        let first = shown.lines().find(|line| line.contains("gw         frame 210#")).unwrap();
        assert!(!first.contains("frame 210#00 "), "it heard the first frame: {first}");
        let again = hil.run(&["rerun", "run"]).out;
        assert!(again.contains("output") && !again.contains("frame 210#00 "), "{again}");
    });
}
