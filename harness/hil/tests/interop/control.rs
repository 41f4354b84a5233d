//! Requests, their answers, and their effect on the stream.

use super::rig::Emulated;
use serde_json::{Value, json};
use skips::in_time;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;

#[test]
fn a_socket_takes_requests_too_and_is_removed() {
    in_time(|| {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("ctl.sock");
        let control = format!("unix:{}", socket.display());
        let (mut gyro, _) =
            Emulated::start(folder.path(), &["gyro", "--pty", "--control", &control]);
        let mut client = UnixStream::connect(&socket).unwrap();
        client
            .write_all(b"{\"id\":\"x\",\"set\":{\"bias_deg_per_h\":30}}\n{\"id\":2,\"bad\":1}\n")
            .unwrap();
        let mut lines = BufReader::new(client).lines();
        let mut next = || serde_json::from_str::<Value>(&lines.next().unwrap().unwrap()).unwrap();
        assert_eq!(next(), json!({ "id": "x", "ok": { "set": 1 } }));
        let refused = next();
        assert!(refused["error"].as_str().unwrap().contains("expected one of"), "{refused}");
        let list = gyro.ask(json!({ "list": true }));
        assert_eq!(list["ok"]["gyro"]["parameters"]["bias_deg_per_h"], 30.0, "{list}");
        gyro.end();
        assert!(!socket.exists());
    });
}

#[test]
fn a_bench_in_one_process_has_a_line_for_each_port() {
    in_time(|| {
        let folder = tempfile::tempdir().unwrap();
        let (mut bench, gyro) = Emulated::start(
            folder.path(),
            &["bench", "--devices", "paper", "--gyro", "pty", "--base", "slcan-pty:can.pty"],
        );
        assert_eq!(gyro["ready"], "gyro");
        let base = bench.line();
        assert_eq!((&base["ready"], &base["link"]), (&json!("base"), &json!("can.pty")));
        let refused = bench.ask(json!({ "rate_deg_per_s": 10 }));
        assert!(refused["error"].as_str().unwrap().contains("the base carries it"), "{refused}");
        let truth = bench.truth();
        assert!(truth["gyro"].is_object() && truth["base"].is_object(), "{truth}");
        bench.end();
        assert!(!folder.path().join("can.pty").exists(), "the link is removed");
    });
}

#[test]
fn the_devices_of_a_rig_serve_whoever_is_on_its_lines() {
    in_time(|| {
        let folder = tempfile::tempdir().unwrap();
        let rig = super::rig::file("examples/battery-pack/rigs/pack.toml");
        let arguments = ["rig", rig.to_str().unwrap(), "--line", "can0=slcan-pty:can.pty"];
        let (mut pack, ready) = Emulated::start(folder.path(), &arguments);
        assert_eq!((&ready["ready"], &ready["link"]), (&json!("can0"), &json!("can.pty")));
        // The manager is an external node: it is not emulated.
        let list = pack.ask(json!({ "list": true }))["ok"].take();
        let names: Vec<&String> = list.as_object().unwrap().keys().collect();
        assert_eq!(names, ["cells", "charger"]);
        let set = json!({ "set": { "offset": 0.5 }, "device": "cells" });
        assert_eq!(pack.ask(set)["ok"]["set"], 1);
        assert_eq!(pack.ask(json!({ "get": [], "device": "cells" }))["ok"]["offset"], 0.5);
        assert!(pack.truth()["cells"]["charge"].is_number());
        let fault = json!({ "fault": "disconnect", "device": "can0" });
        assert_eq!(pack.ask(fault)["ok"]["fault"], "disconnect");
        assert!(pack.end()["ports"]["can0"].is_object());
    });
}
