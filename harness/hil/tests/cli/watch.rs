//! `hil run --watch`: a picture on a terminal, plain lines elsewhere, and a restored terminal.
#![cfg(unix)]

use crate::hil::{Hil, TURN};
use crate::pty::AtTerminal;
use skips::in_time;
use std::fs;

/// Half a year of bench time: no run ends before it is stopped.
const ENDLESS: &str = r#"
name = "endless"
title = "Laps without end"
devices = "paper"
steps = [
    { bias_test = { duration_s = 5 } },
    { repeat = { times = 500, steps = [{ repeat = { times = 500, steps = [{ lap = { direction = "cw" } }] } }] } },
]

[[measurement]]
name = "return_orientation"
doc = "Heading at the end of a lap"
quantity = "lap.gyro_error"
unit = "deg"
check = { all_within = [-90, 90] }
"#;

const SIZE: (u16, u16) = (100, 40);

fn endless() -> Hil {
    let hil = Hil::with_plan(TURN);
    fs::write(hil.path("endless.toml"), ENDLESS).unwrap();
    hil
}

#[test]
fn a_picture_that_q_ends_as_an_interrupt_does() {
    let hil = endless();
    let arguments = ["run", "turn.toml", "endless.toml", "--watch", "--out", "out"];
    let mut at = AtTerminal::begin(&hil, &arguments, &[], SIZE);
    at.reads("▶ endless.toml");
    at.reads("✓ turn.toml");
    at.reads("robot: ");
    at.reads("cw lap of a 4 m square");
    at.reads("to go");
    at.sees("a picture of its own screen", |screen| screen.alternate_screen());
    at.types("?");
    at.reads("enlarge a panel, and back");
    at.types("?3");
    at.sees("the gyro alone", |screen| {
        let shown = screen.contents();
        shown.contains("3 gyro") && !shown.contains("robot: ")
    });
    at.types("q");
    let (ran, shown) = at.ends();
    let ran = ran.exits(5);
    assert_eq!(hil.outcome("out/endless-seed1"), "aborted");
    assert!(ran.out.contains("endless: aborted: stopped by request"), "{}", ran.out);
    assert!(shown.contains("turn: passed, bench "), "{shown}");
}

#[test]
fn a_picture_follows_the_size_of_its_terminal() {
    let hil = endless();
    let arguments = ["run", "endless.toml", "--watch", "--out", "out"];
    let mut at = AtTerminal::begin(&hil, &arguments, &[], SIZE);
    at.reads("robot: ");
    at.resize(30, 10);
    at.reads("too small:");
    at.reads("30x10 here");
    at.resize(80, 24);
    at.reads("q stop  p pause  ? help");
    at.types("\u{3}");
    let (ran, _) = at.ends();
    ran.exits(5);
    assert_eq!(hil.outcome("out"), "aborted");
}

#[test]
fn without_colour_nothing_is_coloured() {
    let hil = endless();
    let arguments = ["run", "endless.toml", "--watch", "--out", "out"];
    let mut at = AtTerminal::begin(&hil, &arguments, &[("NO_COLOR", "1")], SIZE);
    at.reads("robot: ");
    at.sees("no colour", |screen| {
        let (rows, columns) = screen.size();
        (0..rows).all(|row| {
            (0..columns).all(|column| {
                screen.cell(row, column).is_none_or(|cell| {
                    (cell.fgcolor(), cell.bgcolor())
                        == (vt100::Color::Default, vt100::Color::Default)
                })
            })
        })
    });
    at.types("q");
    at.ends().0.exits(5);
}

#[test]
fn an_error_and_an_end_give_the_terminal_back() {
    let hil = Hil::with_plan(TURN);
    // The run folder cannot be created: a file is in the way.
    fs::write(hil.path("taken"), "").unwrap();
    let at = AtTerminal::begin(&hil, &["run", "turn.toml", "--watch", "--out", "taken"], &[], SIZE);
    let (ran, shown) = at.ends();
    assert!(ran.status.is_some_and(|status| status > 0), "{ran:?}");
    assert!(shown.contains("refused to replace taken"), "{shown}");
    let at = AtTerminal::begin(&hil, &["run", "turn.toml", "--watch", "--out", "out"], &[], SIZE);
    let (ran, shown) = at.ends();
    ran.exits(0);
    assert!(shown.contains("turn: passed"), "{shown}");
}

#[test]
fn a_question_is_asked_in_the_picture() {
    in_time(question_in_the_picture);
}

fn question_in_the_picture() {
    let hil = Hil::new();
    let plan = r#"
        name = "gap"
        title = "Something to read off"
        devices = "paper-table"
        steps = [{ operator_prompt = { text = "How wide is the gap?", answer = { name = "gap", unit = "mm", range = [-2, 2] } } }]
        [[measurement]]
        name = "gap"
        doc = "The gap"
        quantity = "operator.gap"
        unit = "mm"
        check = { all_within = [1, 2] }
    "#;
    fs::write(hil.path("gap.toml"), plan).unwrap();
    let arguments = [
        "run",
        "gap.toml",
        "--clock",
        "real",
        "--controller",
        "in-process",
        "--out",
        "out",
        "--watch",
    ];
    let mut at = AtTerminal::begin(&hil, &arguments, &[], SIZE);
    at.reads("How wide is the gap?");
    at.types("3 mm\r");
    at.reads("3 mm is out of range");
    at.types("1.55\u{7f} mm\r");
    let (ran, _) = at.ends();
    let ran = ran.exits(0);
    assert!(ran.out.contains("1.5 mm"), "{}", ran.out);
}

#[test]
fn plain_lines_where_there_is_no_terminal() {
    let hil = Hil::with_plan(TURN);
    let ran = hil.run(&["run", "turn.toml", "--watch", "--out", "out"]).exits(0);
    let lines: Vec<&str> = ran.err.lines().collect();
    assert_eq!(lines[0], "no view, plain lines: the standard error is no terminal");
    assert!(ran.err.contains("1.000 s  begin steps[0]: bias test of 5 s"), "{}", ran.err);
    assert!(ran.err.contains("  end steps[1]"), "{}", ran.err);
    assert!(lines.last().unwrap().starts_with("turn: passed, bench "), "{}", ran.err);
    assert!(!ran.err.contains('\u{1b}') && !ran.out.contains('\u{1b}'));
    // A dumb terminal counts as none.
    let dumb = [("TERM", "dumb")];
    let mut at =
        AtTerminal::begin(&hil, &["run", "turn.toml", "--watch", "--out", "out"], &dumb, SIZE);
    at.reads("no view, plain lines: TERM is dumb");
    let (ran, shown) = at.ends();
    ran.exits(0);
    assert!(shown.contains("end steps[1]"), "{shown}");
}

#[test]
fn a_recorded_run_is_replayed_forwards_and_backwards() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--out", "out"]).exits(0);
    let ran = hil.run(&["replay", "out"]).exits(2);
    assert!(ran.err.contains("a replay needs a terminal"), "{}", ran.err);
    let mut at = AtTerminal::begin(&hil, &["replay", "out", "--speed", "0.01"], &[], SIZE);
    at.reads("replay, 0.01 times real time");
    at.types(" ");
    at.reads("real time, paused");
    let end = "\u{1b}[F";
    at.types(end);
    at.sees("the end of the run", |screen| {
        let shown = screen.contents();
        shown.contains("100 % of ") && shown.contains("steps done")
    });
    let home = "\u{1b}[H";
    at.types(home);
    at.sees("its beginning", |screen| {
        let shown = screen.contents();
        shown.contains("bench 0.0 s") && shown.contains("  0 % of ")
    });
    at.types(">");
    at.reads("replay, 0.02 times real time, paused");
    at.types("q");
    at.ends().0.exits(0);
}
