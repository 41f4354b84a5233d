//! Fictitious machines, and the doctor's findings on each.

use super::can::{CanFacts, Module};
use super::clock::ClockFacts;
use super::limits::LimitFacts;
use super::programs::{ProgramFacts, ProgramFound, look};
use super::pty::PtyFacts;
use super::serial::{SerialFacts, SerialPort, UsbAdapter};
use super::{CanInterface, CanState, Facts, Needs, ProgramNeed, Status, examine, outcome, show};
use plan::bench_file::{BenchFile, ROLES};
use record::outcome::Outcome;
use record::text::name_of;
use std::os::unix::fs::PermissionsExt as _;
use views::console::Style;

fn needs(name: &str) -> Needs {
    let mut needs = Needs::default();
    needs.add(name, &BenchFile::load(name).unwrap(), &ROLES);
    needs
}

fn modules(vcan: Module) -> CanFacts {
    let modules = [("can_raw", vcan), ("slcan", vcan), ("vcan", vcan)];
    CanFacts {
        no_socket: None,
        modules: modules.map(|(name, module)| (name.to_owned(), module)).into(),
        interfaces: Vec::new(),
        ip: true,
    }
}

fn can0(state: CanState) -> CanInterface {
    CanInterface {
        name: "can0".to_owned(),
        up: true,
        kind: Some("can".to_owned()),
        state: Some(state),
        bitrate: Some(500_000),
        data_bitrate: None,
        restart_ms: Some(0),
        errors: Some((0, 0)),
    }
}

fn vcan0(up: bool) -> CanInterface {
    let kind = Some("vcan".to_owned());
    CanInterface { name: "vcan0".to_owned(), up, kind, ..CanInterface::default() }
}

fn adapter(path: &str, serial_number: &str) -> SerialPort {
    SerialPort {
        path: path.to_owned(),
        by_id: Some(format!(
            "/dev/serial/by-id/usb-FTDI_FT232R_USB_UART_{serial_number}-if00-port0"
        )),
        usb: Some(UsbAdapter {
            vendor: 0x0403,
            product: 0x6001,
            serial_number: Some(serial_number.to_owned()),
            name: "FTDI FT232R USB UART".to_owned(),
        }),
        group: "dialout".to_owned(),
        accessible: true,
    }
}

/// A developer's machine that lacks only what a test removes.
pub(super) fn laptop() -> Facts {
    let can = CanFacts { interfaces: vec![vcan0(true)], ..modules(Module::Loaded) };
    Facts {
        kernel: "6.12.48+deb13-amd64".to_owned(),
        container: false,
        can,
        serial: SerialFacts {
            user: "jane".to_owned(),
            groups: vec!["jane".to_owned()],
            enrolled: Vec::new(),
            ports: Vec::new(),
        },
        pty: PtyFacts { no_pair: None, used: Some((4, 4_096)) },
        clock: ClockFacts {
            source: Some("tsc".to_owned()),
            resolution_s: 1e-9,
            reading_s: 25e-9,
            late_max_s: 0.3e-3,
            late_p99_s: 0.11e-3,
        },
        limits: LimitFacts { real_time_priority: Some(0), locked_bytes: Some(8 << 20) },
        programs: ProgramFacts {
            our_controller: Some("/home/jane/hil/target/release/k2a-controller".into()),
            under_test: Vec::new(),
        },
    }
}

/// A build server: kernel modules of the host, no devices, no programs.
fn container() -> Facts {
    Facts {
        kernel: "5.15.0".to_owned(),
        container: true,
        can: CanFacts {
            no_socket: Some("Address family not supported by protocol (os error 97)".to_owned()),
            ip: false,
            ..modules(Module::Missing)
        },
        programs: ProgramFacts::default(),
        ..laptop()
    }
}

/// A bench with USB adapters and a CAN interface.
fn bench(state: CanState) -> Facts {
    let can = CanFacts { interfaces: vec![can0(state)], ..modules(Module::Available) };
    let serial = SerialFacts {
        ports: vec![adapter("/dev/ttyUSB0", "A50285BI"), adapter("/dev/ttyUSB1", "A9003XYZ")],
        groups: vec!["jane".to_owned(), "dialout".to_owned()],
        ..laptop().serial
    };
    let limits = LimitFacts { real_time_priority: Some(80), locked_bytes: None };
    Facts { can, serial, limits, ..laptop() }
}

fn shown(facts: &Facts, needs: &Needs) -> String {
    show::text(&examine(facts, needs), Style::PLAIN)
}

#[test]
fn a_bare_container_needs_nothing_for_virtual_time() {
    let findings = examine(&container(), &Needs::default());
    assert_eq!(outcome(&findings), Outcome::Passed);
    insta::assert_snapshot!(shown(&container(), &Needs::default()));
}

#[test]
fn a_bare_container_for_the_bench_vcan() {
    assert_eq!(outcome(&examine(&container(), &needs("vcan"))), Outcome::Error);
    insta::assert_snapshot!(shown(&container(), &needs("vcan")));
}

#[test]
fn a_laptop_with_vcan() {
    assert_eq!(outcome(&examine(&laptop(), &needs("vcan"))), Outcome::Passed);
    insta::assert_snapshot!(shown(&laptop(), &needs("vcan")));
}

#[test]
fn a_bench_with_usb_adapters() {
    let mut facts = bench(CanState::ErrorActive);
    facts.serial.ports.truncate(1);
    let words = needs("usb").programs.first().map(|need| need.words.clone()).unwrap_or_default();
    let path = words.first().map(Into::into);
    facts.programs.under_test = vec![ProgramFound { words, path, ..ProgramFound::default() }];
    assert_eq!(outcome(&examine(&facts, &needs("usb"))), Outcome::Passed);
    insta::assert_snapshot!(shown(&facts, &needs("usb")));
}

/// Two identical adapters where one is meant, can0 in bus-off, no controller, and a late clock.
#[test]
fn a_bench_in_trouble() {
    let mut facts = bench(CanState::BusOff);
    facts.can.interfaces[0].errors = Some((248, 0));
    facts.serial.ports[1].accessible = false;
    facts.clock.late_max_s = 31.4e-3;
    insta::assert_snapshot!(shown(&facts, &needs("usb")));
}

fn mends(facts: &Facts, needs: &Needs, subject: &str) -> (Status, String) {
    let findings = examine(facts, needs);
    let finding = findings.iter().find(|finding| finding.subject == subject);
    let finding = finding.unwrap_or_else(|| panic!("nothing about {subject}: {findings:#?}"));
    (finding.status, finding.mend.clone().unwrap_or_default())
}

#[test]
fn an_interface_gets_the_command_that_it_needs() {
    let with = |interfaces: Vec<CanInterface>, module| {
        let can = CanFacts { interfaces, ..modules(module) };
        Facts { can, ..laptop() }
    };
    let vcan = needs("vcan");
    let add = "sudo ip link add dev vcan0 type vcan && sudo ip link set vcan0 up";
    let load = format!("sudo modprobe vcan && {add}");
    let lacking = |mend: &str| (Status::Missing, mend.to_owned());
    assert_eq!(mends(&with(vec![], Module::Available), &vcan, "vcan0"), lacking(&load));
    assert_eq!(mends(&with(vec![], Module::BuiltIn), &vcan, "vcan0"), lacking(add));
    let down = with(vec![vcan0(false)], Module::Loaded);
    assert_eq!(mends(&down, &vcan, "interface vcan0"), lacking("sudo ip link set vcan0 up"));
    let hardware = CanInterface { up: false, ..can0(CanState::Stopped) };
    let (status, mend) = mends(&with(vec![hardware], Module::Loaded), &vcan, "interface can0");
    assert_eq!(status, Status::Optional, "nothing needs it");
    assert_eq!(mend, "sudo ip link set can0 up type can bitrate 500000 restart-ms 100");
    let passive = with(vec![can0(CanState::ErrorPassive)], Module::Loaded);
    assert_eq!(mends(&passive, &needs("usb"), "interface can0").0, Status::Optional);
    let mut facts = laptop();
    facts.can.no_socket = Some("no".to_owned());
    facts.can.modules.insert("can_raw".to_owned(), Module::Available);
    assert_eq!(mends(&facts, &vcan, "CAN"), lacking("sudo modprobe can_raw"));
}

#[test]
fn a_port_that_is_not_ours_gets_the_command_that_it_needs() {
    let closed = |group: &str, groups: &[&str], enrolled: &[&str]| {
        let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let mut port = adapter("/dev/ttyUSB0", "A50285BI");
        port.accessible = false;
        group.clone_into(&mut port.group);
        let (groups, enrolled) = (owned(groups), owned(enrolled));
        let serial = SerialFacts { user: "jane".to_owned(), groups, enrolled, ports: vec![port] };
        mends(&Facts { serial, ..laptop() }, &needs("usb"), "/dev/ttyUSB0")
    };
    for (group, groups, enrolled, begins) in [
        ("dialout", &["jane"][..], &[][..], "sudo usermod -aG dialout $USER\n# then log in again"),
        ("dialout", &["jane"], &["dialout"], "# log in again: jane is in the group dialout"),
        ("dialout", &["dialout"], &["dialout"], "sudo chmod g+rw /dev/ttyUSB0"),
        ("root", &["jane"], &[], "sudo chgrp dialout /dev/ttyUSB0"),
    ] {
        let (status, mend) = closed(group, groups, enrolled);
        assert_eq!(status, Status::Missing);
        assert!(mend.starts_with(begins), "{mend}");
    }
}

#[test]
fn no_pty_to_be_had_has_its_command() {
    let with = |why: &str, used| {
        let no_pair = Some(why.to_owned());
        mends(&Facts { pty: PtyFacts { no_pair, used }, ..laptop() }, &needs("emulated"), "ptys")
    };
    let (status, mend) = with("no space", Some((4_096, 4_096)));
    assert_eq!((status, mend.as_str()), (Status::Missing, "sudo sysctl -w kernel.pty.max=8192"));
    assert!(with("not found", None).1.contains("mount -t devpts"));
}

#[test]
fn an_adapter_cannot_steer_the_terminal() {
    let mut facts = bench(CanState::ErrorActive);
    facts.serial.ports[0].accessible = false;
    facts.serial.ports[0].usb.as_mut().unwrap().name = "evil\u{1b}[2J\nrow".to_owned();
    assert!(!shown(&facts, &needs("usb")).contains('\u{1b}'));
}

#[test]
fn plans_are_held_against_the_bench() {
    let read = |bench: Option<&str>, plans: &[&str]| {
        let plans: Vec<String> = plans.iter().map(|plan| (*plan).to_owned()).collect();
        Needs::read(bench, &plans)
    };
    let told = |needs: &Needs| {
        let line = |finding: &super::Finding| {
            let mend = finding.mend.as_deref().unwrap_or("-").lines().next().unwrap_or_default();
            format!(
                "{} | {} | {} | {mend}",
                finding.subject,
                name_of(&finding.status),
                finding.what
            )
        };
        needs.findings.iter().map(line).collect::<Vec<_>>().join("\n")
    };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let bench = path(
        "mine.toml",
        "[base]\nport = \"can:can0\"\n[answers]\nfile = \"there-is-none.toml\"\n",
    );
    let mut all = String::new();
    for needs in [
        read(None, &["laps-corrected", "varification"]),
        read(Some("vcan"), &["laps-corrected", "verification"]),
        read(Some("vcan"), &["laps-corrected-serial"]),
        read(Some("emulated"), &["laps-corrected"]),
        read(Some(&bench), &["laps-corrected"]),
        read(Some("no-such-bench"), &[]),
    ] {
        all += &told(&needs).replace(&*folder.path().to_string_lossy(), ".");
        all += "\n\n";
    }
    insta::assert_snapshot!(all);
    // With the table alone, the base is not needed.
    let needs = read(Some("vcan"), &["verification"]);
    assert!(needs.ports.is_empty(), "{:?}", needs.ports);
    assert_eq!(needs.ptys.len(), 2);
}

#[test]
fn a_rig_needs_its_programs_and_the_ports_of_its_lines_and_no_controller_of_ours() {
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/battery-pack/charge.toml");
    let folder = tempfile::tempdir().unwrap();
    let needs = |bench: Option<&str>| {
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, bench.unwrap_or_default()).unwrap();
        Needs::read(bench.and(path.to_str()), &[example.to_owned()])
    };
    let alone = needs(None);
    assert_eq!(alone.programs[0].words, ["python3", "manager.py", "{can0}"]);
    let mut facts = bench(CanState::ErrorActive);
    facts.programs.our_controller = None;
    let words = alone.programs[0].words.clone();
    let (path, no_script) = (Some("/usr/bin/python3".into()), Some("manager.py".to_owned()));
    let found = ProgramFound { words, path, ..ProgramFound::default() };
    let mut shown = String::new();
    for (bench, found) in [
        (None, vec![]),
        (None, vec![ProgramFound { no_script, ..found.clone() }]),
        (Some(""), vec![found.clone()]),
        (Some("[line.can0]\nport = \"/dev/ttyUSB0\""), vec![found.clone()]),
        // The rig has 250 kbit/s, and the interface 500.
        (Some("[line.can0]\nport = \"can:can0\""), vec![found]),
    ] {
        facts.programs.under_test = found;
        let needs = needs(bench);
        for finding in examine(&facts, &needs) {
            if finding.needed_by.is_some() {
                let mend = finding.mend.unwrap_or_default();
                let by = finding.needed_by.unwrap_or_default();
                shown += &format!("{}, for {by}: {}\n{mend}\n", finding.subject, finding.what);
            }
        }
        shown += "\n";
    }
    insta::assert_snapshot!(shown.replace(&*folder.path().to_string_lossy(), "."));
    // No robot, no controller of ours.
    assert!(examine(&facts, &alone).iter().all(|finding| finding.subject != "k2a-controller"));
    // Without plans, a bench with lines needs only those.
    let path = folder.path().join("mine.toml");
    let lines = Needs::read(path.to_str(), &[]);
    assert_eq!((lines.ports.len(), lines.ptys.len(), lines.our_controller), (1, 0, None));
}

#[test]
fn a_script_is_looked_for_and_so_is_its_interpreter() {
    let folder = tempfile::tempdir().unwrap();
    let script = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let good = script("good", "#!/bin/sh\n");
    assert_eq!(look(std::slice::from_ref(&good)).no_interpreter, None);
    for (name, line, lacks) in [
        ("a", "#!/usr/bin/env -S no-such-python -u\n", "no-such-python"),
        ("b", "#!/no/such/interpreter\n", "/no/such/interpreter"),
    ] {
        assert_eq!(look(&[script(name, line)]).no_interpreter.as_deref(), Some(lacks));
    }
    let sh = |script: &str| look(&["sh".to_owned(), script.to_owned()]);
    assert!(sh(&good).path.is_some() && sh(&good).no_script.is_none());
    assert_eq!(sh("no/such.sh").no_script.as_deref(), Some("no/such.sh"));
    assert_eq!(sh("-c").no_script, None);
    assert_eq!(look(&["no-such-program".to_owned()]).path, None);
    let gone = "no-such-program".to_owned();
    let needs = Needs {
        programs: vec![ProgramNeed { by: "x of plan y".to_owned(), words: vec![gone], name: None }],
        ..Needs::default()
    };
    let (status, mend) = mends(&laptop(), &needs, "no-such-program");
    assert_eq!(status, Status::Missing);
    assert!(mend.contains("./no-such-program"), "{mend}");
}

#[test]
fn a_program_reads_the_same() {
    let (facts, needs) = (container(), needs("vcan"));
    let json = show::json(&facts, &examine(&facts, &needs)).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["outcome"], "error");
    assert_eq!(json["facts"]["can"]["modules"]["vcan"], "missing");
    let lacking: Vec<_> = json["findings"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|finding| finding["status"] == "missing")
        .map(|finding| finding["subject"].as_str().unwrap())
        .collect();
    assert_eq!(lacking, ["CAN", "vcan0", "k2a-controller"]);
}

#[test]
fn this_machine_can_be_looked_at() {
    let needs = needs("usb");
    let facts = Facts::gather(&needs);
    assert!(!facts.kernel.is_empty() && facts.clock.resolution_s > 0.0);
    assert!(facts.clock.late_max_s >= facts.clock.late_p99_s);
    assert!(shown(&facts, &needs).contains("clock"));
}
