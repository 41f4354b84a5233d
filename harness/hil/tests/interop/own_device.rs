//! A device described in a file, and a client in Python that knows only its DBC.

use super::rig::{Emulated, GUEST, file, number, python, told};
use hil::project::{Template, write};
use plan::Name;
use serde_json::{Value, json};
use skips::{Vcan0, in_time};
use std::path::Path;
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
