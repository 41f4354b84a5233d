//! Random formulas and traces, and their meaning by definition.

#![allow(dead_code, reason = "each test uses a part")]

pub mod form;
pub mod reference;
pub mod trace;

use temporal::{NotFound, Signal, Signals};

/// The signals `a`, `b` and `c`, without units.
pub struct Letters;

pub const LETTERS: [&str; 3] = ["a", "b", "c"];

impl Signals for Letters {
    fn find(&self, name: &str) -> Result<Signal, NotFound> {
        let index = LETTERS.iter().position(|letter| *letter == name);
        let index = index.ok_or_else(|| NotFound::unknown(name, &LETTERS))?;
        Ok(Signal { index, ..Signal::default() })
    }
}
