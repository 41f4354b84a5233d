//! A bench that people share: one user at a time.

use crate::attach::appears;
use crate::commands::{command, project, runs, shell, told};
use crate::{hil, out, shown};
use skips::in_time;
use std::path::Path;
use std::process::{Command, Stdio};

/// `hil run` of the plan there, with leases in that folder.
fn run(folder: &Path, bench: &str, out: &Path) -> Command {
    let mut run = command(folder, bench, out);
    run.env("HIL_LEASES", folder.join("leases")).env("USER", "jane");
    run
}

#[test]
fn a_second_user_is_told_who_has_the_bench_or_waits_until_that_one_is_gone() {
    in_time(|| {
        let (folder, out) = out("run");
        let folder = folder.path();
        project(folder, "{ do = \"hold\" }");
        let bench = shell("hold", "touch held; until test -e let-go; do sleep 0.1; done", 60.0);
        let mut first = run(folder, &bench, &out).stderr(Stdio::null()).spawn().unwrap();
        appears(&folder.join("held"));

        let second =
            run(folder, &bench, &folder.join("second")).env("USER", "joe").output().unwrap();
        assert_eq!(second.status.code(), Some(2), "{}", shown(&second));
        let whose = format!("(process {}: hil run ./flashed.toml", first.id());
        for said in
            ["the bench ./bench.toml is in use: jane has been using bench", &whose, "add --wait"]
        {
            assert!(told(&second).contains(said), "{said}: {}", shown(&second));
        }
        assert!(!folder.join("second").exists());

        let mut doctor = hil();
        doctor.args(["doctor", "--bench", "./bench.toml"]).current_dir(folder);
        let doctor = doctor.env("HIL_LEASES", folder.join("leases")).output().unwrap();
        assert_eq!(doctor.status.code(), Some(3), "{}", shown(&doctor));
        assert!(told(&doctor).contains("jane has been using bench"), "{}", shown(&doctor));

        let mut impatient = run(folder, &bench, &folder.join("second"));
        let impatient = impatient.args(["--wait", "1"]).output().unwrap();
        assert_eq!(impatient.status.code(), Some(2), "{}", shown(&impatient));
        assert!(told(&impatient).contains("--wait 1 was not long enough"), "{}", shown(&impatient));

        // A killed process holds no lease.
        let mut patient = run(folder, &bench, &folder.join("second"));
        patient.args(["--wait", "60"]).stderr(Stdio::piped()).stdout(Stdio::piped());
        let patient = patient.spawn().unwrap();
        std::fs::remove_file(folder.join("held")).unwrap();
        first.kill().unwrap();
        first.wait().unwrap();
        appears(&folder.join("held"));
        std::fs::write(folder.join("let-go"), "").unwrap();
        let patient = patient.wait_with_output().unwrap();
        assert_eq!(patient.status.code(), Some(0), "{}", shown(&patient));
    });
}

#[test]
fn an_emulated_bench_is_nobodys() {
    in_time(|| {
        let (folder, out) = out("run");
        let folder = folder.path();
        project(folder, "{ do = \"hold\" }");
        let hold = shell("hold", "touch held; until test -e let-go; do sleep 0.1; done", 60.0);
        let first = run(folder, &hold, &out).stderr(Stdio::null()).spawn().unwrap();
        appears(&folder.join("held"));
        // Another file without commands has nothing in common.
        std::fs::write(folder.join("other.toml"), "title = \"All emulated\"\n").unwrap();
        project(folder, "{ wait = { duration_s = 0.1 } }");
        let mut other = hil();
        other.args([
            "run",
            "./flashed.toml",
            "--clock",
            "real",
            "--bench",
            "./other.toml",
            "--out",
        ]);
        other.arg(folder.join("other")).current_dir(folder);
        let other = other.env("HIL_LEASES", folder.join("leases")).output().unwrap();
        assert_eq!(other.status.code(), Some(0), "{}", shown(&other));
        std::fs::write(folder.join("let-go"), "").unwrap();
        let number = first.id().to_string();
        let first = first.wait_with_output().unwrap();
        assert_eq!(first.status.code(), Some(0), "{}", shown(&first));
        assert!(!runs(&number));
    });
}
