//! Exports of runs: tables, files for Foxglove and measured channels.

use super::hil::{Hil, Ran, TURN};
use std::fs;

/// Records a turn in full, in the folder `run`.
fn recorded() -> Hil {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--out", "run", "--record", "full"]).exits(0);
    hil
}

#[test]
fn a_run_becomes_tables_and_a_file_for_foxglove() {
    let hil = recorded();
    let tables = hil.run(&["export", "run", "--tables", "tables"]).exits(0);
    assert!(tables.out.contains("tables/states.parquet: "), "{}", tables.out);
    assert!(tables.out.contains("tables/measurements.parquet: 1 row\n"), "{}", tables.out);
    assert!(hil.path("tables/datapackage.json").is_file());
    hil.run(&["export", "run", "--tables", "tables", "--format", "csv"]).exits(0);
    assert!(!hil.path("tables/states.parquet").exists(), "of an earlier export nothing is left");
    let states = fs::read_to_string(hil.path("tables/states.csv")).unwrap();
    assert!(states.starts_with("time_s,activity,moving,x_m,y_m,heading_deg,"), "{states:.80}");

    let mcap = hil.run(&["export", "run", "--mcap", "run.mcap"]).exits(0);
    assert!(mcap.out.starts_with("run.mcap: ") && mcap.out.contains(" topics"), "{}", mcap.out);
    assert!(fs::read(hil.path("run.mcap")).unwrap().starts_with(b"\x89MCAP0\r\n"));
    assert_eq!(mcap.err, "");

    let mf4 = hil.run(&["export", "run", "--mf4", "run.mf4"]).exits(0);
    assert!(mf4.out.starts_with("run.mf4: ") && mf4.out.contains(" groups"), "{}", mf4.out);
    assert!(fs::read(hil.path("run.mf4")).unwrap().starts_with(b"MDF     4.10"));
    assert_eq!(mf4.err, "");
}

#[test]
fn nothing_else_is_written_over() {
    let hil = recorded();
    let record = fs::read(hil.path("run/record.hilrec")).unwrap();
    let ran = hil.run(&["export", "run", "--mcap", "run/record.hilrec"]).exits(2);
    assert!(ran.err.contains("does not end in .mcap"), "{}", ran.err);
    let ran = hil.run(&["export", "run", "--mf4", "run/record.hilrec"]).exits(2);
    assert!(ran.err.contains("does not end in .mf4"), "{}", ran.err);
    assert_eq!(fs::read(hil.path("run/record.hilrec")).unwrap(), record);
    hil.run(&["export", "run", "--kind", "series", "--out", "data"]).exits(0);
    let ran = hil.run(&["export", "run", "--tables", "data"]).exits(2);
    assert!(ran.err.contains("refused to replace data: it holds files"), "{}", ran.err);
    let ran = hil.run(&["export", "run", "--mcap", "nowhere/run.mcap"]).exits(3);
    assert!(ran.err.contains("failed to write nowhere/run.mcap"), "{}", ran.err);
}

#[test]
fn what_is_left_of_a_record_is_exported_and_another_version_refused() {
    let hil = recorded();
    let path = hil.path("run/record.hilrec");
    let mut record = fs::read(&path).unwrap();
    fs::write(&path, &record[..record.len() / 2]).unwrap();
    for (what, out) in [("--mcap", "cut.mcap"), ("--tables", "cut"), ("--mf4", "cut.mf4")] {
        let ran = hil.run(&["export", "run", what, out]).exits(2);
        assert!(ran.err.contains("exported as far as the record goes: "), "{}", ran.err);
        assert!(ran.err.contains("the record is cut short"), "{}", ran.err);
    }
    // A complete file, with its end.
    assert!(fs::read(hil.path("cut.mcap")).unwrap().ends_with(b"\x89MCAP0\r\n"));
    assert!(hil.path("cut/states.parquet").is_file());
    assert!(fs::read(hil.path("cut.mf4")).unwrap().starts_with(b"MDF     "));
    record[8] = 9;
    fs::write(&path, &record).unwrap();
    let ran = hil.run(&["export", "run", "--mcap", "other.mcap"]).exits(2);
    assert!(ran.err.contains("record format 9 is newer than 3"), "{}", ran.err);
    assert!(!hil.path("other.mcap").exists());
}

#[test]
fn messages_of_a_device_of_the_users_own_are_read_by_its_layout() {
    for arguments in [&["new", "oven"][..], &["new", "oven", "--serial"]] {
        let hil = Hil::new();
        hil.run(arguments).exits(0);
        let within = |arguments: &[&str]| {
            Ran::of(hil.command(arguments).current_dir(hil.path("oven")).output().unwrap())
        };
        within(&["run", "safe-alone.toml", "--out", "run", "--record", "full"]).exits(0);
        // The record contains all that is needed to read it anywhere.
        fs::rename(hil.path("oven/devices"), hil.path("oven/elsewhere")).unwrap();
        within(&["export", "run", "--tables", "read", "--format", "csv"]).exits(0);
        within(&["check", "run"]).exits(0);
        let signals = fs::read_to_string(hil.path("oven/read/signals.csv")).unwrap();
        let of = |signal: &str| signals.lines().filter(|line| line.contains(signal)).count();
        assert!(of(",device,Status,Temperature,") > 50, "{} lines", signals.lines().count());
        assert!(of(",plan,Command,Setpoint,60.0,") > 20, "{} lines", signals.lines().count());
    }
}

#[test]
fn tables_tell_the_lines_of_a_node_apart() {
    let hil = Hil::new();
    fs::create_dir(hil.path("rigs")).unwrap();
    let dbc = "VERSION \"\"\nNS_ :\nBS_:\nBU_: MOTOR\n\
               BO_ 256 MotorStatus: 2 MOTOR\n SG_ Speed : 0|16@1+ (1,0) [0|10000] \"rpm\" Vector__XXX\n";
    let line =
        |name: &str| format!("[[line]]\nname = \"{name}\"\ncan = {{ dbc = \"../motor.dbc\" }}\n");
    let rig = format!(
        "{}{}[[node]]\nname = \"motor\"\nat = [\"front\", \"rear\"]\nreplay = {{ log = \"../motor.log\" }}\n",
        line("front"),
        line("rear")
    );
    let plan = "name = \"plan\"\ntitle = \"Two lines\"\nrig = \"motor\"\nsteps = [{ wait = { duration_s = 1 } }]\n\
                [[measurement]]\nname = \"it\"\ndoc = \"Its speed\"\nquantity = \"motor.rear.Speed\"\nunit = \"rpm\"\n\
                check = { all_within = [0, 9000] }\n";
    let log = "(0.0) front 100#E803\n(0.1) rear 100#8813\n";
    for (name, text) in
        [("motor.dbc", dbc), ("motor.log", log), ("rigs/motor.toml", &*rig), ("plan.toml", plan)]
    {
        fs::write(hil.path(name), text).unwrap();
    }
    hil.run(&["run", "plan.toml", "--out", "run", "--record", "full"]).exits(0);
    hil.run(&["export", "run", "--tables", "tables", "--format", "csv"]).exits(0);
    for (table, front, rear) in [
        (
            "signals",
            ",motor,MotorStatus,Speed,1000.0,rpm,front",
            ",motor,MotorStatus,Speed,5000.0,rpm,rear",
        ),
        (
            "frames",
            ",motor,256,false,false,false,2,e803,front",
            ",motor,256,false,false,false,2,8813,rear",
        ),
    ] {
        let text = fs::read_to_string(hil.path(format!("tables/{table}.csv"))).unwrap();
        assert!(text.contains(front) && text.contains(rear), "{text}");
    }
}

#[test]
fn nodes_beside_the_robot_are_decoded_as_well() {
    let hil = Hil::new();
    hil.run(&["new", "oven"]).exits(0);
    let rig = "devices = \"paper\"\n[[line]]\nname = \"can1\"\ncan = {}\n\
               [[node]]\nname = \"oven\"\nat = \"can1\"\nemulate = \"oven\"\n";
    let plan = "name = \"both\"\ntitle = \"Both\"\nrig = \"both\"\nsteps = [{ bias_test = { duration_s = 5 } }]\n\
                [[measurement]]\nname = \"warm\"\ndoc = \"Temperature\"\nquantity = \"oven.Temperature\"\n\
                unit = \"degC\"\ncheck = { all_within = [0, 90] }\n";
    fs::create_dir(hil.path("oven/rigs")).unwrap();
    fs::write(hil.path("oven/rigs/both.toml"), rig).unwrap();
    fs::write(hil.path("oven/both.toml"), plan).unwrap();
    let within = |arguments: &[&str]| {
        Ran::of(hil.command(arguments).current_dir(hil.path("oven")).output().unwrap())
    };
    within(&["run", "both.toml", "--out", "run", "--record", "full"]).exits(0);
    within(&["export", "run", "--tables", "t", "--format", "csv"]).exits(0);
    let signals = fs::read_to_string(hil.path("oven/t/signals.csv")).unwrap();
    assert!(signals.contains(",base,MOTION,DISPLACEMENT,"), "{signals:.200}");
    let is_of_oven =
        |row: &str| row.contains(",oven,Status,Temperature,") && row.ends_with(",can1");
    assert!(signals.lines().any(is_of_oven), "{signals:.200}");
}
