//! Bus logs with custom devices: imported as runs, and as the traffic of a node.

use super::hil::{Hil, Ran};
use std::fs;

/// Runs `hil` with these arguments in the project.
pub fn within(hil: &Hil, arguments: &[&str]) -> Ran {
    Ran::of(hil.command(arguments).current_dir(hil.path("oven")).output().unwrap())
}

/// Creates the project of an oven, with a run and the log of its bus.
fn recorded() -> Hil {
    let hil = Hil::new();
    hil.run(&["new", "oven"]).exits(0);
    within(&hil, &["run", "settles.toml", "--out", "run", "--record", "full"]).exits(0);
    within(&hil, &["export", "run", "--bus", "rigs/oven.log"]).exits(3);
    fs::create_dir(hil.path("oven/rigs")).unwrap();
    within(&hil, &["export", "run", "--bus", "rigs/oven.log"]).exits(0);
    hil
}

/// Name, value and observations of each measurement.
pub fn figures(hil: &Hil, run: &str) -> Vec<(String, Option<f64>, u64)> {
    let summary = fs::read(hil.path("oven").join(run).join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
    let of = |one: &serde_json::Value| {
        let name = one["name"].as_str().unwrap().to_owned();
        (name, one["value"].as_f64(), one["observations"].as_u64().unwrap())
    };
    summary["measurements"].as_array().unwrap().iter().map(of).collect()
}

#[test]
fn a_log_of_a_run_is_judged_as_the_run_was() {
    let hil = recorded();
    let import = ["import", "rigs/oven.log", "--plan", "settles.toml", "--out", "again"];
    let imported = within(&hil, &import).exits(0);
    let acts = "nothing was done to a device: the log is assumed to show the effects of `send`";
    assert!(imported.out.contains(acts), "{}", imported.out);
    let summary = fs::read(hil.path("oven/again/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
    let [took_s, bench_s] = ["wall_s", "simulated_s"].map(|key| summary[key].as_f64().unwrap());
    assert!(took_s > 0.0 && took_s < 0.5 * bench_s, "it took {took_s} s, and the run {bench_s} s");
    let (was, is) = (figures(&hil, "run"), figures(&hil, "again"));
    assert!(!was.is_empty() && was.len() == is.len());
    for (was, is) in was.iter().zip(&is) {
        assert_eq!(was.0, is.0);
        // A log has microseconds: a frame at the edge of a step may fall on its other side.
        assert!(was.2.abs_diff(is.2) <= 1, "{}: {} and {}", was.0, was.2, is.2);
        let (was, is) = (was.1.unwrap(), is.1.unwrap());
        assert!((was - is).abs() <= 0.02 * was.abs().max(1.0), "{was} {is}");
    }
    // Each frame has the time that it has in the log, and its place.
    within(&hil, &["export", "again", "--bus", "again.log"]).exits(0);
    let frames = |log: &str| {
        let text = fs::read_to_string(hil.path("oven").join(log)).unwrap();
        let of = |line: &str| {
            let (at, frame) = line.strip_prefix('(').unwrap().split_once(") ").unwrap();
            (at.parse::<f64>().unwrap(), frame.to_owned())
        };
        let frames: Vec<_> = text.lines().map(of).collect();
        let begins = frames[0].0;
        let since = |(at, frame): (f64, String)| (((at - begins) * 1e6).round(), frame);
        frames.into_iter().map(since).collect::<Vec<_>>()
    };
    let (was, is) = (frames("rigs/oven.log"), frames("again.log"));
    assert!(was.len().abs_diff(is.len()) <= 2, "{} {}", was.len(), is.len());
    for (was, is) in was.iter().zip(&is) {
        assert!((was.0 - is.0).abs() <= 1.0 && was.1 == is.1, "{was:?} {is:?}");
    }
    within(&hil, &["check", "again"]).exits(0);
    let shown = within(&hil, &["show", "again", "--device", "device", "--limit", "1"]).exits(0);
    assert!(shown.out.contains("frame"), "{}", shown.out);
    // A part of the log covers only a part of the plan.
    let log = fs::read_to_string(hil.path("oven/rigs/oven.log")).unwrap();
    let half: Vec<&str> = log.lines().take(log.lines().count() / 20).collect();
    fs::write(hil.path("oven/half.log"), half.join("\n")).unwrap();
    let ran = within(&hil, &["import", "half.log", "--plan", "settles.toml", "--out", "half"]);
    let ran = ran.exits(1);
    assert!(ran.out.contains("took longer than its limit"), "{}", ran.out);
}

#[test]
fn a_log_plays_the_part_of_a_node() {
    let hil = recorded();
    let dbc = fs::read_to_string(hil.path("oven/devices/oven.dbc")).unwrap();
    fs::write(hil.path("oven/rigs/oven.dbc"), dbc).unwrap();
    let rig = |replay: &str| {
        let rig = format!(
            "[[line]]\nname = \"can0\"\ncan = {{ dbc = \"oven.dbc\" }}\n\
             [[node]]\nname = \"oven\"\nat = \"can0\"\nreplay = {replay}\n\
             [[node]]\nname = \"tester\"\nat = \"can0\"\ntester = true\n"
        );
        fs::write(hil.path("oven/rigs/replayed.toml"), rig).unwrap();
    };
    let plan = "name = \"warm\"\ntitle = \"It gets warm in the log\"\nrig = \"replayed\"\n\
        steps = [{ wait_until = { above = { quantity = \"oven.Temperature\", limit = 50 } } }]\n\
        [[measurement]]\nname = \"warmest\"\ndoc = \"The warmest that it was\"\n\
        quantity = \"oven.Temperature\"\nunit = \"degC\"\ncheck = { all_within = { at_most = 61 } }\n";
    fs::write(hil.path("oven/warm.toml"), plan).unwrap();
    rig("{ log = \"oven.log\" }");
    within(&hil, &["run", "warm.toml", "--out", "warm", "--record", "full"]).exits(0);
    // Frames of the log's tester are not the oven's.
    let shown = within(&hil, &["show", "warm"]).exits(0);
    assert!(!shown.out.lines().any(|line| line.contains(" tester ") && line.contains("frame")));
    // The run says what is doubtful in the log.
    let log = fs::read_to_string(hil.path("oven/rigs/oven.log")).unwrap();
    fs::write(hil.path("oven/rigs/cut.log"), log.trim_end()).unwrap();
    rig("{ log = \"cut.log\" }");
    within(&hil, &["run", "warm.toml", "--out", "cut"]).exits(0);
    let told = fs::read_to_string(hil.path("oven/cut/summary.json")).unwrap();
    assert_eq!(told.matches("cut.log: the last line has no line break").count(), 1, "{told}");
    rig("{ log = \"oven.log\", channel = \"can7\" }");
    let wrong = within(&hil, &["run", "warm.toml"]).exits(2);
    assert!(wrong.err.contains("which channel of") && wrong.err.contains("can0"), "{}", wrong.err);
    rig("{ log = \"none.log\" }");
    assert!(within(&hil, &["run", "warm.toml"]).exits(2).err.contains("none.log"));
    fs::write(hil.path("oven/rigs/bad.log"), "what is this\n").unwrap();
    rig("{ log = \"bad.log\" }");
    assert!(within(&hil, &["run", "warm.toml"]).exits(2).err.contains("bad.log"));
    rig("{ log = \"oven.BLF\" }");
    let binary = within(&hil, &["run", "warm.toml"]).exits(2).err;
    assert!(binary.contains("`oven.BLF` is no text") && binary.contains("hil log convert"));
    rig("{ log = \"oven.dbc\" }");
    assert!(within(&hil, &["run", "warm.toml"]).exits(2).err.contains("hil log convert"));
}

const ONE_OVEN: &str = "[[line]]\nname = \"can0\"\ncan = {}\n[[node]]\nname = \"oven\"\nat = \"can0\"\nemulate = \"oven\"\n";

/// Without the signal.
const SCALE: &str = "name = \"scale\"\ntitle = \"A scale\"\nsource = \"invented\"\n\n[serial]\nbaud = 9600\n\n\
    [[message]]\nname = \"Status\"\nsent_by = \"device\"\nstart = [0xa5, 0x02]\nperiod_s = 0.1\n\
    fields = [{ name = \"Weight\", type = \"u16\", unit = \"kg\" }]\n\n";

const WARMEST: &str = "[[measurement]]\nname = \"warmest\"\ndoc = \"How warm it was\"\n\
    quantity = \"oven.Temperature\"\nunit = \"degC\"\ncheck = { all_within = [0, 200] }\n";

#[test]
fn a_plan_that_outlasts_the_log_fails_and_times_that_go_back_are_told() {
    let hil = recorded();
    fs::create_dir_all(hil.path("oven/rigs")).unwrap();
    fs::write(hil.path("oven/rigs/one.toml"), ONE_OVEN).unwrap();
    let plan = |duration_s: u32| {
        let plan = format!(
            "name = \"waits\"\ntitle = \"\"\nrig = \"one\"\n\
             steps = [{{ wait = {{ duration_s = {duration_s} }} }}]\n{WARMEST}"
        );
        fs::write(hil.path("oven/waits.toml"), plan).unwrap();
    };
    plan(5);
    let import =
        |log: &str| within(&hil, &["import", log, "--plan", "waits.toml", "--out", "waits"]);
    import("rigs/oven.log").exits(0);
    plan(100_000);
    let long = import("rigs/oven.log").exits(1).out;
    assert!(long.contains("waits: failed: the log ends at "), "{long}");
    assert!(long.contains("before the plan, which took 100000.000 s"), "{long}");
    let again = within(&hil, &["check", "waits"]).exits(1).out;
    assert!(again.contains("the log ends at "), "{again}");

    plan(5);
    let log = fs::read_to_string(hil.path("oven/rigs/oven.log")).unwrap();
    let mut lines: Vec<&str> = log.lines().collect();
    lines.swap(3, 6);
    lines.swap(0, 1);
    fs::write(hil.path("oven/mixed.log"), lines.join("\n") + "\n").unwrap();
    let mixed = import("mixed.log").exits(0).out;
    assert!(mixed.contains("4 entries are earlier than one before, by up to "), "{mixed}");
    // Found by a user: two channels that a logger had written in turns broke what sound traffic holds.
    let sorted = fs::read_to_string(hil.path("oven/waits/summary.json")).unwrap();
    import("rigs/oven.log").exits(0);
    let right = fs::read_to_string(hil.path("oven/waits/summary.json")).unwrap();
    let measured = |summary: &str| {
        let summary: serde_json::Value = serde_json::from_str(summary).unwrap();
        summary["measurements"].clone()
    };
    assert_eq!(measured(&sorted), measured(&right));
    let at_once = |line: &str| format!("(0.000000) {}\n", line.split_once(") ").unwrap().1);
    let same: String = log.lines().take(5).map(at_once).collect();
    let rest: String = log.lines().skip(5).map(|line| line.to_owned() + "\n").collect();
    fs::write(hil.path("oven/same.log"), same + &rest).unwrap();
    let same = import("same.log").exits(0).out;
    assert!(!same.contains("earlier"), "{same}");
}

#[test]
fn both_ends_of_a_serial_line_come_back_from_a_log() {
    let hil = recorded();
    let tare = "[[message]]\nname = \"Tare\"\nsent_by = \"host\"\nstart = [0xa5, 0x01]\n\
        fields = [{ name = \"By\", type = \"u16\", unit = \"kg\" }]\n\n\
        [signal.Weight]\nexpression = \"12 - By\"\n";
    fs::write(hil.path("oven/devices/scale.toml"), format!("{SCALE}{tare}")).unwrap();
    let rig = "[[line]]\nname = \"uart\"\nserial = {}\n\
        [[node]]\nname = \"scale\"\nat = \"uart\"\nemulate = \"scale\"\n\
        [[node]]\nname = \"desk\"\nat = \"uart\"\ntester = true\n";
    fs::write(hil.path("oven/rigs/uart.toml"), rig).unwrap();
    let plan = |send: &str| {
        format!(
            "name = \"uart\"\ntitle = \"\"\nrig = \"uart\"\nsteps = [{send} {{ wait = {{ duration_s = 1 }} }}]\n\
             [[property]]\nname = \"answers\"\nalways = \"rises(desk.By == 5) -> within 300 ms: scale.Weight == 7\"\n\
             [[property]]\nname = \"tared\"\nsometimes = \"desk.By == 5\"\n"
        )
    };
    let sends = "{ send = { message = \"Tare\", set = { By = 5 }, every_s = 0 } },";
    fs::write(hil.path("oven/uart.toml"), plan(sends)).unwrap();
    within(&hil, &["run", "uart.toml", "--record", "full", "--out", "u"]).exits(0);
    let frames_alone = within(&hil, &["export", "u", "--bus", "u.log"]).exits(2);
    assert!(frames_alone.err.contains("--bus FILE.pcapng"), "{}", frames_alone.err);
    assert!(!hil.path("oven/u.log").exists(), "a log that holds nothing is not written");
    within(&hil, &["export", "u", "--bus", "u.pcapng"]).exits(0);
    fs::write(hil.path("oven/heard.toml"), plan("")).unwrap();
    within(&hil, &["import", "u.pcapng", "--plan", "heard.toml", "--out", "i"]).exits(0);
    // The plan's side of a bench with one device is on that one's line.
    let plan = format!(
        "name = \"alone\"\ntitle = \"\"\ndevice = \"scale\"\nsteps = [{sends} {{ wait = {{ duration_s = 1 }} }}]\n\
         [[property]]\nname = \"tared\"\nsometimes = \"Weight == 7\"\n"
    );
    fs::write(hil.path("oven/alone.toml"), plan).unwrap();
    within(&hil, &["run", "alone.toml", "--record", "full", "--out", "a"]).exits(0);
    let was = within(&hil, &["export", "a", "--bus", "a.pcapng"]).exits(0).err;
    within(&hil, &["import", "a.pcapng", "--plan", "alone.toml", "--out", "b"]).exits(0);
    let shown = within(&hil, &["show", "b", "--device", "plan"]).exits(0).out;
    assert!(shown.contains("bytes a5 01 05 00"), "{was}{shown}");
}

#[test]
fn a_log_without_bytes_leaves_a_serial_line_silent() {
    let hil = recorded();
    let weight = "[signal.Weight]\nexpression = \"12\"\n";
    fs::write(hil.path("oven/devices/scale.toml"), format!("{SCALE}{weight}")).unwrap();
    let rig = "[[line]]\nname = \"can0\"\ncan = {}\n[[line]]\nname = \"uart\"\nserial = {}\n\
        [[node]]\nname = \"oven\"\nat = \"can0\"\nemulate = \"oven\"\n\
        [[node]]\nname = \"scale\"\nat = \"uart\"\nemulate = \"scale\"\n";
    fs::write(hil.path("oven/rigs/both.toml"), rig).unwrap();
    let plan = format!(
        "name = \"both\"\ntitle = \"\"\nrig = \"both\"\nsteps = [{{ wait = {{ duration_s = 5 }} }}]\n{WARMEST}"
    );
    fs::write(hil.path("oven/both.toml"), &plan).unwrap();
    let import = || within(&hil, &["import", "rigs/oven.log", "--plan", "both.toml", "--out", "b"]);
    let heard = import().exits(0).out;
    assert!(heard.contains("the log holds nothing of the serial line uart"), "{heard}");
    let weight = "[[property]]\nname = \"light\"\nalways = \"scale.Weight < 20 kg\"\n";
    fs::write(hil.path("oven/both.toml"), plan + weight).unwrap();
    let unheard = import().exits(1).out;
    assert!(unheard.contains("light is not judged: the log holds nothing of the"), "{unheard}");
}

#[test]
fn what_is_left_out_of_a_log_or_not_judged_is_told() {
    let hil = recorded();
    fs::write(hil.path("oven/rigs/one.toml"), ONE_OVEN).unwrap();
    let plan =
        "name = \"short\"\ntitle = \"\"\nrig = \"one\"\nsteps = [{ wait = { duration_s = 2 } }]\n";
    fs::write(hil.path("oven/short.toml"), format!("{plan}{WARMEST}")).unwrap();
    let log = fs::read_to_string(hil.path("oven/rigs/oven.log")).unwrap();
    let later = |line: &str| {
        let (at, frame) = line.strip_prefix('(').unwrap().split_once(") ").unwrap();
        format!("({:.6}) {frame}\n", at.parse::<f64>().unwrap() + 100.0)
    };
    let mut log: String = log.lines().take(40).map(later).collect();
    log += "(102.050000) can0 7FF#00\n(102.100000) can0 20000004#0000000000000000\n";
    fs::write(hil.path("oven/rest.log"), &log).unwrap();
    let import = ["import", "rest.log", "--plan", "short.toml", "--from-first", "--out"];
    let ran = within(&hil, &[&import[..], &["short"]].concat());
    for told in [
        "1 error frame of the log left out",
        "frames of can0 left out that no node of the rig sends: 0x100 (21), 0x7ff (1)",
        " after the end of the plan ",
    ] {
        assert!(ran.out.contains(told), "{told}: {}", ran.out);
    }
    assert!(!ran.out.contains("nothing was done to a device"), "{}", ran.out);
    let reversed: Vec<&str> = log.lines().rev().collect();
    fs::write(hil.path("oven/rest.log"), reversed.join("\n") + "\n").unwrap();
    let ran = within(&hil, &[&import[..], &["back"]].concat());
    assert!(!ran.out.contains("the log begins at "), "{}", ran.out);
    let ran = within(&hil, &["import", "rest.log", "--plan", "short.toml", "--out", "late"]);
    assert!(ran.out.contains("the log begins at 100."), "{}", ran.out);
    assert!(ran.out.contains("at its first frame with --from-first"), "{}", ran.out);
    fs::write(hil.path("oven/empty.log"), "").unwrap();
    let empty = within(&hil, &["import", "empty.log", "--plan", "short.toml"]).exits(2);
    for told in ["failed to import empty.log", "there is no frame in the log", "--from candump, "] {
        assert!(empty.err.contains(told), "{told}: {}", empty.err);
    }
}

#[test]
fn what_another_plan_judges_and_the_record_lacks_is_named() {
    let hil = Hil::new();
    hil.run(&["new", "oven"]).exits(0);
    within(&hil, &["run", "safe-alone.toml", "--out", "run"]).exits(0);
    let head = "name = \"other\"\ntitle = \"\"\ndevice = \"oven\"\nsteps = [{ wait = { duration_s = 2 } }]\n";
    let check = |rest: &str| {
        fs::write(hil.path("oven/other.toml"), format!("{head}{rest}")).unwrap();
        within(&hil, &["check", "run", "--plan", "other.toml"]).exits(1).out
    };
    let measured = check(
        "[[measurement]]\nname = \"warm\"\ndoc = \"\"\nquantity = \"signal.Temperature\"\nunit = \"degC\"\n\
         check = { all_within = [-40, 320] }\n",
    );
    assert!(measured.contains("warm unset: the record has no signal.Temperature"), "{measured}");
    let stated = check("[[property]]\nname = \"cold\"\nalways = \"Temperature < 300 degC\"\n");
    assert!(stated.contains("nothing was judged"), "{stated}");
    // That says nothing of the run.
    let own = within(&hil, &["check", "run"]).exits(0).out;
    assert!(!own.contains("nothing was judged"), "{own}");
}

/// Writes a plan on the oven and imports this log by it.
fn imported(hil: &Hil, log: &str, steps: &str, check: &str) -> Ran {
    let plan = format!(
        "name = \"own\"\ntitle = \"What the log says\"\ndevice = \"oven\"\nsteps = [{steps}]\n\
         [[measurement]]\nname = \"temperature\"\ndoc = \"In the step\"\nquantity = \"signal.Temperature\"\n\
         unit = \"degC\"\ncheck = {check}\n"
    );
    fs::write(hil.path("oven/own.toml"), plan).unwrap();
    within(hil, &["import", log, "--plan", "own.toml", "--out", log.trim_end_matches(".log")])
}

#[test]
fn the_first_frame_of_a_log_belongs_to_the_first_step() {
    let hil = recorded();
    let log = fs::read_to_string(hil.path("oven/rigs/oven.log")).unwrap();
    // The oven is warm at the end of the log.
    let (_, warm) = log.rsplit_once(") can0 101#").unwrap();
    let warm = warm.lines().next().unwrap();
    fs::write(hil.path("oven/hot.log"), format!("(0.0) can0 101#{warm}\n{log}")).unwrap();
    let all = "{ wait = { duration_s = 1 }, label = \"all\" }";
    let cold = "{ never_outside = { band = [0, 40], during = \"all\" } }";
    imported(&hil, "rigs/oven.log", all, cold).exits(0);
    let ran = imported(&hil, "hot.log", all, cold).exits(1);
    assert!(ran.out.contains("temperature  59"), "{}", ran.out);
}

#[test]
fn a_device_in_a_log_is_off_for_as_long_as_it_was() {
    let hil = recorded();
    let steps = "{ wait = { duration_s = 1 } }, { power_cycle = { device = \"device\", off_s = 2 } }, \
                 { wait = { duration_s = 1 } }";
    let ran = imported(&hil, "rigs/oven.log", steps, "{ all_within = [0, 100] }").exits(0);
    assert!(ran.out.contains("the bench ran 4.0 s"), "{}", ran.out);
}

/// A plan goes on for as long as the log is silent elsewhere; a note says that it judged nothing meanwhile.
#[test]
fn a_silent_end_is_told() {
    let hil = recorded();
    let log = fs::read_to_string(hil.path("oven/rigs/oven.log")).unwrap();
    let (_, frame) = log.rsplit_once(") can0 101#").unwrap();
    let frame = frame.lines().next().unwrap();
    let log: String =
        [0.0, 5.0, 5.1].iter().map(|at| format!("({at:.1}) can0 101#{frame}\n")).collect();
    fs::write(hil.path("oven/gap.log"), log).unwrap();
    let steps = "{ wait = { duration_s = 9 } }";
    let ran = imported(&hil, "gap.log", steps, "{ all_within = [0, 100] }").exits(0);
    assert!(ran.out.contains("the log ends 3.900 s before the plan"), "{}", ran.out);
}

/// The record of a run has its plan and all that it reads, if that is not too much.
#[test]
fn a_run_without_its_files_in_the_record_says_so() {
    let hil = recorded();
    let dbc = fs::read_to_string(hil.path("oven/devices/oven.dbc")).unwrap();
    fs::write(hil.path("oven/rigs/oven.dbc"), dbc).unwrap();
    let rig = "[[line]]\nname = \"can0\"\ncan = { dbc = \"oven.dbc\" }\n\
               [[node]]\nname = \"oven\"\nat = \"can0\"\nreplay = { log = \"long.log\" }\n";
    fs::write(hil.path("oven/rigs/replayed.toml"), rig).unwrap();
    let log: String = (0..150_000).map(|at| format!("({at}.000000) can0 101#D00700\n")).collect();
    assert!(log.len() > 4 << 20);
    fs::write(hil.path("oven/rigs/long.log"), log).unwrap();
    let plan = "name = \"own\"\ntitle = \"It is warm\"\nrig = \"replayed\"\nsteps = [{ wait = { duration_s = 5 } }]\n\
        [[measurement]]\nname = \"warmest\"\ndoc = \"In the log\"\nquantity = \"oven.Temperature\"\nunit = \"degC\"\n\
        check = { all_within = { at_most = 61 } }\n";
    fs::write(hil.path("oven/own.toml"), plan).unwrap();
    let ran = within(&hil, &["run", "own.toml", "--out", "long"]).exits(0);
    assert!(ran.out.contains("of this run need --plan"), "{}", ran.out);
    within(&hil, &["check", "long"]).exits(2);
    within(&hil, &["check", "long", "--plan", "own.toml"]).exits(0);
}
