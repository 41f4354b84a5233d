use super::{BenchFile, ControllerSection, Medium, Role};
#[cfg(feature = "ports")]
use crate::library::Library;
use crate::library::{Kind, names};
use wire::time::Span;

const EVERYTHING: &str = r#"
title = "Everything"
setup = ["power-on", "flash"]
teardown = ["power-off"]

[gyro]
port = "serial:usb:0403:6001?baud=9600"

[base]
port = "can:vcan0"
emulated = true

[table]
emulated = true

[controller]
command = ["./mine", "--gyro", "{gyro}"]

[command.power-on]
run = ["uhubctl", "-a", "on", "-p", "2"]
time_limit_s = 10

[command.flash]
run = ["openocd"]

[timing]
late_ms_max = 20

[answers]
file = "answers.toml"
"#;

#[test]
fn everything_that_can_be_said() {
    let bench: BenchFile = toml::from_str(EVERYTHING).unwrap();
    let Role::Real(gyro) = bench.role("gyro") else { panic!("{:?}", bench.gyro) };
    assert_eq!((gyro.medium(), gyro.address()), (Medium::Serial, "usb:0403:6001"));
    let Role::Emulated(Some(base)) = bench.role("base") else { panic!("{:?}", bench.base) };
    assert_eq!(base.as_str(), "can:vcan0");
    assert_eq!(bench.role("table"), Role::Emulated(None));
    let Some(ControllerSection::Command(words)) = &bench.controller else { panic!() };
    assert_eq!(words.len(), 3);
    let commands: Vec<_> = bench
        .commands
        .iter()
        .map(|(name, command)| (name.as_str(), command.run.len(), command.time_limit))
        .collect();
    assert_eq!(commands, [("flash", 1, Span::from_secs(60)), ("power-on", 5, Span::from_secs(10))]);
    assert_eq!(bench.timing.late_max, Some(Span::from_millis(20)));
    assert_eq!(bench.answers.unwrap().file.to_str(), Some("answers.toml"));
}

#[test]
fn a_role_that_is_not_named_is_emulated() {
    let bench: BenchFile = toml::from_str("").unwrap();
    assert!(bench.roles().all(|(_, role)| role == Role::Emulated(None)));
    assert_eq!(bench, BenchFile::default());
}

#[test]
fn the_answers_lie_beside_the_bench() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, EVERYTHING).unwrap();
    let bench = BenchFile::load(path.to_str().unwrap()).unwrap();
    assert_eq!(bench.answers.unwrap().file, folder.path().join("answers.toml"));
}

#[test]
fn every_bench_that_ships_can_be_read() {
    let shipped = names(Kind::Bench);
    for name in ["attach", "emulated", "slcan", "usb", "vcan"] {
        assert!(shipped.iter().any(|shipped| shipped == name), "{name}: {shipped:?}");
    }
    for name in shipped {
        let bench = BenchFile::load(&name).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(!bench.title.is_empty(), "{name}");
    }
}

/// The ports themselves check what is said of them.
#[cfg(feature = "ports")]
#[test]
fn mistakes_are_shown_in_place() {
    let mut shown = String::new();
    for text in [
        "[gyro]\nprot = \"/dev/ttyUSB0\"",
        "[gyro]\nport = \"cna:vcan0\"",
        "[gyro]\nport = \"ttyUSB0\"",
        "[gyro]\nport = \"can:can0\"",
        "[gyro]\nport = \"pty\"",
        "[gyro]\nport = \"serial:/dev/ttyUSB0?baud=fast\"",
        "[gyro]\nemulated = false",
        "[base]\ntitle = \"x\"",
        "[base]",
        "[gyros]\nemulated = true",
        "[controller]\nattach = \"unix:x.sock\"\ncommand = [\"x\"]",
        "[controller]\nattach = true",
        "[controller]\nattach = \"tcp:localhost\"",
        "[controller]\ncommand = []",
        "[controller]\nprogram = \"x\"",
        "[command.flash]",
        "[command.flash]\nrun = []",
        "[command.flash]\nrun = \"openocd\"",
        "[command.flash]\nrun = [\"openocd\", \"\\u0000\"]",
        "[command.flash]\nrun = [\"openocd\"]\ntimeout_s = 10",
        "[command.flash]\nrun = [\"openocd\"]\ntime_limit_s = 0",
        "[command.flash]\nrun = [\"openocd\"]\ntime_limit_s = 3601",
        "[command.Flash]\nrun = [\"openocd\"]",
        "[command.flash]\nrun = [\"a\"]\n[command.flash]\nrun = [\"b\"]",
        "setup = [\"power on\"]",
        "[timing]\nlate_ms_max = 0",
        "[answers]\nfile = 3",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bench.toml");
        std::fs::write(&path, text).unwrap();
        let read = Library::shipped().read::<BenchFile>(Kind::Bench, path.to_str().unwrap());
        let report = read.unwrap_err();
        let handler = miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::none());
        let mut message = String::new();
        handler.with_width(100).render_report(&mut message, &report).unwrap();
        shown += &message.replace(&*folder.path().to_string_lossy(), ".");
        shown.push('\n');
    }
    insta::assert_snapshot!(shown);
}
