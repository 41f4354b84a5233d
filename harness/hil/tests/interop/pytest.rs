//! The pytest plugin and the python-can interface (`python/`), on `examples/pytest`, run as a user's pytest does.

use super::python_package::python_path;
use super::rig::{file, python_with, shown};
use skips::in_time;
use std::fs;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// A copy of the example, and the place of the installed package.
struct Project {
    python: PathBuf,
    folder: TempDir,
}

impl Project {
    /// Returns `None` if Python lacks packages.
    fn new() -> Option<Self> {
        let imports = "import can, cantools, pytest, serial, xdist";
        let packages = "pytest, pytest-xdist, pyserial, python-can and cantools";
        let python = python_with(imports, packages)?;
        let folder = tempfile::tempdir().unwrap();
        copy(&file("examples/pytest"), folder.path());
        Some(Self { python, folder })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn replace(&self, name: &str, what: &str, by: &str) {
        let text = fs::read_to_string(self.path(name)).unwrap();
        assert!(text.contains(what), "{text}");
        fs::write(self.path(name), text.replace(what, by)).unwrap();
    }

    fn pytest(&self, arguments: &[&str]) -> Output {
        self.command(&["-m", "pytest"], arguments).output().unwrap()
    }

    /// `how` starts pytest.
    fn command(&self, how: &[&str], arguments: &[&str]) -> Command {
        let python_path = python_path(&self.path("site")).unwrap();
        // Programs under test are started as `python3`.
        let known = std::env::var_os("PATH").unwrap_or_default();
        let first = self.python.parent().unwrap().to_owned();
        let path = [first].into_iter().chain(std::env::split_paths(&known));
        let mut command = Command::new(&self.python);
        command.args(how).args(["-p", "no:cacheprovider"]).args(arguments);
        command.current_dir(&self.folder).env("HIL", env!("CARGO_BIN_EXE_hil"));
        command.env("PYTHONPATH", python_path).env("PATH", std::env::join_paths(path).unwrap());
        command.env("PYTHONDONTWRITEBYTECODE", "1").env_remove("HIL_LINES");
        command
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let to = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            if entry.file_name() != "runs" {
                copy(&entry.path(), &to);
            }
        } else {
            fs::copy(entry.path(), to).unwrap();
        }
    }
}

/// Counts occurrences of `what` in `text`.
fn count(text: &str, what: &str) -> usize {
    text.matches(what).count()
}

#[test]
fn verdicts_are_tests_and_programs_find_their_lines_in_virtual_and_in_real_time() {
    in_time(|| {
        let Some(project) = Project::new() else { return };
        let output = project.pytest(&["-v", "--junitxml", "pytest.xml"]);
        let shown = shown(&output);
        assert!(output.status.success(), "{shown}");
        for passed in [
            "plans/settles.toml::time_to_heat PASSED",
            "plans/thermostat.toml::run PASSED",
            "plans/thermostat.toml::never too hot PASSED",
            "test_device.py::test_the_heater_follows_its_command PASSED",
            "test_seeds.py::test_other_noise_passes_too[4] PASSED",
        ] {
            assert!(shown.contains(passed), "no {passed} in {shown}");
        }
        assert!(shown.contains("12 passed"), "{shown}");
        let junit = fs::read_to_string(project.path("pytest.xml")).unwrap();
        for part in [
            r#"<testcase classname="plans.settles.toml" name="temperature_held""#,
            r#"<property name="verdict" value="time_to_heat: measured "#,
            "runs/thermostat-seed1/report.html",
        ] {
            assert!(junit.contains(part), "no {part} in {junit}");
        }
    });
}

#[test]
fn a_verdict_that_fails_fails_its_test_and_no_other() {
    let Some(project) = Project::new() else { return };
    project.replace("plans/settles.toml", "at_most = 150", "at_most = 15");
    let output = project.pytest(&["plans/settles.toml", "--junitxml", "pytest.xml"]);
    let shown = shown(&output);
    assert_eq!(output.status.code(), Some(1), "{shown}");
    assert!(shown.contains("1 failed, 3 passed"), "{shown}");
    assert!(shown.contains("FAILED plans/settles.toml::time_to_heat"), "{shown}");
    assert!(shown.contains("band at most 15 s: fail"), "{shown}");
    let junit = fs::read_to_string(project.path("pytest.xml")).unwrap();
    assert_eq!(count(&junit, "<failure "), 1, "{junit}");
    // The user's own assertion shows the verdicts, and not the address of an object.
    let output = self::shown(&project.pytest(&["test_seeds.py"]));
    assert!(output.contains("3 failed") && output.contains("AssertionError: settle"), "{output}");
    assert!(output.contains("2 passed, 1 failed") && !output.contains("Run object at"), "{output}");
    // Found by a user: an object is true, whatever its verdict.
    let test = "def test_it(run):\n    done = run('plans/settles.toml')\n    assert not done\n\
                \x20   verdicts = {name: bool(one) for name, one in done.measurements.items()}\n\
                \x20   assert verdicts.pop('time_to_heat') is False and all(verdicts.values())\n";
    fs::write(project.path("test_truth.py"), test).unwrap();
    let output = self::shown(&project.pytest(&["test_truth.py"]));
    assert!(output.contains("1 passed"), "{output}");
}

/// A test that a shell runs in the background inherits that SIGINT is ignored.
const AS_FROM_A_TERMINAL: &str = "import pytest, signal, sys; \
    signal.signal(signal.SIGINT, signal.default_int_handler); sys.exit(pytest.console_main())";

/// A terminal sends Ctrl-C to all that runs in it, an editor to pytest alone. The run still sends its `finally` and leaves
/// its files.
#[test]
#[expect(clippy::disallowed_methods, reason = "waits for another process")]
fn ctrl_c_ends_the_run_in_order() {
    use rustix::process::{Pid, Signal, kill_process, kill_process_group};
    for interrupt in [kill_process_group, kill_process] {
        let Some(project) = Project::new() else { return };
        let arguments = ["plans/settles.toml", "--hil-clock", "real"];
        let mut command = project.command(&["-c", AS_FROM_A_TERMINAL], &arguments);
        let child = command.process_group(0).stdout(Stdio::piped()).spawn().unwrap();
        let run = project.path("runs/settles-seed1");
        while !run.join("record.hilrec").exists() {
            std::thread::sleep(Duration::from_millis(20));
        }
        interrupt(Pid::from_child(&child), Signal::INT).unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", shown(&output));
        let summary = fs::read_to_string(run.join("summary.json")).unwrap();
        assert!(summary.contains(r#""outcome": "aborted""#), "{summary}");
    }
}

#[test]
fn a_property_that_was_never_put_to_the_test_warns() {
    let Some(project) = Project::new() else { return };
    let never = "[[property]]\nname = \"cools\"\n\
        always = \"rises(Temperature > 90 degC) -> within 1 s: Temperature < 90 degC\"\n\n[[envelope]]";
    project.replace("plans/settles.toml", "[[envelope]]", never);
    let output = project.pytest(&["plans/settles.toml", "--junitxml", "pytest.xml"]);
    let shown = shown(&output);
    assert!(output.status.success(), "{shown}");
    assert!(shown.contains("5 passed, 1 warning"), "{shown}");
    let told = "cools: held, but was never put to the test: `rises(Temperature > 90 degC)` was true at no moment";
    assert!(shown.contains(&format!("NeverTested: settles.toml: {told}")), "{shown}");
    let junit = fs::read_to_string(project.path("pytest.xml")).unwrap();
    let told = told.replace('>', "&gt;");
    assert!(junit.contains(&format!("name=\"verdict\" value=\"{told}")), "{junit}");
}

#[test]
fn a_measurement_may_be_called_run_and_a_plan_must_exist() {
    let Some(project) = Project::new() else { return };
    project.replace("plans/settles.toml", "at_most = 150", "at_most = 15");
    project.replace("plans/settles.toml", "name = \"time_to_heat\"", "name = \"run\"");
    let failed = shown(&project.pytest(&["plans/settles.toml"]));
    assert!(failed.contains("1 failed, 3 passed"), "{failed}");
    assert!(failed.contains("band at most 15 s: fail"), "{failed}");

    let test = "def test_it(run):\n    run('plans/nope.toml')\n";
    fs::write(project.path("test_nope.py"), test).unwrap();
    let missing = shown(&project.pytest(&["test_nope.py"]));
    assert!(missing.contains("1 failed") && missing.contains("nope.toml"), "{missing}");
}

#[test]
fn options_choose_and_stop_as_with_other_tests() {
    let Some(project) = Project::new() else { return };
    let chosen = shown(&project.pytest(&["plans", "-k", "temperature_held", "--hil-seed", "7"]));
    assert!(chosen.contains("2 passed") && chosen.contains("seed 7"), "{chosen}");
    assert!(project.path("runs/settles-seed7/summary.json").is_file());

    project.replace("plans/settles.toml", "at_most = 150", "at_most = 15");
    project.replace("plans/settles.toml", "band = [58, 61]", "band = [58, 59]");
    let stopped = shown(&project.pytest(&["plans/settles.toml", "-x"]));
    assert!(stopped.contains("1 failed, 1 passed"), "{stopped}");
}

#[test]
fn plans_of_one_name_have_run_folders_of_their_own_and_a_seed_of_a_plan_is_its_own() {
    let Some(project) = Project::new() else { return };
    let text = fs::read_to_string(project.path("plans/settles.toml")).unwrap();
    copy(&project.path("plans/devices"), &project.path("plans/other/devices"));
    // With the mark that some editors put before a text.
    fs::write(project.path("plans/other/settles.toml"), format!("\u{feff}seed = 7\n{text}"))
        .unwrap();
    let both = shown(&project.pytest(&["plans/settles.toml", "plans/other/settles.toml"]));
    assert!(both.contains("8 passed"), "{both}");
    assert!(project.path("runs/plans-settles-seed1/summary.json").is_file(), "{both}");
    assert!(project.path("runs/plans-other-settles-seed7/summary.json").is_file(), "{both}");
    let summary = fs::read_to_string(project.path("runs/plans-other-settles-seed7/summary.json"));
    assert!(summary.unwrap().contains("\"seed\": 7"));

    // What a campaign found is no test of the project, wherever its folder is.
    fs::create_dir_all(project.path("found")).unwrap();
    fs::write(project.path("found/campaign.json"), "{}").unwrap();
    fs::write(project.path("found/case.toml"), text).unwrap();
    let collected = shown(&project.pytest(&["--collect-only", "-q"]));
    assert!(collected.contains("plans/settles.toml::run"), "{collected}");
    assert!(!collected.contains("found/case.toml"), "{collected}");
}

#[test]
fn the_seed_zero_is_a_seed_and_a_bench_lies_beside_its_test() {
    let Some(project) = Project::new() else { return };
    let test = "\
def test_seeds(rig):
    for seed in (0, 3):
        one = rig('plans/rigs/oven.toml', seed=seed)
        words = open(f'/proc/{one.pid}/cmdline').read().split('\\0')
        assert words[words.index('--seed') + 1] == str(seed), words
        one.stop()

def test_bench(run):
    made = run('../plans/settles.toml', clock='real', bench='none/such.toml')
";
    fs::create_dir_all(project.path("below")).unwrap();
    fs::write(project.path("below/test_it.py"), test.replace("'plans/rigs", "'../plans/rigs"))
        .unwrap();
    let output = shown(&project.pytest(&["below/test_it.py"]));
    assert!(output.contains("1 passed") || output.contains("1 failed, 1 passed"), "{output}");
    assert!(output.contains("below/none/such.toml"), "{output}");
}

#[test]
fn a_mistake_in_a_plan_and_a_bench_that_breaks_are_errors_and_no_failures() {
    let Some(project) = Project::new() else { return };
    project.replace("plans/settles.toml", "Setpoint = 60", "Setpiont = 60");
    let wrong = shown(&project.pytest(&["plans/settles.toml"]));
    assert!(wrong.contains("4 errors") && wrong.contains("Setpiont"), "{wrong}");
    assert!(!wrong.contains("failed,"), "{wrong}");

    let no_toml = project.path("plans/broken.toml");
    for text in [&b"steps = [\n"[..], b"  [[steps]]\nwait = \n", b"[[steps]]\n# K\xe4fer\n"] {
        fs::write(&no_toml, text).unwrap();
        let broken = project.pytest(&["plans"]);
        assert_eq!(broken.status.code(), Some(2), "{}", shown(&broken));
    }

    // A program that ends early fails the test.
    project.replace("plans/thermostat.py", "import cantools", "import no_such_module");
    let ended = shown(&project.pytest(&["plans/thermostat.toml"]));
    assert!(ended.contains("FAILED plans/thermostat.toml::run"), "{ended}");
    assert!(ended.contains("no_such_module"), "{ended}");
}

#[test]
fn workers_side_by_side_make_a_run_once() {
    let Some(project) = Project::new() else { return };
    let counting = "import os\nopen('starts', 'a').write('x')\n";
    let program = fs::read_to_string(project.path("plans/thermostat.py")).unwrap();
    let program = program.replacen("import time\n", &format!("import time\n{counting}"), 1);
    fs::write(project.path("plans/thermostat.py"), program).unwrap();
    let output = project.pytest(&["plans/thermostat.toml", "-n", "2", "--dist", "load"]);
    assert!(output.status.success(), "{}", shown(&output));
    assert!(shown(&output).contains("4 passed"), "{}", shown(&output));
    assert_eq!(fs::read_to_string(project.path("starts")).unwrap(), "x");
}

#[test]
fn a_line_that_is_not_there_is_named_with_those_that_are() {
    let Some(project) = Project::new() else { return };
    let test = "\
import can, os, pytest, subprocess, sys
import hil

def test_lines(rig):
    one = rig('plans/rigs/oven.toml')
    assert one.lines['can0'].bit_rate == 500_000
    with pytest.raises(can.CanInitializationError, match=\"'can1'.*can0\"):
        can.Bus(interface='hil', channel='can1')
    assert 'temperature' in str(one.ask(get=['temperature'], device='oven'))
    with pytest.raises(hil.RigError, match='failed to read the request'):
        one.ask(get='no such thing')
    # A program beside finds it by the file alone.
    env = {name: value for name, value in os.environ.items() if name != 'HIL_LINES'}
    ask = 'import hil; print(hil.line(\"can0\", pid=%d).kind)' % one.pid
    told = subprocess.run([sys.executable, '-c', ask], env=env, capture_output=True, text=True)
    assert told.stdout.strip() == 'slcan', told
    one.stop()
    assert one.pid not in hil.running()
    with pytest.raises(hil.RigError, match='failed to read .*none.toml: No such file'):
        rig('plans/none.toml')
";
    fs::write(project.path("test_lines.py"), test).unwrap();
    let output = project.pytest(&["test_lines.py"]);
    assert!(output.status.success(), "{}", shown(&output));
}
