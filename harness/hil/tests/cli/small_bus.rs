//! What a plan makes of the traffic of one node, which a log plays.

use super::hil::{Hil, Ran};
use std::fmt::Write as _;
use std::fs;

const DBC: &str = "VERSION \"\"\n\nBU_: Ut Other\n\n\
    BO_ 256 M: 4 Ut\n SG_ F : 0|32@1- (1,0) [0|0] \"V\" Other\n\n\
    BO_ 257 Y: 1 Ut\n SG_ X : 0|1@1+ (1,0) [0|1] \"\" Other\n SG_ Z : 1|1@1+ (1,0) [0|1] \"\" Other\n\n\
    BO_ 258 B: 8 Ut\n SG_ Q : 0|64@1+ (1,0) [0|0] \"\" Other\n\n\
    BO_ 260 In: 2 Other\n SG_ Val : 0|16@1- (0.5,0) [0|0] \"A\" Ut\n\n\
    SIG_VALTYPE_ 256 F : 1;\n";

const RIG: &str = "title = \"One node\"\n\
    [[line]]\nname = \"can0\"\ncan = { bit_rate = 500_000, dbc = \"../bus.dbc\" }\n\
    [[node]]\nname = \"ut\"\nat = \"can0\"\nreplay = { log = \"ut.log\" }\n\
    [[node]]\nname = \"other\"\nat = \"can0\"\ntester = true\n";

/// Runs a plan with these steps while the node sends these frames, each with its time in s.
fn run(frames: &[(f64, &str)], steps: &str, judged: &str) -> (Hil, Ran) {
    let hil = Hil::new();
    fs::create_dir(hil.path("rigs")).unwrap();
    fs::write(hil.path("bus.dbc"), DBC).unwrap();
    fs::write(hil.path("rigs/one.toml"), RIG).unwrap();
    let mut log = String::new();
    for (at_s, frame) in frames {
        writeln!(log, "({at_s:.6}) can0 {frame}").unwrap();
    }
    fs::write(hil.path("rigs/ut.log"), log).unwrap();
    let plan = format!("name = \"p\"\ntitle = \"\"\nrig = \"one\"\nsteps = [{steps}]\n{judged}");
    fs::write(hil.path("p.toml"), plan).unwrap();
    let ran = hil.run(&["run", "./p.toml", "--record", "full", "--out", "run"]);
    (hil, ran)
}

/// The result of the only measurement or property.
fn summary(hil: &Hil) -> serde_json::Value {
    serde_json::from_slice(&fs::read(hil.path("run/summary.json")).unwrap()).unwrap()
}

fn wait(duration_s: f64, label: &str) -> String {
    format!("{{ wait = {{ duration_s = {duration_s} }}, label = \"{label}\" }}")
}

#[test]
fn a_property_does_not_hold_while_its_signal_is_nan() {
    const ONE: &str = "100#0000803F";
    const NAN: &str = "100#0000C07F";
    let frames = [(0.0, ONE), (0.2, NAN), (0.4, NAN)];
    for formula in
        ["ut.F < 5 V", "-5 V < ut.F < 5 V", "not (ut.F > 5 V)", "ut.F > 5 V -> ut.X == 1"]
    {
        let always = format!("[[property]]\nname = \"a\"\nalways = \"{formula}\"\n");
        let (hil, ran) = run(&frames, &wait(1.0, "w"), &always);
        ran.exits(1);
        let told = &summary(&hil)["properties"][0]["what"];
        assert_eq!(told, "ut.F is NaN: neither true nor false", "{formula}");
        hil.run(&["check", "run"]).exits(1);
        let (hil, ran) = run(&frames[1..], &wait(1.0, "w"), &always);
        ran.exits(1);
        let told = &summary(&hil)["properties"][0]["what"];
        assert_eq!(told, "ut.F is NaN: neither true nor false", "{formula}");
    }
    let sometimes = "[[property]]\nname = \"a\"\nsometimes = \"ut.F < 5 V\"\n";
    run(&frames, &wait(1.0, "w"), sometimes).1.exits(0);
    run(&frames[1..], &wait(1.0, "w"), sometimes).1.exits(1);
}
