//! Records judged by plans whose rig has other nodes.

use crate::hil::Hil;
use std::fs;

const NODES: &str = r#"
name = "nodes"
title = "A lamp and a fan on one bus"
rig = "ORDER"
steps = [{ wait = { duration_s = 1 } }]

[[measurement]]
name = "brightness"
doc = "What the lamp reports"
quantity = "lamp.Level"
unit = "%"
check = { all_within = [10, 10] }
"#;

const DBC: &str = r#"VERSION ""
BU_: lamp fan
BO_ 256 LampStatus: 1 lamp
 SG_ Level : 0|8@1+ (1,0) [0|100] "%" Vector__XXX
BO_ 257 FanStatus: 1 fan
 SG_ Level : 0|8@1+ (1,0) [0|100] "%" Vector__XXX
"#;

fn node(name: &str, level: u8) -> (String, String) {
    let status = if name == "lamp" { "LampStatus" } else { "FanStatus" };
    let device = format!(
        "name = \"{name}\"\ntitle = \"\"\nsource = \"invented\"\ndbc = \"two.dbc\"\nnode = \"{name}\"\n\n\
         [message.{status}]\nperiod_s = 0.1\n\n[signal.Level]\nexpression = \"{level}\"\n"
    );
    let rig = format!("[[node]]\nname = \"{name}\"\nat = \"can0\"\nemulate = \"{name}\"\n");
    (device, rig)
}

#[test]
fn a_rig_with_other_nodes_than_the_record_is_refused_by_name() {
    let hil = Hil::new();
    for folder in ["devices", "rigs"] {
        fs::create_dir(hil.path(folder)).unwrap();
    }
    fs::write(hil.path("devices/two.dbc"), DBC).unwrap();
    let line =
        "[[line]]\nname = \"can0\"\ncan = { bit_rate = 500000, dbc = \"../devices/two.dbc\" }\n\n";
    let ((lamp, lamp_node), (fan, fan_node)) = (node("lamp", 10), node("fan", 90));
    fs::write(hil.path("devices/lamp.toml"), lamp).unwrap();
    fs::write(hil.path("devices/fan.toml"), fan).unwrap();
    for (order, nodes) in [
        ("lamp-fan", format!("{lamp_node}\n{fan_node}")),
        ("fan-lamp", format!("{fan_node}\n{lamp_node}")),
        ("lamp-only", lamp_node.clone()),
    ] {
        fs::write(hil.path(format!("rigs/{order}.toml")), format!("{line}{nodes}")).unwrap();
        fs::write(hil.path(format!("{order}.toml")), NODES.replace("ORDER", order)).unwrap();
    }
    hil.run(&["run", "lamp-fan.toml", "--out", "run"]).exits(0);
    hil.run(&["check", "run", "--plan", "lamp-fan.toml"]).exits(0);
    for command in ["check", "export", "rerun", "debug"] {
        for other in ["fan-lamp.toml", "lamp-only.toml"] {
            let out: &[&str] = if command == "export" { &["--tables", "out"] } else { &[] };
            let refused = hil.run(&[&[command, "run", "--plan", other], out].concat()).exits(2).err;
            let words = refused.split_whitespace().filter(|word| *word != "|");
            let refused = words.collect::<Vec<_>>().join(" ");
            assert!(refused.contains("lamp on can0, fan on can0"), "{command}: {refused}");
            assert!(refused.contains("in the same order"), "{command}: {refused}");
        }
    }
}

#[test]
fn a_verdict_is_kept_for_the_property_that_it_is_of_and_for_no_other_of_its_name() {
    let hil = Hil::new();
    hil.run(&["new", "oven"]).exits(0);
    let plan = fs::read_to_string(hil.path("oven/settles.toml")).unwrap();
    let stated = |formula: &str| {
        let property = format!("\n[[property]]\nname = \"cool\"\nalways = \"{formula}\"\n");
        fs::write(hil.path("oven/stated.toml"), format!("{plan}{property}")).unwrap();
    };
    let check = ["check", "run", "--plan", "oven/stated.toml"];
    stated("Temperature < 200 degC");
    hil.run(&["run", "oven/stated.toml", "--out", "run"]).exits(0);
    let same = hil.run(&check).exits(0);
    assert!(same.err.contains("cool keeps the verdict of the run"), "{}", same.err);
    stated("Temperature < 0 degC");
    let other = hil.run(&check);
    assert!(other.err.contains("cool is not judged"), "{}", other.err);
    let file = fs::read(hil.path("run/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&file).unwrap();
    let verdict =
        summary["properties"].as_array().unwrap().iter().find(|one| one["name"] == "cool");
    assert!(verdict.unwrap()["held"].is_null(), "{summary}");
}
