//! What a bench does by commands of its own: power, relays, flashing.

use crate::attach::appears;
use crate::{hil, out, record, shown, summary};
use hil::project::{Template, write};
use plan::Name;
use skips::in_time;
use std::path::Path;
use std::process::{Command, Output};

/// A described oven on a serial line, and a plan with these steps.
pub fn project(folder: &Path, steps: &str) {
    project_on(folder, Template::Serial, steps);
}

fn project_on(folder: &Path, template: Template, steps: &str) {
    if !folder.join("devices").exists() {
        write(folder, &template.files(&Name::new("oven").unwrap())).unwrap();
    }
    let plan = format!(
        "name = \"flashed\"\ntitle = \"The oven with a new firmware\"\ndevice = \"oven\"\nsteps = [{steps}]\n\
         [[measurement]]\nname = \"steps\"\ndoc = \"The longest step\"\nquantity = \"step.duration\"\n\
         unit = \"s\"\ncheck = {{ all_within = {{ at_most = 30 }} }}\n"
    );
    std::fs::write(folder.join("flashed.toml"), plan).unwrap();
}

pub fn command(folder: &Path, bench: &str, out: &Path) -> Command {
    std::fs::write(folder.join("bench.toml"), bench).unwrap();
    let mut run = hil();
    run.args(["run", "./flashed.toml", "--clock", "real", "--bench", "./bench.toml", "--out"]);
    run.arg(out).current_dir(folder);
    run
}

fn run(folder: &Path, bench: &str, out: &Path) -> Output {
    command(folder, bench, out).output().unwrap()
}

/// Without the breaks of its lines.
pub fn told(output: &Output) -> String {
    let words = shown(output);
    let words: Vec<&str> = words.split_whitespace().filter(|word| *word != "|").collect();
    words.join(" ")
}

/// The shell script `script` as a command of the bench.
pub fn shell(name: &str, script: &str, limit_s: f64) -> String {
    format!("[command.{name}]\nrun = [\"sh\", \"-c\", '''{script}''']\ntime_limit_s = {limit_s}\n")
}

/// The process whose number is in that file, once it is there.
fn number_in(path: &Path) -> String {
    appears(path);
    loop {
        let text = std::fs::read_to_string(path).unwrap();
        if text.ends_with('\n') {
            return text.trim().to_owned();
        }
    }
}

/// Does it still run? One that has ended and is not yet waited for does not.
pub fn runs(number: &str) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{number}/stat")).unwrap_or_default();
    status.rsplit(')').next().is_some_and(|rest| !rest.trim().is_empty() && !rest.starts_with(" Z"))
}

#[test]
fn a_plan_has_the_bench_do_what_it_names() {
    in_time(|| {
        let (folder, out) = out("run");
        let folder = folder.path();
        project(
            folder,
            "{ do = \"power-on\" }, { wait = { duration_s = 0.2 } }, { do = \"flash\" }, { do = \"power-on\" }",
        );
        let bench = shell("power-on", "echo on; echo well >&2", 10.0)
            + &shell("flash", "echo \"$HIL_LINES\"; pwd", 10.0);
        let output = run(folder, &bench, &out);
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let summary = summary(&out);
        let commands = summary["commands"].as_array().unwrap();
        let names: Vec<_> = commands.iter().map(|one| (&one["name"], &one["times"])).collect();
        assert_eq!(names, [(&"power-on".into(), &2.into()), (&"flash".into(), &1.into())]);
        assert!(commands.iter().all(|one| one["ended"] == "exit status: 0"), "{summary}");
        let files = ["command-flash.log", "command-power-on.log"];
        assert!(
            files
                .iter()
                .all(|file| summary["artifacts"].as_array().unwrap().contains(&(*file).into()))
        );
        let power = std::fs::read_to_string(out.join("command-power-on.log")).unwrap();
        assert_eq!(power.matches("on\nwell\n").count(), 2, "{power}");
        assert_eq!(power.matches(" s: sh -c echo on").count(), 2, "{power}");
        let flash = std::fs::read_to_string(out.join("command-flash.log")).unwrap();
        assert!(flash.contains("\n{}\n"), "no line but the device's own: {flash}");
        assert!(flash.contains(&*folder.canonicalize().unwrap().to_string_lossy()), "{flash}");
        let record = record(&out);
        for said in ["run `flash` of the bench", "`flash`: exit status: 0, after 0."] {
            assert!(record.contains(said), "{said}: {record}");
        }
        let page = std::fs::read_to_string(out.join("report.html")).unwrap();
        assert!(
            page.contains("Commands of the bench") && page.contains("run `flash` of the bench")
        );
        let listed = hil().args(["list", "benches"]).current_dir(folder).output().unwrap();
        assert!(!shown(&listed).contains("flashed"), "a bench lies in benches/");
    });
}

#[test]
fn a_command_finds_the_bus_of_the_only_device_and_hears_it() {
    in_time(|| {
        let (folder, out) = out("run");
        let folder = folder.path();
        project_on(folder, Template::Can, "{ do = \"listen\" }");
        let script = "echo \"$HIL_LINES\"; exec 3<>can.pty; stty raw -echo <&3; printf \"S6\\rO\\r\" >&3; \
                      head -c 12 <&3 | tr \"\\r\" \"\\n\"";
        let port = folder.join("can.pty");
        let bench = format!("[device]\nport = \"slcan-pty:{}\"\nemulated = true\n", port.display());
        let output = run(folder, &(bench + &shell("listen", script, 10.0)), &out);
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let heard = std::fs::read_to_string(out.join("command-listen.log")).unwrap();
        let place = format!("{{\"device\":{{\"port\":\"slcan:{}\",", port.display());
        assert!(heard.contains(&place) && heard.contains("\nt"), "{heard}");
    });
}

#[test]
fn in_virtual_time_nothing_is_run_and_that_is_said() {
    let (folder, out) = out("run");
    let folder = folder.path();
    project(
        folder,
        "{ repeat = { times = 3, steps = [{ do = \"flash\" }] } }, { wait = { duration_s = 20 } }",
    );
    let output = hil()
        .args(["run", "./flashed.toml", "--out"])
        .arg(&out)
        .current_dir(folder)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
    let said = "flashed: `flash` was not run: in virtual time there is no bench";
    assert!(told(&output).contains(said), "{}", shown(&output));
    assert_eq!(summary(&out)["commands"], serde_json::json!([{ "name": "flash", "times": 0 }]));
    assert_eq!(record(&out).matches("`flash` was not run").count(), 1, "once for all times");
}

#[test]
fn what_the_bench_cannot_do_is_refused_before_anything_runs() {
    let (folder, out) = out("run");
    let folder = folder.path();
    project(folder, "{ do = \"power-on\" }, { do = \"flash\" }");
    let touch = shell("power-on", "touch ran", 10.0);
    let cases = [
        (String::new(), "command `power-on`, which plan flashed does: the bench has no commands"),
        (touch.clone(), "command `flash`, which plan flashed does: the bench has no such command"),
        (touch.clone(), "it has power-on; add to the bench file"),
        (
            format!("{touch}[command.flash]\nrun = [\"no-such-flasher\"]\n"),
            "no-such-flasher is not where PATH leads",
        ),
        (format!("{touch}[command.flash]\nrun = [\"./flash.sh\"]\n"), "./flash.sh is not there"),
        (
            format!("teardown = [\"off\"]\n{touch}"),
            "command `off`, which `teardown` of the bench names",
        ),
    ];
    for (bench, said) in cases {
        let output = run(folder, &bench, &out);
        assert_eq!(output.status.code(), Some(2), "{}", shown(&output));
        assert!(told(&output).contains(said), "{said}: {}", shown(&output));
        assert!(!out.exists() && !folder.join("ran").exists());
    }
    let doctor = hil()
        .args(["doctor", "./flashed.toml", "--bench", "./bench.toml"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert_eq!(doctor.status.code(), Some(3), "{}", shown(&doctor));
    for said in ["command `flash`, which plan flashed does", "command `off`, which `teardown`"] {
        assert!(told(&doctor).contains(said), "{said}: {}", shown(&doctor));
    }
}

#[test]
fn a_command_that_fails_breaks_the_bench() {
    in_time(|| {
        let (folder, out) = out("run");
        let folder = folder.path();
        project(folder, "{ do = \"flash\" }, { wait = { duration_s = 20 } }");
        let bench = shell("flash", "echo erasing; echo no target found >&2; exit 7", 10.0);
        let output = run(folder, &bench, &out);
        assert_eq!(output.status.code(), Some(3), "{}", shown(&output));
        let reason = summary(&out)["reason"].to_string();
        for said in ["the bench command `flash` failed (status 7)", "no target found"] {
            assert!(reason.contains(said), "{reason}");
        }
        assert_eq!(summary(&out)["commands"][0]["ended"], "exit status: 7");
    });
}

#[test]
fn a_command_that_never_ends_is_ended_with_all_that_it_has_started() {
    in_time(|| {
        let (folder, out) = out("run");
        let folder = folder.path();
        project(folder, "{ do = \"flash\" }");
        // Neither it nor its child heeds SIGTERM.
        let script = "trap \"\" TERM; sh -c \"echo \\$\\$ > child; sleep 600; sleep 600\" & echo $$ > parent; while :; do sleep 1; done";
        let output = run(folder, &shell("flash", script, 0.5), &out);
        assert_eq!(output.status.code(), Some(3), "{}", shown(&output));
        let reason = summary(&out)["reason"].to_string();
        assert!(
            reason.contains("the bench command `flash` took longer than its limit of 0.5 s"),
            "{reason}"
        );
        assert_eq!(
            summary(&out)["commands"][0]["ended"],
            "ended after its limit, signal: 9 (SIGKILL)"
        );
        for file in ["child", "parent"] {
            assert!(!runs(&number_in(&folder.join(file))), "the {file} still runs");
        }
    });
}

#[test]
fn megabytes_are_cut_and_told_so() {
    in_time(|| {
        const KEPT_MAX: u64 = 16 * 1_024 * 1_024 + 300;
        let (folder, out) = out("run");
        let folder = folder.path();
        project(folder, "{ do = \"flash\" }, { do = \"flash\" }");
        let output =
            run(folder, &shell("flash", "head -c 12000000 /dev/zero | tr \"\\\\0\" x", 25.0), &out);
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let kept = std::fs::metadata(out.join("command-flash.log")).unwrap().len();
        assert!((16_000_000..KEPT_MAX).contains(&kept), "{kept}");
        let text = std::fs::read_to_string(out.join("command-flash.log")).unwrap();
        assert!(text.contains("[the rest was not kept]"));
    });
}

#[test]
fn who_stops_the_run_or_limits_the_step_stops_the_command() {
    in_time(|| {
        let (folder, out) = out("run");
        let folder = folder.path();
        let bench = shell("flash", "echo $$ > number; sleep 600; sleep 600", 300.0);
        project(folder, "{ do = \"flash\" }");
        let run_under_way = command(folder, &bench, &out).spawn().unwrap();
        let number = number_in(&folder.join("number"));
        let interrupt =
            Command::new("kill").args(["-INT", &run_under_way.id().to_string()]).status();
        assert!(interrupt.unwrap().success());
        let output = run_under_way.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(5), "{}", shown(&output));
        assert!(!runs(&number));
        let ended = summary(&out)["commands"][0]["ended"].to_string();
        assert!(ended.contains("ended with the run"), "{ended}");

        std::fs::remove_file(folder.join("number")).unwrap();
        project(folder, "{ do = \"flash\", time_limit_s = 0.5 }");
        let output = run(folder, &bench, &out);
        assert_eq!(output.status.code(), Some(4), "{}", shown(&output));
        assert!(!runs(&number_in(&folder.join("number"))));
    });
}

#[test]
fn a_bench_is_set_up_before_its_ports_are_opened_and_torn_down_after() {
    in_time(|| {
        let (folder, out) = out("run");
        let folder = folder.path();
        project(folder, "{ wait = { duration_s = 0.5 } }");
        // The device appears with the power: a second harness emulates it.
        let emulate = format!(
            "{} emulate device ./devices/oven.toml --pty ./oven.pty > emulated 2>&1 < /dev/null & echo $! > number; \
             until test -e oven.pty; do sleep 0.05; done",
            hil().get_program().to_string_lossy()
        );
        std::fs::write(folder.join("on.sh"), format!("setsid sh -c '{emulate}'\n")).unwrap();
        let bench = "setup = [\"on\"]\nteardown = [\"off\"]\n[device]\nport = \"./oven.pty\"\n"
            .replace("\"./oven.pty\"", &format!("{:?}", folder.join("oven.pty")))
            + "[command.on]\nrun = [\"sh\", \"on.sh\"]\n"
            + &shell("off", "kill $(cat number); echo off", 10.0);
        let output = run(folder, &bench, &out);
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let commands = summary(&out)["commands"].clone();
        assert_eq!((&commands[0]["name"], &commands[1]["name"]), (&"on".into(), &"off".into()));
        assert!(
            std::fs::read_to_string(out.join("command-off.log"))
                .unwrap()
                .contains("# after the run: sh")
        );
        assert!(record(&out).contains("`on`: exit status: 0"));

        // What does not come up is torn down all the same.
        let fails = "setup = [\"on\"]\nteardown = [\"off\"]\n".to_owned()
            + &shell("on", "echo no hub; exit 1", 10.0)
            + &shell("off", "touch torn-down", 10.0);
        let output = run(folder, &fails, &out);
        assert_eq!(output.status.code(), Some(3), "{}", shown(&output));
        let said = "failed to set the bench up: the bench command `on` failed (status 1): no hub";
        assert!(told(&output).contains(said), "{}", shown(&output));
        assert!(folder.join("torn-down").exists());

        // Build servers see it, and so does who looks into the folder later.
        assert_eq!(
            (&summary(&out)["outcome"], &summary(&out)["clock"]),
            (&"error".into(), &"real".into())
        );
        let junit = std::fs::read_to_string(out.join("junit.xml")).unwrap();
        assert!(junit.contains("errors=\"1\"") && junit.contains("no hub"), "{junit}");
        let check = hil().arg("check").arg(&out).output().unwrap();
        assert_eq!(check.status.code(), Some(3), "{}", shown(&check));
        assert!(!told(&check).contains("killed"), "{}", shown(&check));
        let mut missing = command(folder, "[device]\nport = \"/dev/no-such-port\"\n", &out);
        let markdown = folder.join("summary.md");
        let output = missing.args(["--summary"]).arg(&markdown).output().unwrap();
        assert_eq!(output.status.code(), Some(3), "{}", shown(&output));
        assert!(summary(&out)["reason"].to_string().contains("/dev/no-such-port"));
        let table = std::fs::read_to_string(markdown).unwrap();
        assert!(table.contains("flashed: error"), "{table}");

        // A bench that cannot be switched off is broken, even after a run that passed.
        let fails = "teardown = [\"off\"]\n".to_owned() + &shell("off", "exit 1", 10.0);
        let output = run(folder, &fails, &out);
        assert_eq!(output.status.code(), Some(3), "{}", shown(&output));
        let reason = summary(&out)["reason"].to_string();
        assert!(reason.contains("the bench command `off` failed (status 1)"), "{reason}");
    });
}
