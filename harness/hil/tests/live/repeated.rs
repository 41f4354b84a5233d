//! A run at a bench says where and when it was, and can be repeated.

use crate::commands::{command, project};
use crate::{out, shown, summary};
use skips::in_time;

const BENCH: &str = r#"
title = "The bench by the window"
[about]
"serial number" = "SN 1234"
"#;

#[test]
fn each_of_the_repeated_runs_is_kept_with_its_bench() {
    in_time(|| {
        let (folder, out) = out("runs");
        let folder = folder.path();
        project(folder, "{ wait = { duration_s = 0.2 } }");
        let output = command(folder, BENCH, &out).args(["--repeat", "3"]).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let told = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(told.contains("3 of 3") && told.contains("44 to 100 %"), "{told}");
        for run in 1..=3 {
            let out = out.join(format!("flashed-seed1-run{run}"));
            let bench = &summary(&out)["bench"];
            assert_eq!(
                (&bench["repetition"], &bench["file"]),
                (&run.into(), &"./bench.toml".into())
            );
            assert_eq!(bench["about"]["serial number"], "SN 1234");
            let started = bench["started"].as_str().unwrap();
            let junit = std::fs::read_to_string(out.join("junit.xml")).unwrap();
            assert!(started.ends_with('Z') && junit.contains(&started[..19]), "{junit}");
            assert!(junit.contains("hostname=") && junit.contains("flashed.run"), "{junit}");
            let report = std::fs::read_to_string(out.join("report.html")).unwrap();
            assert!(report.contains(started) && report.contains("SN 1234"));
        }
    });
}

#[test]
fn in_virtual_time_nothing_is_repeated() {
    let (folder, out) = out("runs");
    let folder = folder.path();
    project(folder, "{ wait = { duration_s = 0.2 } }");
    let mut run = crate::hil();
    run.args(["run", "./flashed.toml", "--repeat", "3", "--out"]).arg(&out).current_dir(folder);
    let output = run.output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", shown(&output));
    assert!(shown(&output).contains("in virtual time all runs of a seed are the same"));
}
