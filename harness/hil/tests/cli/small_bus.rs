//! What a plan makes of the traffic of one node, which a log plays.

use super::hil::{Hil, Ran};
use std::fmt::Write as _;
use std::fs;

const DBC: &str = "VERSION \"\"\n\nBU_: Ut Other\n\n\
    BO_ 256 M: 4 Ut\n SG_ F : 0|32@1- (1,0) [0|0] \"V\" Other\n\n\
    BO_ 257 Y: 1 Ut\n SG_ X : 0|1@1+ (1,0) [0|1] \"\" Other\n SG_ Z : 1|1@1+ (1,0) [0|1] \"\" Other\n\n\
    BO_ 258 B: 8 Ut\n SG_ Q : 0|64@1+ (1,0) [0|0] \"\" Other\n\n\
    BO_ 260 In: 2 Other\n SG_ Val : 0|16@1- (0.5,0) [0|0] \"A\" Ut\n\n\
    VAL_ 257 X 1 \"on\" 0 \"off\" ;\nSIG_VALTYPE_ 256 F : 1;\n";

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

fn period(check: &str, of: &str) -> String {
    let unit = if check.starts_with("all_but") { "1" } else { "s" };
    format!(
        "[[measurement]]\nname = \"m\"\ndoc = \"Time between two of its messages\"\n\
         quantity = \"period.ut.Y\"\nunit = \"{unit}\"\n{of}check = {{ {check} }}\n"
    )
}

#[test]
fn a_node_that_falls_silent_breaks_the_upper_limit_of_its_period() {
    let frames = [0.0, 0.1, 0.2, 0.3, 0.4].map(|at_s| (at_s, "101#00"));
    let judged = |steps: &str, check: &str, of: &str| {
        let (hil, ran) = run(&frames, steps, &period(check, of));
        let one = summary(&hil)["measurements"][0].clone();
        assert_eq!(ran.status, Some(i32::from(one["verdict"] != "pass")), "{ran:?}");
        hil.run(&["check", "run"]).exits(ran.status.unwrap());
        (one["verdict"].as_str().unwrap().to_owned(), one["observations"].as_u64().unwrap())
    };
    let told = |verdict: &str, observations| (verdict.to_owned(), observations);
    let (long, short) = (wait(2.0, "w"), wait(0.6, "w"));
    assert_eq!(judged(&long, "all_within = { at_most = 0.35 }", ""), told("fail", 5));
    // It might still send in time.
    assert_eq!(judged(&short, "all_within = { at_most = 0.35 }", ""), told("pass", 4));
    assert_eq!(judged(&short, "all_within = [0.09, 0.35]", ""), told("pass", 4));
    // How long the period would have been is not known.
    assert_eq!(judged(&long, "mean_within = { at_most = 0.35 }", ""), told("pass", 4));
    assert_eq!(
        judged(&long, "all_but_within = { count = 1, band = [0, 0.35] }", ""),
        told("pass", 5)
    );
    // During the first step it was silent for too long, or not yet.
    let then = format!("{long}, {}", wait(1.0, "v"));
    assert_eq!(
        judged(&then, "all_within = { at_most = 0.35 }", "where = { \"during.w\" = 1 }\n"),
        told("fail", 5)
    );
    assert_eq!(
        judged(&then, "never_outside = { band = [0, 0.35], during = \"w\" }", ""),
        told("fail", 5)
    );
    let then = format!("{short}, {}", wait(1.0, "v"));
    assert_eq!(
        judged(&then, "never_outside = { band = [0, 0.35], during = \"w\" }", ""),
        told("pass", 4)
    );
}

#[test]
fn a_gap_in_a_log_is_judged_up_to_the_end_of_the_log() {
    let judged = |more: &[(f64, &str)]| {
        let frames = [&[(0.0, "101#00"), (0.1, "101#00"), (0.2, "101#00")], more].concat();
        let limit = period("all_within = { at_most = 0.35 }", "");
        let (hil, _) = run(&frames, &wait(1.0, "w"), &limit);
        hil.run(&["import", "rigs/ut.log", "--plan", "./p.toml", "--out", "import"]).status
    };
    assert_eq!(judged(&[]), Some(0));
    assert_eq!(judged(&[(0.9, "102#0000000000000000")]), Some(1));
}

#[test]
fn a_reaction_that_is_waited_for_ends_its_step_when_it_has_come() {
    let frames = [(0.0, "101#00"), (0.1, "101#01"), (0.2, "101#03"), (1.2, "101#00")];
    let step = |limit_s: f64| {
        format!("{{ reaction = \"x\", time_limit_s = {limit_s} }}, {}", wait(0.1, "then"))
    };
    let judged = |to: &str, at_most: f64| {
        format!(
            "[[reaction]]\nname = \"x\"\nfrom = \"ut.X == 1\"\nto = \"{to}\"\n\
             [[measurement]]\nname = \"m\"\ndoc = \"d\"\nquantity = \"step.duration\"\nunit = \"s\"\n\
             check = {{ all_within = [0, {at_most}] }}\n"
        )
    };
    run(&frames, &step(0.5), &judged("ut.Z == 1", 0.21)).1.exits(0);
    run(&frames, &step(0.5), &judged("for 0.2 s: ut.Z == 1", 0.41)).1.exits(0);
    let (hil, ran) = run(&frames, &step(0.35), &judged("for 0.2 s: ut.Z == 1", 0.41));
    assert_ne!(ran.status, Some(0), "it is not held for so long before the limit");
    assert!(
        summary(&hil)["reason"].as_str().unwrap().ends_with(": what it waits for did not come")
    );
}

#[test]
fn numbers_that_a_signal_or_a_double_does_not_have_are_refused() {
    let frames = [(0.0, "102#F1FFFFFFFFFFFF0F")];
    let always = "[[property]]\nname = \"a\"\nalways = \"ut.Q == 1152921504606846960\"\n";
    let told = run(&frames, &wait(1.0, "w"), always).1.exits(2).err;
    assert!(told.contains("values of `ut.Q` beyond 9007199254740992 are not told apart"), "{told}");
    let sends = |value: &str| {
        let send = format!("{{ send = {{ message = \"In\", set = {{ Val = {value} }} }} }}");
        run(
            &frames,
            &format!("{send}, {}", wait(1.0, "w")),
            "[[property]]\nname = \"a\"\nalways = \"ut.Q > 1\"\n",
        )
        .1
    };
    sends("-3.5").exits(0);
    let told = sends("-3.25").exits(2).err;
    assert!(told.contains("it counts in steps of 0.5"), "{told}");
    let (hil, _) =
        run(&frames, &wait(1.0, "w"), "[[property]]\nname = \"a\"\nalways = \"ut.Q > 1\"\n");
    let shown = hil.run(&["show", "run", "--at", "0.5"]).exits(0).out;
    assert!(shown.contains("Q 1152921504606846976"), "{shown}");
}

/// Found by a user: numbers alone.
#[test]
fn values_are_shown_with_their_names() {
    let (hil, ran) = run(
        &[(0.0, "101#03"), (0.5, "101#00")],
        &wait(1.0, "w"),
        "[[property]]\nname = \"a\"\nalways = \"ut.X >= 0\"\n",
    );
    ran.exits(0);
    for (at, text) in [("0.2", "Y: X 1 (on), Z 1"), ("0.8", "Y: X 0 (off), Z 0")] {
        let shown = hil.run(&["show", "run", "--at", at]).exits(0).out;
        assert!(shown.contains(text), "{shown}");
    }
}

/// Found by a user: what an import left out was a note, which no plan could judge.
#[test]
fn foreign_frames_of_a_log_are_judged_as_long_as_the_plan_lasts() {
    let none = "[[measurement]]\nname = \"strange\"\ndoc = \"\"\nquantity = \"unexpected.can0\"\nunit = \"1\"\n\
                check = { all_within = { at_most = 0 } }\n";
    let frames = [(0.0, "101#00"), (1.5, "101#00")];
    let (hil, ran) = run(&frames, &wait(1.0, "w"), none);
    ran.exits(0);
    let log = fs::read_to_string(hil.path("rigs/ut.log")).unwrap();
    for (more, status) in [
        ("", 0),
        ("(1.400000) can0 7FF#00\n", 0),
        ("(0.500000) can0 7FF#00\n", 1),
        ("(0.500000) can0 101#R1\n", 1),
        ("(0.500000) can0 102#00\n", 1),
    ] {
        fs::write(hil.path("more.log"), format!("{log}{more}")).unwrap();
        hil.run(&["import", "more.log", "--plan", "p.toml", "--out", "imported"]).exits(status);
    }
}
