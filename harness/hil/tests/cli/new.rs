//! `hil new`: a fictitious device is emulated, tested and made to fail without a line of Rust.

use super::hil::Hil;
use std::fs;
use std::path::Path;

/// Creates the project of an oven on CAN, in the folder `oven`.
fn oven(arguments: &[&str]) -> Hil {
    let hil = Hil::new();
    let ran = hil.run(&[&["new", "oven"], arguments].concat()).exits(0);
    assert!(ran.out.contains("hil run settles.toml"), "{}", ran.out);
    hil
}

/// Runs `hil` with these arguments in the project.
fn within(hil: &Hil, arguments: &[&str]) -> super::hil::Ran {
    let output = hil.command(arguments).current_dir(hil.path("oven")).output().unwrap();
    super::hil::Ran::of(output)
}

fn edit(file: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(file).unwrap();
    assert!(text.contains(from), "{text}");
    fs::write(file, text.replacen(from, to, 1)).unwrap();
}

#[test]
fn an_invented_device_is_emulated_tested_and_broken() {
    for (arguments, noisy) in [(&[][..], "noisy-bus.toml"), (&["--serial"], "noisy-line.toml")] {
        let hil = oven(arguments);
        within(&hil, &["run", "settles.toml", "safe-alone.toml", noisy]).exits(0);
        assert!(hil.path("oven/runs/settles-seed1/report.html").is_file());

        // A defective device.
        let device = hil.path("oven/devices/oven.toml");
        edit(&device, "value = 1.0", "value = 5.0");
        let ran = within(&hil, &["run", "settles.toml", "--out", "wide"]).exits(1);
        assert!(ran.out.contains("temperature_held"), "{}", ran.out);
        edit(&device, "value = 5.0", "value = 1.0");

        // Faults of its line, one of which makes the plan fail; saved as a plan that fails by itself.
        let campaign =
            ["campaign", "settles.toml", "--cases", "20", "--out", "campaign", "--quiet"];
        let ran = within(&hil, &campaign).exits(1);
        assert!(ran.out.contains("1 property broken"), "{}", ran.out);
        let saved =
            fs::read_dir(hil.path("oven/campaign")).unwrap().map(|entry| entry.unwrap().path());
        let saved = saved.filter(|path| path.extension().is_some_and(|kind| kind == "toml"));
        let saved: Vec<_> = saved.collect();
        assert_eq!(saved.len(), 1, "{saved:?}");
        // With its own seed.
        let plan = saved[0].to_str().unwrap();
        let ran = within(&hil, &["run", plan, "--out", "again"]);
        assert!(matches!(ran.status, Some(1 | 4)), "{ran:#?}");
    }
}

#[test]
fn without_a_command_the_plans_of_the_folder_run() {
    let hil = oven(&[]);
    let ran = within(&hil, &[]).exits(0);
    assert!(ran.out.contains("passed (6 measurements: 6 passed)") && !ran.out.contains("paper"));
    let summary = fs::read_to_string(hil.path("oven/runs/noisy-bus-seed1/summary.json")).unwrap();
    assert!(!summary.contains("\"paper\""), "{summary}");
    // A plan with a mistake is a plan: without it, the others would pass for all.
    for (text, said) in [
        (&b"steps = [ {wait = "[..], "broken.toml:1:"),
        (b"[[steps]]\nname = 'K\xe4fer'\n", "broken.toml"),
    ] {
        fs::write(hil.path("oven/broken.toml"), text).unwrap();
        let broken = within(&hil, &[]).exits(2);
        assert!(broken.err.contains(said), "{}", broken.err);
    }
    let nothing = Hil::new().run(&[]).exits(2);
    assert!(nothing.err.contains("no plans") && nothing.err.contains("hil --help"), "{nothing:?}");
}

/// `cargo install` brings the program alone: the library in each FMU stays in the build folder.
#[test]
fn an_installed_program_finds_the_library_for_fmus_in_its_clone() {
    let hil = oven(&[]);
    let installed = hil.path("bin-hil");
    // A program that is open for writing does not start: what another test starts meanwhile would inherit an open file.
    let copy =
        std::process::Command::new("cp").arg(env!("CARGO_BIN_EXE_hil")).arg(&installed).status();
    assert!(copy.unwrap().success());
    let export = |library: &[&str]| {
        let mut command = std::process::Command::new(&installed);
        command.args(["export", "oven/devices/oven.toml", "--fmu", "oven.fmu"]).args(library);
        super::hil::Ran::of(command.current_dir(hil.path(".")).output().unwrap())
    };
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target");
    if Path::new(env!("CARGO_BIN_EXE_hil")).starts_with(built.canonicalize().unwrap_or_default()) {
        export(&[]).exits(0);
        assert!(hil.path("oven.fmu").is_file());
    }
    assert!(export(&["--library", "none.so"]).exits(2).err.contains("none.so"));
    for other in ["oven/settles.toml", "/bin/sh"] {
        fs::remove_file(hil.path("oven.fmu")).ok();
        let refused = export(&["--library", other]).exits(2).err;
        assert!(refused.contains("is no library with the function"), "{other}: {refused}");
        assert!(!hil.path("oven.fmu").exists());
    }
}

#[test]
fn a_file_of_the_project_that_is_not_found_by_its_name_is_named_by_its_path() {
    let hil = oven(&[]);
    let ran = within(&hil, &["emulate", "device", "oven"]).exits(2);
    assert!(ran.err.contains("did you mean `devices/oven.toml`?"), "{}", ran.err);
}

/// A bench of commands alone: the device is emulated within the harness.
#[test]
fn a_bench_that_names_no_device_needs_no_port_for_it() {
    let hil = oven(&[]);
    fs::write(hil.path("oven/power.toml"), "[command.power-on]\nrun = [\"true\"]\n").unwrap();
    let ran = within(&hil, &["doctor", "safe-alone.toml", "--bench", "power.toml"]).exits(0);
    assert!(ran.out.contains("provides all that the plans need"), "{}", ran.out);
    let alone = within(&hil, &["doctor", "--bench", "power.toml"]).exits(0);
    assert!(alone.out.contains("can be used") && !alone.out.contains("gyro"), "{}", alone.out);
}

#[test]
fn how_much_of_a_fault_it_stands_is_measured() {
    let hil = oven(&[]);
    // A weaker statement, which fewer runs show.
    edit(&hil.path("oven/settles.toml"), "at_least = 2 ", "share = 0.5\nruns = 5\nat_least = 2 ");
    let ran = within(&hil, &["campaign", "settles.toml", "--envelopes", "--quiet"]).exits(0);
    assert!(ran.out.contains("at least 2 s is required: holds"), "{}", ran.out);
    // Runs of another device do not count for this one, though the plan is the same.
    edit(&hil.path("oven/devices/oven.toml"), "value = 1.0", "value = 5.0");
    let ran = within(&hil, &["campaign", "settles.toml", "--envelopes", "--quiet"]).exits(2);
    assert!(ran.err.contains("runs.jsonl is of another campaign: plan"), "{}", ran.err);
}

#[test]
fn a_project_can_be_made_in_the_working_directory() {
    let hil = Hil::new();
    std::fs::create_dir(hil.path("kiln")).unwrap();
    let made = hil.command(&["new", "."]).current_dir(hil.path("kiln")).output().unwrap();
    assert!(made.status.success(), "{made:?}");
    assert!(hil.path("kiln/devices/kiln.toml").is_file());
}

/// Found by a user: such a project had a plan that judges nothing, which `hil run` refuses.
#[test]
fn a_node_that_sends_nothing_is_no_device() {
    let hil = Hil::new();
    let dbc = "BU_: Dev Ear\nBO_ 257 Status: 2 Dev\n SG_ T : 0|16@1- (1,0) [0|0] \"\" Ear\n";
    std::fs::write(hil.path("own.dbc"), dbc).unwrap();
    let ran = hil.run(&["new", "ear", "--dbc", "own.dbc", "--node", "Ear"]).exits(2);
    assert!(ran.err.contains("Ear of own.dbc sends no messages"), "{}", ran.err);
    assert!(ran.err.contains("nodes and their messages: Dev (1)"), "{}", ran.err);
    assert!(!hil.path("ear").exists());
}

#[test]
fn quiet_is_quiet() {
    let ran = Hil::new().run(&["new", "oven", "--quiet"]).exits(0);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
}

#[test]
fn a_project_of_ones_own_dbc_runs_as_it_is() {
    let hil = Hil::new();
    let dbc = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../wire/dbc/k2a.dbc");
    let dbc = dbc.to_str().unwrap();
    let ran = hil.run(&["new", "oven", "--dbc", dbc, "--node", "Nobody"]).exits(2);
    assert!(ran.err.contains("no node `Nobody`"), "{}", ran.err);
    hil.run(&["new", "oven", "--dbc", dbc, "--node", "BASE"]).exits(0);
    within(&hil, &["run", "talks.toml"]).exits(0);
}

/// Slow messages, and a signal that no count makes zero.
#[test]
fn a_plan_of_a_dbc_passes_as_it_is_made() {
    for period_ms in [0, 999, 1_000, 2_000, 3_300, 5_000, 20_000] {
        let hil = Hil::new();
        let dbc = format!(
            "VERSION \"\"\nNS_ :\nBS_:\nBU_: Host Dev\n\
             BO_ 257 Status: 2 Dev\n SG_ Temperature : 0|16@1- (0.01,0) [-40|320] \"degC\" Host\n\
             BO_ 258 Cmd: 2 Host\n SG_ Angle : 0|16@1- (0.0439453125,-5.0) [-100|100] \"deg\" Dev\n\
             BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\nBA_DEF_DEF_ \"GenMsgCycleTime\" 0;\n\
             BA_ \"GenMsgCycleTime\" BO_ 257 {period_ms};\n"
        );
        std::fs::write(hil.path("own.dbc"), dbc).unwrap();
        hil.run(&["new", "oven", "--dbc", "own.dbc", "--node", "Dev"]).exits(0);
        within(&hil, &["run", "talks.toml"]).exits(0);
    }
}

#[test]
fn mistakes_are_bad_input_and_shown_in_place() {
    let hil = oven(&[]);
    let ran = hil.run(&["new", "oven"]).exits(2);
    assert!(ran.err.contains("not empty"), "{}", ran.err);
    let ran = hil.run(&["new", "My Oven"]).exits(2);
    assert!(ran.err.contains("cannot be the name of a device"), "{}", ran.err);
    let ran = within(&hil, &["run", "settles"]).exits(2);
    assert!(ran.err.contains("did you mean `settles.toml`?"), "{}", ran.err);
    edit(&hil.path("oven/settles.toml"), "device = \"oven\"", "device = \"oevn\"");
    let ran = within(&hil, &["run", "settles.toml"]).exits(2);
    assert!(ran.err.contains("settles.toml:5:") && ran.err.contains("`oven`?"), "{}", ran.err);
    edit(&hil.path("oven/settles.toml"), "device = \"oevn\"", "device = \"oven\"");
    edit(&hil.path("oven/settles.toml"), "signal.Temperature", "signal.Temprature");
    let ran = within(&hil, &["run", "settles.toml"]).exits(2);
    assert!(ran.err.contains("did you mean `Temperature`?"), "{}", ran.err);
    edit(&hil.path("oven/devices/oven.toml"), "temperature > Setpoint", "temperatur > Setpoint");
    let ran = within(&hil, &["run", "safe-alone.toml"]).exits(2);
    assert!(ran.err.contains("did you mean `temperature`?"), "{}", ran.err);
    edit(&hil.path("oven/devices/oven.toml"), "temperatur > Setpoint", "temperature > Setpoint");
    let ran = within(&hil, &["run", "noisy-bus.toml", "--bus", "pty"]).exits(2);
    assert!(ran.err.contains("--bus slcan carries its frames"), "{}", ran.err);
    within(&hil, &["run", "noisy-bus.toml", "--bus", "slcan", "--out", "across"]).exits(0);
    for clock in ["virtual", "real"] {
        let words = ["--clock", clock, "--controller", "/no/such/program"];
        let ran = within(&hil, &[&["run", "safe-alone.toml"][..], &words].concat()).exits(2);
        assert!(ran.err.contains("--controller has no meaning for safe-alone"), "{}", ran.err);
    }
}
