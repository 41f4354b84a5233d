//! An emulated table on a port: commands of the plan and their answers cross the kernel.

use crate::can::plan;
use crate::{hil, out, run, shown, summary};
use skips::in_time;

const QUARTERS: &str = r#"
name = "quarters"
title = "A quarter turn each way"
devices = "paper-table"
steps = [
    { use_calibration = "temperature" },
    { bias_test = { duration_s = 5 } },
    { table_turn = { angle_deg = 90, rate_deg_per_s = 30, acceleration_deg_per_s2 = 15 } },
    { table_turn = { angle_deg = -90, rate_deg_per_s = 30, acceleration_deg_per_s2 = 15 } },
]

[[measurement]]
name = "table_error"
doc = "Error of one turn after correction"
quantity = "table.error"
unit = "deg"
check = { all_within = [-0.5, 0.5] }
observations_min = 2
"#;

#[test]
fn an_emulated_table_is_commanded_through_its_port() {
    in_time(|| {
        let (folder, out) = out("table");
        let bench = folder.path().join("bench.toml");
        let link = folder.path().join("table.pty");
        let table = format!("[table]\nport = \"pty:{}\"\nemulated = true\n", link.display());
        std::fs::write(&bench, table).unwrap();
        let plan = plan(folder.path(), QUARTERS);
        let arguments =
            ["run", plan.to_str().unwrap(), "--clock", "real", "--bench", bench.to_str().unwrap()];
        let output = run(&arguments, &out);
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let summary = summary(&out);
        let ports =
            summary["ports"].as_array().unwrap().iter().filter(|port| port["role"] == "table");
        let sides: Vec<_> = ports.collect();
        assert_eq!((&sides[0]["side"], &sides[1]["side"]), (&"plan".into(), &"bench".into()));
        for (from, to) in [(sides[0], sides[1]), (sides[1], sides[0])] {
            let (sent, heard) = (&from["counters"]["bytes_out"], &to["counters"]["bytes_in"]);
            assert!(sent.as_u64().unwrap() > 20, "{summary}");
            assert_eq!(sent, heard, "{summary}");
        }
    });
}

#[test]
fn a_port_whose_other_end_is_out_of_sight_is_bad_input() {
    let (folder, out) = out("table");
    let bench = folder.path().join("bench.toml");
    std::fs::write(&bench, "[table]\nport = \"/dev/ttyS3\"\nemulated = true\n").unwrap();
    let mut run = hil();
    run.args(["run", "live-table-run", "--clock", "real", "--bench"]).arg(bench);
    let output = run.arg("--out").arg(out).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", shown(&output));
    assert!(shown(&output).contains("port = \"pty\""), "{}", shown(&output));
}
