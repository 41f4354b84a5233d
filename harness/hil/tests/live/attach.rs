//! Controllers that already run, or that the harness does not start.

use crate::can::plan;
use crate::{hil, out, record, shown, summary};
use skips::in_time;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Time limit of every wait, on a machine with other load.
const LIMIT: Duration = Duration::from_secs(60);

/// A bias test on the table: it needs a controller, and no motion.
const AT_REST: &str = r#"
name = "at-rest"
title = "A bias test"
devices = "paper-table"
steps = [{ bias_test = { duration_s = 3 } }]

[[measurement]]
name = "faults"
doc = "Times that the controller was at fault"
quantity = "health.fault"
unit = "1"
check = { all_within = [0, 100] }
paper = "none"
"#;

/// `hil run` of [`AT_REST`] with a gyro on a pty and an attached controller.
struct Run {
    folder: tempfile::TempDir,
    child: Child,
    out: PathBuf,
}

impl Run {
    fn start(attach: &str, attach_s_max: f64) -> Self {
        let (folder, out) = out("attached");
        let gyro = folder.path().join("gyro.pty");
        let attach = attach.replace("{folder}", &folder.path().to_string_lossy());
        let bench = format!(
            "[gyro]\nport = \"pty:{}\"\nemulated = true\n[controller]\nattach = \"{attach}\"\n\
             [timing]\nattach_s_max = {attach_s_max}\nlate_ms_max = 1000\n",
            gyro.display()
        );
        std::fs::write(folder.path().join("bench.toml"), bench).unwrap();
        let mut run = hil();
        run.args(["run", plan(folder.path(), AT_REST).to_str().unwrap(), "--clock", "real"]);
        run.arg("--bench").arg(folder.path().join("bench.toml")).arg("--out").arg(&out);
        let child = run.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        Self { folder, child, out }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Returns our controller on the gyro's pty, once that exists.
    fn controller(&self) -> Command {
        appears(&self.path("gyro.pty"));
        let mut controller =
            Command::new(Path::new(hil().get_program()).with_file_name("k2a-controller"));
        controller.arg("--gyro").arg(self.path("gyro.pty"));
        controller
    }

    fn end(self) -> (Output, PathBuf, tempfile::TempDir) {
        (self.child.wait_with_output().unwrap(), self.out, self.folder)
    }
}

/// A program that is killed when the test ends.
pub struct Kept(pub Child);

impl Drop for Kept {
    fn drop(&mut self) {
        // It has ended, or is no longer needed.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Waits until the file exists.
#[expect(clippy::disallowed_methods, reason = "another process needs real time to get going")]
pub fn appears(path: &Path) {
    let deadline = Instant::now() + LIMIT;
    while !path.exists() {
        assert!(Instant::now() < deadline, "{} never appeared", path.display());
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn passes(run: Run, place: &str) {
    let (output, out, _folder) = run.end();
    assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
    assert!(shown(&output).contains("waiting for the device under test"), "{}", shown(&output));
    let device = summary(&out)["device_under_test"].as_str().unwrap().to_owned();
    assert!(device.starts_with(&format!("attached at {place}")), "{device}");
    assert!(record(&out).contains("attached to the device under test at"), "no note of it");
}

#[test]
fn a_controller_that_listens_on_a_socket() {
    in_time(|| {
        let run = Run::start("unix:{folder}/missions.sock", 60.0);
        let place = format!("unix:{}", run.path("missions.sock").display());
        let _controller = Kept(run.controller().arg("--listen").arg(&place).spawn().unwrap());
        passes(run, "unix:");
    });
}

/// Any program with missions on stdin and reports on stdout, started in another terminal.
#[test]
fn a_controller_with_its_stdin_and_stdout_on_a_pty() {
    in_time(|| {
        let run = Run::start("pty:{folder}/missions.pty", 60.0);
        let mut controller = run.controller();
        appears(&run.path("missions.pty"));
        let mut both_ways = std::fs::File::options();
        let line = both_ways.read(true).write(true).open(run.path("missions.pty")).unwrap();
        controller.stdin(line.try_clone().unwrap()).stdout(line);
        let _controller = Kept(controller.spawn().unwrap());
        passes(run, "pty:");
    });
}

/// Checks that the run ends with this status and a reason that names the address.
fn ends(run: Run, status: i32, said: &[&str]) {
    let (output, out, _folder) = run.end();
    assert_eq!(output.status.code(), Some(status), "{}", shown(&output));
    let reason = summary(&out)["reason"].as_str().unwrap().to_owned();
    assert!(said.iter().all(|said| reason.contains(said)), "{reason}");
    assert!(record(&out).contains(said[0]), "the record holds the reason");
}

#[test]
fn one_that_never_comes_is_named_by_its_place() {
    let run = Run::start("unix:{folder}/nobody.sock", 1.0);
    ends(run, 3, &["no device under test at unix:", "nobody.sock within 1 s", "No such file"]);
}

#[test]
fn one_that_is_there_and_says_nothing_is_named() {
    in_time(|| {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let place = format!("tcp:{}", listener.local_addr().unwrap());
        ends(
            Run::start(&place, 2.0),
            1,
            &["the device under test at tcp:127.0.0.1:", "said nothing"],
        );
    });
}

#[test]
fn one_that_vanishes_in_the_middle_is_named() {
    in_time(|| {
        let run = Run::start("unix:{folder}/missions.sock", 60.0);
        let place = format!("unix:{}", run.path("missions.sock").display());
        let mut controller = run.controller();
        controller.arg("--listen").arg(&place).env("RUST_LOG", "info").stderr(Stdio::piped());
        let mut controller = Kept(controller.spawn().unwrap());
        let log = std::io::BufReader::new(controller.0.stderr.take().unwrap());
        let mut lines = std::io::BufRead::lines(log).map_while(Result::ok);
        assert!(lines.any(|line| line.contains("a client is there")), "nobody attached");
        drop(controller);
        ends(run, 1, &["the device under test at unix:", "missions.sock is gone: it closed"]);
    });
}

#[test]
fn a_place_that_says_nothing_is_bad_input() {
    let (folder, out) = out("true");
    let bench = folder.path().join("bench.toml");
    std::fs::write(&bench, "[controller]\nattach = true\n").unwrap();
    let mut run = hil();
    run.args(["run", "live-table-run", "--clock", "real", "--bench"]).arg(bench);
    let output = run.arg("--out").arg(out).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", shown(&output));
    assert!(shown(&output).contains("tcp:HOST:PORT"), "{}", shown(&output));
}
