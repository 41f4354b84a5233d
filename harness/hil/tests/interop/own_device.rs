//! A device described in a file, and a client in Python that knows only its DBC.

use super::rig::{Emulated, GUEST, file, number, python, python_with, shown, told};
use hil::project::{Template, write};
use plan::Name;
use serde_json::{Value, json};
use skips::{Vcan0, in_time};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Returns what the client received on this channel.
fn drive(interface: &str, channel: &str, folder: &Path) -> Option<Value> {
    let script = file("tests/interop/drive_device.py");
    let dbc = folder.join("devices/oven.dbc");
    Some(told(Command::new(python()?).arg(script).args([interface, channel]).arg(dbc)))
}

fn judge(heard: &Value) {
    // Ten per second for two seconds, on a machine with other load.
    assert!((10.0..=25.0).contains(&number(&heard["heard"])), "{heard}");
    assert!((19.0..=21.0).contains(&number(&heard["first"])), "{heard}");
    assert!(number(&heard["last"]) <= 22.0 && heard["on"] == 1, "{heard}");
}

#[test]
fn python_can_commands_it_through_an_adapter() {
    in_time(|| {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &Template::Can.files(&Name::new("oven").unwrap())).unwrap();
        let arguments = ["device", "devices/oven.toml", "--port", "slcan-pty:can.pty"];
        let (mut device, ready) = Emulated::start(folder.path(), &arguments);
        assert_eq!(ready["ready"], "device");
        let link = folder.path().join("can.pty");
        let Some(heard) = drive("slcan", link.to_str().unwrap(), folder.path()) else { return };
        judge(&heard);
        // Requests while it runs: true values and settings.
        let truth = device.ask(json!({ "get": ["temperature", "heater"] }))["ok"].take();
        assert!((19.9..22.0).contains(&number(&truth["temperature"])), "{truth}");
        assert_eq!(device.ask(json!({ "set": { "ambient": 30 } }))["ok"]["set"], 1);
        assert_eq!(device.ask(json!({ "get": [] }))["ok"]["ambient"], 30.0);
        let refused = device.ask(json!({ "set": { "ambient": 300 } }));
        assert!(refused["error"].as_str().unwrap().contains("ambient"), "{refused}");
        let drop = json!({ "fault": { "drop": { "loss_percent": 100 } } });
        assert_eq!(device.ask(drop)["ok"]["fault"], "drop");
        assert_eq!(device.ask(json!({ "no_fault": {} }))["ok"]["fault"], Value::Null);
        assert!(number(&device.end()["ports"]["device"]["frames_in"]) >= 20.0);
    });
}

#[test]
fn guest_python_can_commands_it_on_a_bus_of_the_kernel() {
    in_time(|| {
        let Some(_bus) = Vcan0::take(GUEST) else { return };
        let interface = Vcan0::NAME;
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &Template::Can.files(&Name::new("oven").unwrap())).unwrap();
        let arguments = ["device", "devices/oven.toml", "--can", interface];
        let (_device, ready) = Emulated::start(folder.path(), &arguments);
        assert_eq!(ready["port"], interface);
        let Some(heard) = drive("socketcan", interface, folder.path()) else { return };
        judge(&heard);
    });
}

/// Answers that look the same, read by the package pymodbus.
#[test]
fn pymodbus_reads_and_sets_a_drive() {
    in_time(|| {
        let Some(python) = python_with("import pymodbus", "pymodbus") else { return };
        let folder = tempfile::tempdir().unwrap();
        let page = std::fs::read_to_string(file("docs/request-and-answer.md")).unwrap();
        let block = page.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
        std::fs::write(folder.path().join("drive.toml"), block).unwrap();
        let arguments = ["device", "drive.toml", "--port", "pty:drive.pty"];
        let (device, _) = Emulated::start(folder.path(), &arguments);
        let script = file("tests/interop/modbus_client.py");
        let read = told(Command::new(python).arg(script).arg(folder.path().join("drive.pty")));
        assert_eq!(read["before"], json!([0, 20]));
        let after = read["after"].as_array().unwrap();
        assert_eq!(after.len(), 20);
        // 100 rpm, and 0.20 A; after 4 s, eight time constants, a thirtieth of an rpm is left.
        assert!(after[..10].iter().all(|pair| *pair == json!([100, 20])), "{read}");
        assert!(after[10..].iter().all(|pair| *pair == json!([100, 20])), "{read}");
        device.end();
    });
}

/// Two slaves on one line (RS-485), each with its address.
#[test]
fn pymodbus_reads_and_sets_two_drives_on_one_line() {
    in_time(|| {
        let Some(python) = python_with("import pymodbus", "pymodbus") else { return };
        let folder = tempfile::tempdir().unwrap();
        let page = std::fs::read_to_string(file("docs/request-and-answer.md")).unwrap();
        let blocks: Vec<&str> =
            page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
        let rig = blocks.iter().find(|block| block.contains("name = \"rs485\"")).unwrap();
        for name in ["devices", "rigs"] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
        }
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("devices/left.toml", blocks[0]);
        write("devices/right.toml", &blocks[0].replace("start = [1,", "start = [2,"));
        write("rigs/drives.toml", rig);
        let arguments = ["rig", "rigs/drives.toml", "--line", "rs485=pty:drives.pty"];
        let (drives, _) = Emulated::start(folder.path(), &arguments);
        let script = file("tests/interop/modbus_slaves.py");
        let speeds = told(Command::new(python).arg(script).arg(folder.path().join("drives.pty")));
        assert_eq!(speeds, json!([100, 40, 100, 40]));
        drives.end();
    });
}

const SLAVE_PLAN: &str = r#"
name = "slave"
title = "A slave in Python does what its EDS says"
rig = "drive"
steps = [
  { wait_until = { above = { quantity = "drive.nmt_state", limit = 126 } }, time_limit_s = 5 },
  { sdo = { node = "drive", index = 0x607A, write = 42 } },
  { sdo = { node = "drive", index = 0x6064, read = "position" } },
  { send = { message = "NMT", set = { command = 1 } } },
  { wait = { duration_s = 1 }, label = "runs" },
]

[[measurement]]
name = "position"
doc = "Where it was sent, 42 degrees"
quantity = "sdo.position"
unit = "deg"
check = { all_within = [42, 42] }

[[measurement]]
name = "heartbeat"
doc = "Ten a second"
quantity = "period.drive.Heartbeat"
where = { "during.runs" = 1 }
unit = "s"
observations_min = 8
check = { all_within = [0.08, 0.12] }

[[property]]
name = "becomes_operational"
sometimes = 'drive.nmt_state == "operational"'
"#;

/// Virtual time, where a bus needs no kernel with CAN: a device under test whose messages are those of an EDS.
#[test]
fn a_slave_by_the_package_canopen_is_judged_by_its_eds() {
    let Some(python) = python_with("import can, canopen", "canopen and python-can") else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let of = |path: PathBuf| path.to_string_lossy().into_owned();
    for folder in ["devices", "rigs"] {
        std::fs::create_dir(path(folder)).unwrap();
    }
    for name in ["drive.toml", "drive.eds"] {
        let source = file("examples/rotary-table/devices").join(name);
        std::fs::copy(source, path("devices").join(name)).unwrap();
    }
    let slave = of(file("tests/interop/canopen_slave.py"));
    let rig = |eds: &str| {
        let command = json!([of(python.clone()), slave, "{can0}", eds]);
        format!(
            "title = \"A drive and its master\"\n[[line]]\nname = \"can0\"\ncan = {{ bit_rate = 500_000 }}\n\
             [[node]]\nname = \"master\"\nat = \"can0\"\ntester = true\n\
             [[node]]\nname = \"drive\"\nat = \"can0\"\nunder_test = {{ command = {command} }}\ndescribed_by = \"drive\"\n"
        )
    };
    std::fs::write(path("slave.toml"), SLAVE_PLAN).unwrap();
    let run = |eds: &str| {
        std::fs::write(path("rigs/drive.toml"), rig(eds)).unwrap();
        let mut hil = Command::new(env!("CARGO_BIN_EXE_hil"));
        hil.args(["run", "slave.toml", "--out", "run"]).current_dir(folder.path()).output().unwrap()
    };
    let eds = of(path("devices/drive.eds"));
    let ran = run(&eds);
    assert!(ran.status.success(), "{}", shown(&ran));
    // Its dictionary lacks the position: the slave aborts what its EDS promises.
    let lacking = std::fs::read_to_string(&eds)
        .unwrap()
        .replace("0x607A", "0x607B")
        .replace("[607A]", "[607B]");
    std::fs::write(path("lacking.eds"), lacking).unwrap();
    let ran = run(&of(path("lacking.eds")));
    assert_eq!(ran.status.code(), Some(1), "{}", shown(&ran));
    assert!(shown(&ran).contains("0602 0000h"), "{}", shown(&ran));
}
