//! Signal temporal logic over the signals of a bus, as a plan writes it, judged while a run goes.
//!
//! ```text
//! cells.VoltageMax > 4.25 V -> within 100 ms: manager.ContactorCommand == 0
//! rises(Brake.Pressed) -> within 20 ms: (LampRequest == 1 and for 200 ms: LampRequest == 1)
//! rises(BmsState == "Charging") -> (BmsState == "Charging" until [0 s, 30 min] CellMax >= 4.2 V)
//! falls(Ignition == "On") -> not once [0 s, 5 s]: Speed > 3 km/h
//! ```
//!
//! # The language
//!
//! ```text
//! formula     = or [ "->" formula ]                        a -> b: b holds wherever a does
//! or          = and { "or" and }                           also ||
//! and         = timed { "and" timed }                      also &&
//! timed       = not [ "until" window not | "since" [ window ] not ]
//! not         = "not" not | ahead | comparison             also !
//! ahead       = "within" time ":" or                       at some moment from now to `time` later
//!             | "for" time ":" or                          at every moment from now to `time` later
//!             | "eventually" window ":" or                 at some moment of the window
//!             | "always" window ":" or                     at every moment of the window
//!             | "once" [ window ] ":" or                   at some moment that far back
//!             | "historically" [ window ] ":" or           at every moment that far back
//! comparison  = sum [ compare sum [ compare sum ] ]        1 < x <= 2
//!             | sum ( "==" | "!=" ) sum "+-" sum           x == 5 V +- 100 mV; also ±
//!             | signal ( "==" | "!=" ) '"' name '"'        State == "Ready"
//!             | signal ( "follows" | "fits" )              of a counter, of a checksum
//! compare     = "<" | "<=" | ">" | ">=" | "==" | "!="
//! sum         = product { ( "+" | "-" ) product }
//! product     = factor { ( "*" | "/" ) factor }
//! factor      = "-" factor | number [ unit ] | signal | "(" formula ")"
//!             | "abs(" sum ")" | "min(" sum { "," sum } ")" | "max(" sum { "," sum } ")"
//!             | "rises(" formula ")" | "falls(" formula ")" | "changes(" sum ")"
//! window      = "[" time "," time "]"                      the nearer end first
//! time        = number ( "ns" | "us" | "ms" | "s" | "min" | "h" ) | "0"
//! signal      = letters, digits, "_" and "."               node.Message.Signal, node.Signal, Signal
//! ```
//!
//! A colon reaches as far to the right as it can: to a closing parenthesis, a `->` or the end. What could be
//! read in two ways is refused: `->` behind what a colon reaches, and `and` or `or` beside an `until` without
//! parentheses. What looks ahead says how far, up to an hour: `until`, `always` and `eventually` have a window.
//! The past has no such bound: `once`, `historically` and `since` go back to the start of the run without one.
//!
//! Units are checked. A number with a unit is converted to that of the signal beside it (`4250 mV` to V,
//! `50 km/h` to m/s), a bare one has it already. Signals of different units are converted where their kind is
//! the same, and products and quotients have the unit that follows. A unit that no table knows fits itself. A
//! number with a unit beside a signal without one is a mistake.
//!
//! `Status.Counter follows` is true from a message whose counter follows that of the message before to the next, and
//! `Status.Crc fits` where the checksum is that of the message. The caller says which signals are that.
//!
//! # What it means
//!
//! A formula is true or false at every moment, with a robustness: how far the signals could move before that
//! changes. `x > c` is `x - c`, `==` is `-|x - c|`, each as a share of how far the two can be apart by the ranges of their
//! signals ([`Signal::range`]; without one in their unit), so that volts and revolutions are weighed alike. `and` and
//! `always` take the least, `or` and `eventually` the greatest, `not` changes the sign. Truth is decided beside it: at a
//! robustness of zero `x >= c` holds and `x > c` does not.
//!
//! * **Time** is whole nanoseconds. A signal keeps its value until the next update; of several at one moment the
//!   last counts. Windows are closed: `within 100 ms` includes the moment 100 ms later. `rises(p)` is true at
//!   the one nanosecond at which `p` is true and was not just before; `changes(x)` likewise, by how far.
//! * **`p until [a, b] q`**: `q` holds at some moment of the window, and `p` at every moment from now until just
//!   before it. `p since q`: `q` held at some moment, and `p` at every one after it until now.
//! * **Unknown** is a third truth (Kleene's): a comparison is unknown while a signal in it has no value, not yet
//!   or because its reading is not a number. `and` with something false is false nevertheless, and so on. What
//!   is unknown is not judged.
//! * **The start.** For `once`, `historically` and the right side of `since` the run begins when that is first
//!   known: earlier moments do not exist. At some moment of none is false, at every moment of none is true.
//! * **The end.** What follows the run is unknown. A moment whose truth hangs on that is *open*: no violation.
//!
//! # What to use
//!
//! [`Formula::parse`] reads a formula, with [`Signals`] to find its signals and [`Mistake`] to say what is wrong
//! where. [`Monitor`] judges it at every moment and gives a [`Verdict`]. [`Evaluator`] gives the truth itself
//! over time. [`Reaction`] measures how long an answer takes. All of them take updates in the order of time and
//! keep what changed within the formula's horizon, and no more: an update costs the same however long the
//! windows are, on average.
//!
//! # Sources
//!
//! * O. Maler, D. Nickovic, "Monitoring temporal properties of continuous signals", FORMATS 2004: the logic.
//! * A. Donzé, O. Maler, "Robust satisfaction of temporal logic over real-valued signals", FORMATS 2010:
//!   robustness.
//! * A. Donzé, T. Ferrère, O. Maler, "Efficient robust monitoring for STL", CAV 2013: `until` by parts.
//! * D. Lemire, "Streaming maximum-minimum filter using no more than three comparisons per element", 2006.

mod evaluator;
mod formula;
mod history;
mod mistake;
mod monitor;
mod network;
mod number;
mod operators;
mod parse;
mod reaction;
mod signals;
mod stream;
mod truth;
mod unit;
mod verdict;

#[cfg(test)]
mod tests;

pub use evaluator::{Evaluator, Stretch};
pub use formula::{Formula, Used};
pub use mistake::Mistake;
pub use monitor::Monitor;
pub use reaction::{Answer, Reaction};
pub use signals::{NotFound, Protecting, Signal, Signals};
pub use truth::Truth;
pub use verdict::{Verdict, Violation};
