//! Runs, and commands on their records.

use crate::hil::{Hil, Ran, TURN};
use record::header::Header;
use record::reader::RecordReader;
use record::writer::RecordWriter;
use std::fs;
use std::io::Cursor;
use std::sync::Arc;

fn lines(text: &str) -> Vec<&str> {
    text.lines().collect()
}

#[test]
fn a_run_is_kept_checked_drawn_and_shown() {
    let hil = Hil::with_plan(TURN);
    let ran = hil.run(&["run", "turn.toml", "--seed", "7"]).exits(0);
    assert!(ran.out.contains("stop_error") && ran.out.contains("exit status 0"), "{}", ran.out);
    assert_eq!(lines(&ran.err).len(), 1, "one line a plan: {}", ran.err);
    assert!(ran.err.starts_with("turn: passed, bench "), "{}", ran.err);
    let run = "runs/turn-seed7";
    let files = ["summary.json", "record.hilrec", "junit.xml", "report.html"];
    assert!(files.iter().all(|file| hil.path(run).join(file).is_file()));

    let checked = hil.run(&["check", run]).exits(0);
    assert_eq!(checked.out, ran.out, "by the plan that the record holds");
    // An older record contains no files, and no plan of this name ships.
    let record = hil.path(run).join("record.hilrec");
    let whole = fs::read(&record).unwrap();
    fs::write(&record, without_files(&whole)).unwrap();
    let unknown = hil.run(&["check", run]).exits(2).err;
    fs::write(&record, whole).unwrap();
    assert!(unknown.contains("holds no plan"), "{unknown}");
    assert!(unknown.contains("--plan FILE"), "{unknown}");
    let checked = hil.run(&["check", run, "--plan", "turn.toml"]).exits(0);
    assert_eq!(checked.out, ran.out);
    fs::write(hil.path("strict.toml"), TURN.replace("[-5, 5]", "[-1e-9, 1e-9]")).unwrap();
    let strict = hil.run(&["check", run, "--plan", "strict.toml"]).exits(1);
    assert!(strict.out.contains("fail"), "{}", strict.out);
    assert!(!strict.err.contains("not carried out"), "{}", strict.err);
    fs::write(hil.path("wide.toml"), TURN.replace("angle_deg = 90", "angle_deg = 45")).unwrap();
    let wide = hil.run(&["check", run, "--plan", "wide.toml"]);
    assert!(wide.err.contains("the steps of turn are not those of the run"), "{}", wide.err);
    hil.run(&["check", run, "--plan", "strict.toml"]).exits(1);
    assert_eq!(hil.outcome(run), "failed");

    let report = hil.path(run).join("report.html");
    fs::remove_file(&report).unwrap();
    let drawn = hil.run(&["report", run]).exits(0);
    assert_eq!(drawn.out, format!("{run}/report.html\n"));
    assert!(fs::read_to_string(&report).unwrap().contains("stop_error"));

    let shown = hil.run(&["show", run]).exits(0);
    assert!(shown.out.contains("observation turn.stop_error"), "{}", shown.out);
    let plan = hil.run(&["show", run, "--device", "plan", "--limit", "3"]).exits(0);
    assert_eq!(lines(&plan.out).len(), 3);
    assert!(lines(&plan.out).iter().all(|line| line.contains(" plan ")), "{}", plan.out);
}

#[test]
fn two_runs_are_drawn_over_one_another() {
    let hil = Hil::with_plan(TURN);
    for seed in ["1", "2"] {
        hil.run(&["run", "turn.toml", "--seed", seed]).exits(0);
    }
    let runs = ["diff", "runs/turn-seed1", "runs/turn-seed2", "--html"];
    let compared = hil.run(&[&runs[..], &["diff.html"]].concat()).exits(0);
    assert!(compared.out.contains("no verdict differs"), "{}", compared.out);
    let page = fs::read_to_string(hil.path("diff.html")).unwrap();
    for said in ["runs/turn-seed2: passed", "turn.stop_error", "First difference", "first, 1"] {
        assert!(page.contains(said), "{said}: {page}");
    }
    assert!(!compared.out.contains("files that differ"), "{}", compared.out);
    let wider = TURN.replace("all_within = [-5, 5]", "all_within = [-5, 6]");
    assert_ne!(wider, TURN);
    fs::write(hil.path("turn.toml"), wider).unwrap();
    hil.run(&["run", "turn.toml", "--seed", "1", "--out", "wider"]).exits(0);
    let compared = hil.run(&["diff", "runs/turn-seed1", "wider"]).exits(0).out;
    for said in ["band ±5 deg", "band -5 to 6 deg", "files that differ: turn.toml"] {
        assert!(compared.contains(said), "{said}: {compared}");
    }
    let nowhere = hil.run(&[&runs[..], &["no/such/diff.html"]].concat()).exits(3);
    assert!(nowhere.err.contains("failed to write no/such/diff.html"), "{}", nowhere.err);
}

#[test]
fn records_are_compared_by_what_both_have_and_damage_is_an_error() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--out", "events"]).exits(0);
    hil.run(&["run", "turn.toml", "--out", "full", "--record", "full"]).exits(0);
    for pair in [["events", "full"], ["full", "events"]] {
        let said = hil.run(&[&["diff"][..], &pair].concat()).exits(0).out;
        assert!(said.contains("both records hold is the same\nonly one record is"), "{said}");
    }
    let same = hil.run(&["diff", "full", "full"]).exits(0).out;
    assert!(same.contains("the records are the same\nno verdict differs"), "{same}");

    let record = hil.path("full/record.hilrec");
    let mut flipped = fs::read(&record).unwrap();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 4;
    fs::write(&record, flipped).unwrap();
    for pair in [["events", "full"], ["full", "full"]] {
        let said = hil.run(&[&["diff"][..], &pair].concat()).exits(3).out;
        assert!(said.contains("damaged at byte") && said.contains("a record is damaged"), "{said}");
    }
}

#[test]
fn what_stood_at_a_moment_is_shown() {
    let hil = Hil::new();
    let options = ["--record", "full", "--out", "side"];
    hil.run(&[&["run", "live-side"][..], &options].concat()).exits(0);
    let at = |seconds: &str| hil.run(&["show", "side", "--at", seconds]).exits(0).out;
    let driving = at("30");
    for what in [
        "begin steps[",
        "command {\"straight\"",
        "state ",
        "health ",
        "truth ",
        "base       MOTION: DISPLACEMENT ",
    ] {
        assert!(driving.contains(what), "{what}: {driving}");
    }
    assert!(driving.contains("observation straight.heading_error"), "{driving}");
    assert!(lines(&driving).len() < 60, "{driving}");
    let over = at("1e6");
    assert!(!over.contains("begin steps") && over.contains("controller "), "{over}");
    let told = hil.run(&["show", "side", "--at", "1e6"]).err;
    assert!(told.contains(" s: this is the state then"), "{told}");
    assert_eq!(hil.run(&["show", "side", "--at", "30"]).err, "");
    assert_eq!(
        lines(&hil.run(&["show", "side", "--at", "30", "--limit", "2"]).exits(0).out).len(),
        2
    );
    let refused = hil.run(&["show", "side", "--at", "-1"]).exits(2).err;
    assert!(refused.contains("-1 s is before the run began"), "{refused}");
}

/// Output of `hil debug` for these commands.
fn debugged(hil: &Hil, arguments: &[&str], orders: &str) -> Ran {
    fs::write(hil.path("orders"), orders).unwrap();
    let orders = fs::File::open(hil.path("orders")).unwrap();
    let arguments = [&["debug"], arguments].concat();
    Ran::of(hil.command(&arguments).stdin(orders).output().unwrap())
}

#[test]
fn a_run_is_stopped_stepped_and_goes_on() {
    let hil = Hil::with_plan(TURN);
    for (name, level) in [("full", "full"), ("events", "events")] {
        hil.run(&["run", "turn.toml", "--record", level, "--out", name]).exits(0);
        let shown = hil.run(&["show", "full", "--at", "3"]).exits(0).out;
        let begins = debugged(&hil, &[name, "--at", "3"], "quit\n").exits(0);
        assert_eq!(begins.out, shown, "what stands is what hil show says");
        // Stopped and continued, the run equals the recorded one to the byte.
        let orders = "step 5\nto 3.5\nnext\nfind observation\nend\n";
        let whole = debugged(&hil, &[name, "--at", "3"], orders).exits(0).out;
        assert!(whole.contains("\nas recorded to the end\n"), "{whole}");
        assert!(
            whole.contains("observation turn.stop_error") && whole.contains("exit status 0"),
            "{whole}"
        );
        let stepped = whole.strip_prefix(&shown).unwrap();
        let every = hil.run(&["show", "full"]).exits(0).out;
        // A record is followed by the messages that it completes.
        let records: Vec<&str> =
            lines(stepped).into_iter().filter(|line| every.contains(line)).take(5).collect();
        assert!(every.contains(&records.join("\n")), "record by record: {records:?}");
        assert!(stepped.contains("base       MOTION: DISPLACEMENT 0 m"), "{stepped}");
    }
}

#[test]
fn another_plan_or_controller_goes_on_from_the_run_that_was() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--record", "full", "--out", "run"]).exits(0);
    fs::write(hil.path("strict.toml"), TURN.replace("[-5, 5]", "[-1e-9, 1e-9]")).unwrap();
    let strict = debugged(&hil, &["run", "--plan", "strict.toml"], "end\n").exits(1).out;
    assert!(strict.contains("as recorded to the end") && strict.contains("fail"), "{strict}");
    fs::write(hil.path("half.toml"), TURN.replace("angle_deg = 90", "angle_deg = 45")).unwrap();
    let half = debugged(&hil, &["run", "--plan", "half.toml"], "end\n").exits(0).out;
    assert_eq!(half.matches("not as recorded: recorded `").count(), 1, "{half}");
    assert!(half.contains("now `6.0"), "the bias test is the same: {half}");

    let refused = |arguments: &[&str]| debugged(&hil, arguments, "").exits(2).err;
    assert!(refused(&["run", "--at", "-1"]).contains("-1 s is before the run began"));
    assert!(refused(&["run", "--plan", "turns.toml"]).contains("turns.toml"));
    let summary = hil.path("run/summary.json");
    let text = fs::read_to_string(&summary).unwrap();
    fs::write(&summary, text.replace("\"virtual\"", "\"real\"")).unwrap();
    assert!(refused(&["run"]).contains("was run in real time"));
}

#[test]
fn several_plans_share_a_parent() {
    let hil = Hil::with_plan(TURN);
    fs::write(hil.path("strict.toml"), strict()).unwrap();
    let ran = hil.run(&["run", "strict.toml", "turn.toml", "--out", "here", "--quiet"]).exits(1);
    assert_eq!(ran.err, "");
    assert_eq!(hil.outcome("here/strict-seed1"), "failed");
    assert_eq!(hil.outcome("here/turn-seed1"), "passed", "a failed plan stops nothing");
    hil.run(&["run", "turn.toml", "--out", "alone", "--record", "full"]).exits(0);
    assert_eq!(hil.outcome("alone"), "passed");
    let bytes = hil.run(&["show", "alone", "--device", "gyro", "--limit", "1"]).exits(0);
    assert!(bytes.out.contains(" gyro       bytes "), "{}", bytes.out);
}

/// Returns the record without the files in its header.
fn without_files(record: &[u8]) -> Vec<u8> {
    let reader = RecordReader::new(Cursor::new(record.to_vec())).unwrap();
    let header = Header { files: Arc::default(), ..reader.header().clone() };
    let mut bytes = Vec::new();
    let mut writer = RecordWriter::new(&mut bytes, &header).unwrap();
    reader.for_each(|record| writer.write(&record.unwrap()).unwrap());
    writer.finish().unwrap();
    bytes
}

fn strict() -> String {
    TURN.replace("[-5, 5]", "[-1e-9, 1e-9]").replace("name = \"turn\"", "name = \"strict\"")
}

#[test]
fn seeds_give_shares() {
    let hil = Hil::with_plan(TURN);
    fs::write(hil.path("strict.toml"), strict()).unwrap();
    let arguments = ["run", "turn.toml", "strict.toml", "--seeds", "6", "--markdown", "shares.md"];
    let ran = hil.run(&arguments).exits(0);
    assert!(ran.out.contains("100.0 % (6 of 6)"), "{}", ran.out);
    assert!(ran.out.contains("0.0 % (0 of 6)"), "{}", ran.out);
    assert!(ran.out.contains("strict: not passed by seeds 1, 2, 3, 4, 5, ..."), "{}", ran.out);
    assert!(!hil.path("runs").exists());
    let markdown = fs::read_to_string(hil.path("shares.md")).unwrap();
    assert!(markdown.contains("| turn | stop_error | 100.0 % (6 of 6) |"), "{markdown}");
    // The result is the same on any number of cores.
    assert_eq!(hil.run(&arguments).exits(0).out, ran.out);
}

#[test]
fn what_is_left_of_a_record_never_passes() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--out", "run"]).exits(0);
    let record = hil.path("run/record.hilrec");
    let whole = fs::read(&record).unwrap();
    fs::write(&record, &whole[..whole.len() - 1]).unwrap();
    let check = ["check", "run", "--plan", "turn.toml"];
    let ran = hil.run(&check).exits(3);
    assert!(ran.err.contains("the record is cut short"), "{}", ran.err);
    assert_eq!(hil.outcome("run"), "passed", "earlier verdicts are left alone");
    let shown = hil.run(&["show", "run"]).exits(2);
    assert!(shown.out.contains("observation turn.stop_error"), "what is good is shown");

    // As if killed before the summary was written.
    fs::remove_file(hil.path("run/summary.json")).unwrap();
    let ran = hil.run(&check).exits(3);
    assert!(ran.out.contains("no summary says how the run ended"), "{}", ran.out);
    assert_eq!(hil.outcome("run"), "error");
}

#[test]
fn a_time_limit_is_a_timeout() {
    let limited = TURN.replace("angle_deg = 90 }", "angle_deg = 90 }, time_limit_s = 0.1");
    let hil = Hil::with_plan(&limited);
    let ran = hil.run(&["run", "turn.toml"]).exits(4);
    assert!(ran.out.contains("took longer than its limit"), "{}", ran.out);
    assert_eq!(hil.outcome("runs/turn-seed1"), "timeout");
    hil.run(&["check", "runs/turn-seed1", "--plan", "turn.toml"]).exits(4);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_breaks_the_bench() {
    let hil = Hil::with_plan(TURN);
    for level in ["events", "full"] {
        hil.run(&["run", "turn.toml", "--out", "run"]).exits(0);
        let record = hil.path("run/record.hilrec");
        fs::remove_file(&record).unwrap();
        std::os::unix::fs::symlink("/dev/full", &record).unwrap();
        let ran = hil.run(&["run", "turn.toml", "--out", "run", "--record", level]).exits(3);
        assert!(ran.err.contains("run/record.hilrec: No space left on device"), "{}", ran.err);
        fs::remove_dir_all(hil.path("run")).unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_standard_output_that_is_full_is_an_error() {
    let hil = Hil::new();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let ran = hil.command(&["list"]).stdout(full).output().unwrap();
    let ran = crate::hil::Ran::of(ran).exits(3);
    assert!(ran.err.contains("failed to write to the standard output"), "{}", ran.err);
}

#[test]
fn a_reader_that_has_had_enough_is_no_error() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--out", "run", "--record", "full"]).exits(0);
    let mut command = hil.command(&["show", "run"]);
    let mut child = command.stdout(std::process::Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

/// A plan with a turn, before which the gyro is unplugged for a while, and with properties.
fn watched() -> String {
    let steps = TURN.replace("steps = [", "steps = [\n    { wait = { duration_s = 8 } },");
    let property = |text: &str| format!("[[property]]\n{text}\n");
    [
        steps.as_str(),
        &property("always = { recovers = {} }"),
        &property("always = { finite_outputs = {} }"),
        &property("always = { fresh_heading = {} }"),
        &property("sometimes = \"gyro_silent\""),
        &property("sometimes = \"bus_off\""),
        "[[fault]]\ntarget = \"gyro\"\nwhat = { disconnect = { for_s = 1 } }\nwhen = { at_s = 2 }\n",
    ]
    .join("\n")
}

#[test]
fn properties_are_judged_again_by_what_the_record_holds_of_them() {
    let hil = Hil::with_plan(TURN);
    fs::write(hil.path("watched.toml"), watched()).unwrap();
    for (level, kept) in [
        ("full", &["fresh_heading"][..]),
        ("events", &["recovers", "finite_outputs", "fresh_heading"][..]),
    ] {
        let run = ["run", "watched.toml", "--out", level, "--record", level];
        // What is to come about and does not fails the run.
        let ran = hil.run(&run).exits(1);
        assert!(ran.out.contains("never reached"), "{}", ran.out);
        let file = hil.path(level).join("summary.json");
        let summary =
            || -> serde_json::Value { serde_json::from_slice(&fs::read(&file).unwrap()).unwrap() };
        let before = summary();
        let held: Vec<_> =
            before["properties"].as_array().unwrap().iter().map(|one| &one["held"]).collect();
        assert_eq!(held, [true, true, true, true, false], "{before}");
        let check = ["check", level, "--plan", "watched.toml"];
        let checked = hil.run(&check).exits(1);
        let said: Vec<&str> = lines(&checked.err)
            .iter()
            .filter_map(|line| {
                let name = line.strip_prefix(&format!("{level}: "))?.split(' ').next()?;
                line.contains("keeps the verdict of the run").then_some(name)
            })
            .collect();
        assert_eq!(said, kept, "{}", checked.err);
        // A property judged on less data than in the run may differ only in its margin.
        let same = |a: &serde_json::Value, b: &serde_json::Value| {
            let margin = |one: &serde_json::Value| one["margin"].as_f64().unwrap_or_default();
            assert_eq!((&a["name"], &a["held"]), (&b["name"], &b["held"]));
            assert!((margin(a) - margin(b)).abs() < 0.02, "{a} {b}");
        };
        let compare = |after: &serde_json::Value| {
            let all =
                |summary: &serde_json::Value| summary["properties"].as_array().unwrap().clone();
            assert_eq!(all(&before).len(), all(after).len());
            all(&before).iter().zip(&all(after)).for_each(|(a, b)| same(a, b));
        };
        compare(&summary());
        // A forged verdict in the summary does not override the record.
        let mut forged = summary();
        forged["outcome"] = "failed".into();
        forged["reason"] = "broke recovers at 3.000 s: never".into();
        let recovers = &mut forged["properties"][0];
        recovers["held"] = false.into();
        recovers["broken_s"] = 3.0.into();
        recovers["what"] = "never".into();
        fs::write(&file, forged.to_string()).unwrap();
        hil.run(&check).exits(1);
        if level == "full" {
            compare(&summary());
            assert_eq!(summary()["reason"], "bus_off never reached");
        } else {
            assert_eq!(summary()["reason"], "broke recovers at 3.000 s: never");
        }
    }
}

#[test]
fn a_run_is_given_once_more_to_its_controller() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--record", "full", "--out", "full"]).exits(0);
    let same = hil.run(&["rerun", "full"]).exits(0).out;
    assert!(same.starts_with("the same: "), "{same}");
    assert_eq!(hil.run(&["rerun", "full", "--controller", "process"]).exits(0).out, same);
    let dumb = hil.run(&["rerun", "full", "--controller", "sleep 1000000", "--json"]).exits(1);
    let dumb: serde_json::Value = serde_json::from_str(&dumb.out).unwrap();
    assert!(dumb["difference"]["recorded"].as_str().unwrap().contains("starting"), "{dumb}");
    assert_eq!((&dumb["difference"]["now"], &dumb["now"]["outputs"]), (&().into(), &0.into()));
    hil.run(&["run", "turn.toml", "--out", "events"]).exits(0);
    let refused = hil.run(&["rerun", "events"]).exits(2).err;
    assert!(refused.contains("no bytes and no frames") && refused.contains("--record full"));
}
