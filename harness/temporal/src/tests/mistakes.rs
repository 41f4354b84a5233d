//! Every mistake is reported at its position.

use super::read;
use crate::{Formula, NotFound, Signal, Signals};
use proptest::prelude::*;

/// The text, a marker below the position, the message and the help.
fn table(texts: &[&str]) -> String {
    let mut table = String::new();
    for text in texts {
        let mistake = read(text).expect_err(text);
        let before = text[..mistake.at.start].chars().count();
        let within = text[mistake.at.clone()].chars().count();
        let marks = " ".repeat(before) + &"^".repeat(within.max(1));
        let help = mistake.help.map_or(String::new(), |help| format!("; {help}"));
        table += &format!("{text}\n{marks} {}{help}\n", mistake.message);
    }
    table
}

#[test]
fn words_that_do_not_fit() {
    insta::assert_snapshot!(table(&[
        "",
        "Speed >",
        "Speed > 3 Count",
        "(Speed > 3",
        "Speed > 3)",
        "Speed = 3",
        "Speed > 3 & Count > 1",
        "Speed > 3 => Count > 1",
        "Speed > 1.2.3",
        "Speed > 1e999",
        "Speed § 3",
        "manager.State == \"Ready",
        "and Speed > 3",
        "abs Speed > 3",
        "abs(Speed > 3) > 1",
        "min(Speed) > 3",
        "Speed(3) > 1",
        "Speed > within 1 s: Count > 1",
        "rises(Speed)",
        "changes(Speed > 3)",
    ]));
}

#[test]
fn signals_that_nobody_knows() {
    insta::assert_snapshot!(table(&[
        "cells.VoltagMax > 4",
        "signal.cells.VoltageMax > 4",
        "rpm > 4",
        "Voltage > 4",
        "manager.State == \"Redy\"",
        "manager.State == \"Off\" and Speed > 1",
        "Speed == \"Fast\"",
        "manager.State + 1 == \"Ready\"",
        "manager.State > \"Ready\"",
        "manager.State == \"Ready\" + 1",
        "\"Ready\"",
    ]));
}

#[test]
fn numbers_and_conditions() {
    insta::assert_snapshot!(table(&[
        "Speed",
        "Speed and Count > 1",
        "not Speed",
        "Speed + Count -> Count > 1",
        "(Speed > 3) == (Count > 1)",
        "(Speed > 3) + 1 > 2",
        "-(Speed > 3) > 2",
        "1 < 2",
        "1 == 2 +- 3",
        "Speed < 3 +- 1",
        "Count == 3 +- -1",
        "1 < Speed > 2",
        "1 == Speed == 2",
        "1 < Speed < 3 < Count",
    ]));
}

#[test]
fn units_that_do_not_fit() {
    insta::assert_snapshot!(table(&[
        "cells.VoltageMax > 4.25 A",
        "4.25 A < cells.VoltageMax",
        "cells.VoltageMax > 4.25 volt",
        "cells.VoltageMax > cells.Current",
        "cells.VoltageMax + Speed > 3",
        "Speed > 50 km / h",
        "Temperature > 300 K",
        "Count > 5 V",
        "Flow > 5 V",
        "cells.VoltageMax * cells.Current > 5 V",
        "1 V < cells.VoltageMax < 2 A",
        "cells.VoltageMax == 4 V +- 1 %",
    ]));
}

#[test]
fn times_and_windows() {
    insta::assert_snapshot!(table(&[
        "within: Speed > 3",
        "within 100: Speed > 3",
        "within 100 V: Speed > 3",
        "within -1 s: Speed > 3",
        "within 0 s: Speed > 3",
        "for 0: Speed > 3",
        "within 100 ms Speed > 3",
        "within [0 s, 1 s]: Speed > 3",
        "within 0.5 ns: Speed > 3",
        "within 1e-12 s: Speed > 3",
        "within 1.5 ns: Speed > 3",
        "within 61 min: Speed > 3",
        "for 40 min: within 30 min: Speed > 3",
        "always: Speed > 3",
        "eventually: Speed > 3",
        "always [1 s]: Speed > 3",
        "always [2 s, 1 s]: Speed > 3",
        "once [2 s, 1 s]: Speed > 3",
        "always [1, 2 s]: Speed > 3",
        "Speed > 3 until Count > 1",
        "Speed > 3 until [1 s, 2 s Count > 1",
    ]));
}

#[test]
fn what_could_be_read_in_two_ways() {
    insta::assert_snapshot!(table(&[
        "within 1 s: Speed > 3 -> Count > 1",
        "Count > 1 -> for 1 s: not Speed > 3 -> Count > 1",
        "Speed > 3 and Count > 1 until [0, 1 s] Count > 2",
        "Count > 1 since Speed > 3 or Count > 2",
        "Count > 1 since Count > 2 since Count > 3",
    ]));
}

/// Two whole numbers of 64 bits.
struct Serials;

impl Signals for Serials {
    fn find(&self, name: &str) -> Result<Signal, NotFound> {
        let index = usize::from(name != "Serial");
        let range = Some((0.0, 18_446_744_073_709_551_615.0));
        Ok(Signal { index, range, step: 1.0, ..Signal::default() })
    }
}

#[test]
fn numbers_that_doubles_do_not_tell_apart() {
    let read = |text: &str| Formula::parse(text, &Serials);
    for fits in ["Serial == 9007199254740992", "Serial - Other > 3", "Serial < 1e15"] {
        assert!(read(fits).is_ok(), "{fits}");
    }
    for text in [
        "Serial == 1152921504606846960",
        "1152921504606846960 < Serial",
        "Serial != 1152921504606846960 +- 1",
        "Serial == Other",
    ] {
        let mistake = read(text).expect_err(text);
        let told = "values of `Serial` beyond 9007199254740992 are not told apart";
        assert_eq!(mistake.message, told, "{text}");
    }
}

#[test]
fn what_is_too_long_or_too_deep() {
    let deep = "(".repeat(200) + "Count > 1" + &")".repeat(200);
    assert_eq!(read(&deep).expect_err("deep").message, "nested too deeply");
    for prefix in ["not ", "-", "within 1 ns: ", "rises(", "abs("] {
        let mistake = read(&prefix.repeat(150)).expect_err(prefix);
        assert_eq!(mistake.message, "nested too deeply", "{prefix}");
    }
    let arrows = "Count > 1 -> ".repeat(100) + "Count > 1";
    assert_eq!(read(&arrows).expect_err("arrows").message, "nested too deeply");
    assert_eq!(read(&"Count+".repeat(400)).expect_err("long").at, 0..2_400);
    // A long formula is not deeply nested.
    assert!(read(&("Count > 1 or ".repeat(150) + "Count > 1")).is_ok());
}

proptest! {
    #[test]
    fn no_text_makes_it_panic(text in "[-+*/%<>=!&|()\\[\\]:,. a-z0-9\"§]{0,40}") {
        let _ = read(&text);
    }

    #[test]
    fn no_order_of_words_makes_it_panic(words in prop::collection::vec(prop::sample::select(vec![
        "Speed", "Count", "manager.State", "\"Ready\"", "3", "4 V", "50 km/h", "100 ms", "[0, 1 s]", "(", ")", ":", ",",
        "->", "and", "or", "not", "until", "since", "within", "for", "once", "always", "historically", "rises(",
        "changes(", "abs(", "min(", "<", ">=", "==", "+-", "+", "-", "*", "/",
    ]), 0..14)) {
        let text = words.join(" ");
        if let Err(mistake) = read(&text) {
            prop_assert!(text.get(mistake.at.clone()).is_some(), "{text}: {:?}", mistake.at);
        }
    }
}
