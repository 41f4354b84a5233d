//! Other nodes beside the paper's robot: a described device on the base's bus, and a user's program on a separate line.

use crate::attach::appears;
use crate::{hil, out, record, run, shown, summary};
use skips::in_time;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// A lamp that blinks, and counts the base's motion messages.
const LAMP: &str = r#"
name = "lamp"
title = "A lamp on the bus of the base"
[parameter.brightness]
value = 40
unit = "1"
[[message]]
name = "Light"
sent_by = "device"
can_id = 0x3a0
period_s = 0.1
fields = [{ name = "Brightness", type = "u8" }]
[signal.Brightness]
expression = "brightness"
[[message]]
name = "Set"
sent_by = "host"
can_id = 0x3a1
fields = [{ name = "To", type = "u8" }]
"#;

const SENSOR: &str = r#"
name = "sensor"
title = "A sensor that asks for nothing"
[serial]
baud = 115200
[[message]]
name = "Reading"
sent_by = "device"
text = "R={Reading:.1}\n"
period_s = 0.05
[signal.Reading]
expression = "12.5"
[[message]]
name = "Echo"
sent_by = "host"
text = "E={Echo:.1}\n"
"#;

const RIG: &str = r#"
title = "The robot, a lamp on its bus, and a sensor with a program"
devices = "paper"
[[line]]
name = "uart"
serial = {}
[[node]]
name = "lamp"
at = "base"
emulate = "lamp"
[[node]]
name = "sensor"
at = "uart"
emulate = "sensor"
[[node]]
name = "echo"
at = "uart"
under_test = { command = ["python3", "echo.py", "{uart}"] }
"#;

const ECHO: &str = "\
import os, sys, tty
port = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
tty.setraw(port)
while True:
    os.write(port, os.read(port, 64).replace(b'R', b'E'))
";

const PLAN: &str = r#"
name = "beside"
title = "The robot turns, and others speak beside it"
rig = "beside"
steps = [{ bias_test = { duration_s = 5 } }, { turn = { angle_deg = 30, rate_deg_per_s = 30 } }]
[[measurement]]
name = "turned"
doc = ""
quantity = "turn.stop_error"
unit = "deg"
check = { all_within = [-0.5, 0.5] }
[[measurement]]
name = "light"
doc = ""
quantity = "lamp.Brightness"
unit = "1"
check = { all_within = [40, 40] }
observations_min = 40
[[measurement]]
name = "echo"
doc = ""
quantity = "echo.Echo"
unit = "1"
check = { all_within = [12.5, 12.5] }
observations_min = 20
"#;

fn project(folder: &Path) {
    let rig = RIG.replace("echo.py", &folder.join("echo.py").to_string_lossy());
    for (path, text) in [
        ("devices/lamp.toml", LAMP),
        ("devices/sensor.toml", SENSOR),
        ("rigs/beside.toml", &rig),
        ("echo.py", ECHO),
        ("beside.toml", PLAN),
    ] {
        let path = folder.join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
}

#[test]
fn nodes_beside_the_papers_robot_in_real_time() {
    in_time(|| {
        let (folder, out) = out("beside");
        project(folder.path());
        let plan = folder.path().join("beside.toml");
        let arguments = [
            "run",
            plan.to_str().unwrap(),
            "--clock",
            "real",
            "--bus",
            "slcan",
            "--record",
            "full",
        ];
        let output = run(&arguments, &out);
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let summary = summary(&out);
        let tested = summary["device_under_test"].as_str().unwrap();
        assert!(tested.contains("echo: python3 "), "{tested}");
        assert_eq!(summary["bus"], "pty+slcan-pty+pty");
        let record = record(&out);
        for (by, what) in [("lamp", "3A0#28"), ("base", "181#"), ("controller", "101#")] {
            let kept = |line: &str| line.contains(by) && line.contains(what);
            assert!(record.lines().any(kept), "no {what} of the {by} in the record");
        }
    });
}

#[test]
fn a_real_base_has_its_bus_for_itself() {
    let (folder, out) = out("real");
    project(folder.path());
    let bench = folder.path().join("bench.toml");
    std::fs::write(&bench, "[base]\nport = \"can:can0\"\n").unwrap();
    let plan = folder.path().join("beside.toml");
    let arguments =
        ["run", plan.to_str().unwrap(), "--clock", "real", "--bench", bench.to_str().unwrap()];
    let output = run(&arguments, &out);
    let text = shown(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("the base at can:can0 has its line for itself"), "{text}");
}

const CYCLE: &str = r#"
name = "cycle"
title = "A program whose supply fails twice"
rig = "alone"
steps = [
    { wait = { duration_s = 1 } },
    { power_cycle = { device = "echo", off_s = 0.3 }, label = "off" },
    { wait_until = { above = { quantity = "echo.Echo", limit = 1 } }, time_limit_s = 20 },
    { wait = { duration_s = 1 }, label = "cut" },
    { wait_until = { above = { quantity = "echo.Echo", limit = 1 } }, time_limit_s = 20 },
]
[[measurement]]
name = "echo"
doc = ""
quantity = "echo.Echo"
unit = "1"
check = { all_within = [12.5, 12.5] }
observations_min = 3
[[fault]]
target = "echo"
what = { restart = { for_s = 0.3 } }
when = { step = "cut" }
"#;

/// A project of the sensor and its program, which begins with those lines.
fn alone(folder: &Path, beginning: &str) -> PathBuf {
    project(folder);
    let rig = RIG.replace("echo.py", &folder.join("echo.py").to_string_lossy());
    let (_, nodes) = rig.split_once("[[line]]").unwrap();
    let lamp = "[[node]]\nname = \"lamp\"\nat = \"base\"\nemulate = \"lamp\"\n";
    assert!(nodes.contains(lamp));
    let rig = format!("title = \"A sensor\"\n[[line]]{}", nodes.replace(lamp, ""));
    std::fs::write(folder.join("rigs/alone.toml"), rig).unwrap();
    std::fs::write(folder.join("cycle.toml"), CYCLE).unwrap();
    std::fs::write(folder.join("echo.py"), format!("{beginning}\n{ECHO}")).unwrap();
    folder.join("cycle.toml")
}

/// A step and a fault both kill the program, and start it again with its log.
#[test]
fn a_program_is_started_again_in_real_time() {
    in_time(|| {
        let (folder, out) = out("cycle");
        let cycle = alone(folder.path(), "print('up', flush=True)");
        let output = run(&["run", cycle.to_str().unwrap(), "--clock", "real"], &out);
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let log = std::fs::read_to_string(out.join("device-under-test.log")).unwrap();
        assert_eq!(log, "up\nup\nup\n");
        let summary = summary(&out);
        assert_eq!(summary["faults"][0]["acted"], 1, "{}", summary["faults"]);
    });
}

/// Nobody is left to end the program but what was started with it.
#[test]
#[expect(clippy::disallowed_methods, reason = "processes end in real time")]
fn a_program_ends_with_all_that_it_started_when_the_run_is_killed() {
    in_time(|| {
        let (folder, out) = out("killed");
        let started = "import subprocess\nslept = subprocess.Popen(['sleep', '1000'])\n\
                       open('started.new', 'w').write(f'{os.getpid()} {slept.pid}')\n\
                       os.rename('started.new', 'started')";
        let cycle = alone(folder.path(), &format!("import os\n{started}"));
        let mut run = hil();
        run.args(["run", cycle.to_str().unwrap(), "--clock", "real", "--out"]).arg(&out);
        run.current_dir(folder.path()).stdout(Stdio::null()).stderr(Stdio::null());
        let mut run = run.spawn().unwrap();
        appears(&folder.path().join("started"));
        run.kill().unwrap();
        run.wait().unwrap();
        let started = std::fs::read_to_string(folder.path().join("started")).unwrap();
        let deadline = Instant::now() + Duration::from_secs(20);
        for id in started.split(' ') {
            while Path::new("/proc").join(id).exists() {
                assert!(Instant::now() < deadline, "{id} of {started} goes on");
                std::thread::sleep(Duration::from_millis(20));
            }
        }
    });
}
