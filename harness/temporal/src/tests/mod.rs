//! The meaning of formulas, and the mistakes in invalid ones.

mod mistakes;
mod monitors;
mod not_finite;
mod reactions;
mod readings;
mod shares;

use crate::{Formula, Mistake, NotFound, Signal, Signals};
use wire::time::Timestamp;

/// Signals of a car, each with its unit and the names of its values.
struct Car;

const NAMES: [&str; 8] = [
    "cells.VoltageMax",
    "cells.Current",
    "manager.State",
    "Speed",
    "Wheel.Speed",
    "Temperature",
    "Count",
    "Flow",
];
const MESSAGES: [&str; 2] = ["Request", "cells.Answer"];
const UNITS: [&str; 8] = ["V", "mA", "", "km/h", "m/s", "degC", "", "drops"];

impl Signals for Car {
    fn find(&self, name: &str) -> Result<Signal, NotFound> {
        if name == "Voltage" {
            return Err(NotFound::ambiguous(name, &["cells.Voltage", "pack.Voltage"]));
        }
        let index = NAMES.iter().position(|known| *known == name);
        let index = index.ok_or_else(|| NotFound::unknown(name, &NAMES))?;
        let names =
            if index == 2 { vec![("Idle".into(), 0.0), ("Ready".into(), 3.0)] } else { vec![] };
        Ok(Signal { index, unit: UNITS[index].to_owned(), names, ..Signal::default() })
    }

    fn message(&self, name: &str) -> Result<Signal, NotFound> {
        let index = MESSAGES.iter().position(|known| *known == name);
        let index = index.ok_or_else(|| NotFound::unknown(name, &MESSAGES))?;
        Ok(Signal { index: NAMES.len() + index, ..Signal::default() })
    }
}

fn read(text: &str) -> Result<Formula, Mistake> {
    Formula::parse(text, &Car)
}

fn formula(text: &str) -> Formula {
    read(text).unwrap_or_else(|mistake| panic!("{text}: {mistake}"))
}

fn at(nanos: i64) -> Timestamp {
    Timestamp::from_nanos(nanos)
}

#[test]
fn bits_and_hexadecimal_numbers_are_read() {
    formula("bit_and(Count, 0x6F) == 0x27");
    formula("0x1F <= Count");
    assert_eq!(read("Count == 0x").unwrap_err().to_string(), "`0x` is not a hexadecimal number");
    let one = read("bit_and(Count) == 1").unwrap_err().to_string();
    assert_eq!(one, "`bit_and` takes two numbers or more");
}
