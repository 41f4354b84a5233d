//! A bench of real devices, where a person carries the robot and measures its position.
//!
//! The real devices are `hil emulate` on ptys, and the controller already runs: the harness started neither, and runs
//! follow one another.

use crate::attach::{Kept, appears};
use crate::{hil, out, record, shown, summary};
use skips::in_time;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A side of the square, judged by the person's measurements.
const SIDE: &str = r#"
name = "side-by-hand"
title = "One side of the square, measured by hand"
devices = "robot"
steps = [
    { set_parameter = { parameter = "gyro.ambient_celsius", value = 20 } },
    { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
    { bias_test = { duration_s = 3 } },
    { straight = { distance_m = 1, speed_m_per_s = 0.4 } },
    { measure_pose = "end" },
]

[[measurement]]
name = "end_x"
doc = "Where the side ends by the absolute measurement"
quantity = "pose.x"
unit = "m"
check = { all_within = [0.98, 1.02] }

[[measurement]]
name = "end_heading"
doc = "The heading at the end of the side by the absolute measurement"
quantity = "pose.heading"
unit = "deg"
check = { all_within = [-1, 1] }
"#;

/// The robot and its controller, both running, neither started by the run.
struct Bench {
    folder: tempfile::TempDir,
    _controller: Kept,
    _robot: Kept,
}

impl Bench {
    fn start() -> Self {
        let (folder, _) = out("");
        let devices = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../tests/interop/plans/devices/robot.toml");
        std::fs::create_dir(folder.path().join("devices")).unwrap();
        std::fs::copy(devices, folder.path().join("devices/robot.toml")).unwrap();
        std::fs::write(folder.path().join("plan.toml"), SIDE).unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        let bench = format!(
            "[gyro]\nport = \"{}\"\n[base]\nport = \"{}\"\n[controller]\nattach = \"unix:{}\"\n\
             [timing]\nlate_ms_max = 1000\n",
            at("gyro.pty"),
            at("base.pty"),
            at("missions.sock")
        );
        std::fs::write(folder.path().join("bench.toml"), bench).unwrap();
        let mut robot = hil();
        robot.args(["emulate", "bench", "--devices", "./devices/robot.toml"]);
        robot.args(["--gyro", "pty:./gyro.pty", "--base", "pty:./base.pty"]);
        robot.current_dir(folder.path()).stdin(Stdio::null()).stdout(Stdio::null());
        let robot = Kept(robot.spawn().unwrap());
        appears(&folder.path().join("gyro.pty"));
        appears(&folder.path().join("base.pty"));
        let program = Path::new(hil().get_program()).with_file_name("k2a-controller");
        let mut controller = Command::new(program);
        controller.args(["--gyro", &at("gyro.pty")]);
        controller.args(["--base", &format!("serial:{}", at("base.pty"))]);
        controller.args(["--listen", &format!("unix:{}", at("missions.sock"))]);
        let controller = Kept(controller.spawn().unwrap());
        Self { folder, _controller: controller, _robot: robot }
    }

    /// Runs the plan with these answers of the person.
    fn run(&self, name: &str, answers: &str) -> (Output, PathBuf) {
        let out = self.folder.path().join(name);
        let mut run = hil();
        run.args(["run", "./plan.toml", "--clock", "real", "--bench", "./bench.toml", "--out"]);
        run.arg(&out).current_dir(self.folder.path()).stdin(Stdio::null());
        if !answers.is_empty() {
            std::fs::write(self.folder.path().join("answers.toml"), answers).unwrap();
            run.args(["--answers", "answers.toml"]);
        }
        (run.output().unwrap(), out)
    }
}

fn answers(x: &str) -> String {
    format!(
        "by = \"Jane Doe\"\ndone = true\n[answers]\npose_x = \"{x}\"\npose_y = \"3 mm\"\n\
         pose_heading = \"0.2 deg\"\n"
    )
}

#[test]
fn a_side_is_judged_by_what_a_person_measures() {
    in_time(|| {
        let bench = Bench::start();
        let (output, out) = bench.run("good", &answers("1002 mm"));
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let good = summary(&out);
        assert_eq!(
            (&good["outcome"], &good["bus"]),
            (&"passed".into(), &"serial".into()),
            "{good}"
        );
        let x = good["measurements"][0]["value"].as_f64().unwrap();
        assert!((x - 1.002).abs() < 1e-9, "{good}");
        let record = record(&out);
        for said in [
            "Set gyro.ambient_celsius to 20",
            "Place the robot at x = 0 m",
            "pose_x = 1.002 m by Jane Doe in a file",
            "pose_heading = 0.2 deg by Jane Doe in a file",
        ] {
            assert!(record.contains(said), "{said}: {record}");
        }
        assert!(!record.contains("truth"), "nobody knows the truth of a real bench");

        // The same robot and controller, with other answers: the plan's check fails.
        let (output, out) = bench.run("bad", &answers("1.2 m"));
        assert_eq!(output.status.code(), Some(1), "{}", shown(&output));
        assert_eq!(summary(&out)["measurements"][0]["verdict"], "fail");
    });
}

#[test]
fn what_cannot_be_measured_so_is_bad_input_before_anything_moves() {
    let bench = Bench::start();
    for (x, said) in [
        ("1.2 kg", "\"kg\" is no unit for this, expected m"),
        ("1002", "no unit"),
        ("1002 m", "out of range"),
    ] {
        let (output, out) = bench.run("refused", &answers(x));
        assert_eq!(output.status.code(), Some(2), "{}", shown(&output));
        assert!(shown(&output).contains(said), "{said}: {}", shown(&output));
        assert!(!out.exists());
    }
    let (output, _) = bench.run("nobody", "");
    assert_eq!(output.status.code(), Some(2), "{}", shown(&output));
    // Without line breaks.
    let told: Vec<String> =
        shown(&output).split_whitespace().filter(|word| *word != "|").map(str::to_owned).collect();
    for said in [
        "3 answers are missing and 2 things have to be done",
        "Place the robot at x = 0 m, y = 0 m, with a heading of 0 deg",
        "pose_heading = \"... deg\"",
    ] {
        assert!(told.join(" ").contains(said), "{said}: {}", shown(&output));
    }
}
