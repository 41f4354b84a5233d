//! One rig file serves virtual time and a bench that has some of its nodes.

use crate::real_ports::{Bench, charges};
use crate::{hil, shown, summary};
use ports::slcan::SlcanAdapter;
use skips::in_time;

/// This node of the rig is real.
fn has_real(bench: &Bench, node: &str) {
    let path = bench.folder.path().join("bench.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("{text}[node.{node}]\nreal = true\n")).unwrap();
}

#[test]
fn a_node_that_a_bench_has_is_not_emulated_there() {
    in_time(|| {
        let bench = Bench::with_a_charger();
        has_real(&bench, "d");
        bench.emulates_in_its_rig_file();
        let mut child = bench.served(charges);
        assert_eq!(child.wait().unwrap().code(), Some(0));
        let heard = summary(&bench.out);
        assert_eq!(heard["bench"]["real"], serde_json::json!(["d"]), "{heard}");
        assert!(heard["notes"].is_null(), "{heard}");
        // Its silence is nobody else's.
        let mut child =
            bench.served(async |port: &mut SlcanAdapter| while port.receive().await.is_ok() {});
        assert_eq!(child.wait().unwrap().code(), Some(1));
        let recorded = hil().arg("check").arg(&bench.out).output().unwrap();
        assert_eq!(recorded.status.code(), Some(1), "{}", shown(&recorded));
    });
}

#[test]
fn a_bench_has_no_node_that_the_rig_lacks_or_that_the_plan_plays() {
    for node in ["charger", "tester"] {
        let bench = Bench::with_a_charger();
        has_real(&bench, node);
        let output = bench.command().output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", shown(&output));
        let expected = format!("has [node.{node}], and the rig has no such node that can be real");
        assert!(shown(&output).contains(&expected), "{}", shown(&output));
    }
}
