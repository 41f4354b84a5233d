//! Signal temporal logic over the signals of a bus, in the notation of plans, evaluated during a run.
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
//!             | "bit_and(" sum { "," sum } ")"             bits: bit_and(Status, 0x6F) == 0x27
//!             | "rises(" formula ")" | "falls(" formula ")" | "changes(" sum ")"
//!             | "sent(" message ")"
//! window      = "[" time "," time "]"                      the nearer end first
//! time        = number ( "ns" | "us" | "ms" | "s" | "min" | "h" ) | "0"
//! signal      = letters, digits, "_" and "."               node.Message.Signal, node.Signal, Signal
//! message     = letters, digits, "_" and "."               node.Message
//! ```
//!
//! A colon extends as far to the right as possible: to a closing parenthesis, a `->` or the end. Ambiguous text is
//! rejected: `->` after the scope of a colon, and `and` or `or` beside an `until` without parentheses. Operators that
//! look ahead have a bound of at most an hour: `until`, `always` and `eventually` have a window. Operators on the past
//! need none: `once`, `historically` and `since` without a window go back to the start of the run.
//!
//! Units are checked. A number with a unit is converted to that of the signal beside it (`4250 mV` to V, `50 km/h` to
//! m/s); a bare number is taken in the signal's unit. Signals with different units of the same dimension are converted,
//! and products and quotients have the resulting unit. An unknown unit matches only itself. A number with a unit beside
//! a signal without one is a mistake.
//!
//! `Status.Counter follows` is true from a message whose counter continues that of the previous message until the next
//! message; `Status.Crc fits` likewise, if the checksum matches the message. The caller knows which signals are
//! counters and checksums.
//!
//! `sent(Status)` is true at the single nanosecond at which such a message arrives, and false at all other moments: it
//! is never unknown. `not sent(Secret)` says that no such message is ever sent.
//!
//! # Semantics
//!
//! A formula is true or false at every moment, with a robustness: how far the signals could move before its truth
//! changes. `x > c` has robustness `x - c`, `==` has `-|x - c|`, each as a share of the largest possible distance by
//! the ranges of the signals ([`Signal::range`]; in their unit without one), so that volts and revolutions have equal
//! weight. `and` and `always` take the minimum, `or` and `eventually` the maximum, and `not` inverts the sign. Truth is
//! decided separately: at a robustness of zero `x >= c` holds and `x > c` does not.
//!
//! * **Time** is in whole nanoseconds. A signal keeps its value until the next update; of several at one moment the
//!   last counts. Windows are closed: `within 100 ms` includes the moment 100 ms later. `rises(p)` is true at the
//!   single nanosecond at which `p` is true and was not before: false, or not known since the start; `changes(x)`
//!   likewise, with the size of the change as robustness. A first value is a change, as with RTAMT and with `$rose` of
//!   IEEE 1800. A reading of NaN in between is no change.
//! * **`p until [a, b] q`**: `q` holds at some moment of the window, and `p` at every moment from now until just before
//!   it. `p since q`: `q` held at some moment, and `p` at every later moment until now.
//! * **Unknown** is a third truth value (Kleene): a comparison is unknown while one of its signals has no value, either
//!   not yet or because its reading is NaN. `and` with a false operand is still false, and so on. Unknown moments are
//!   not judged. [`Verdict::no_number`] is the first of them that would be known if a reading, NaN or infinite, were a
//!   number.
//! * **The start.** For `once`, `historically` and the right side of `since` the run begins when their operand is first
//!   known: earlier moments do not exist. "At some moment" of an empty set is false, "at every moment" of an empty set
//!   is true.
//! * **The end.** Everything after the run is unknown. A moment whose truth depends on that is *open*: not a violation.
//!
//! # Use
//!
//! [`Formula::parse`] parses a formula; [`Signals`] resolves its signals, and a [`Mistake`] describes an error and its
//! position. [`Monitor`] judges the formula at every moment and gives a [`Verdict`]. [`Evaluator`] gives the truth over
//! time. [`Reaction`] measures response times. All of them take updates in time order and store only the changes within
//! the formula's horizon. The mean cost of an update does not depend on the length of the windows.
//!
//! # Sources
//!
//! * O. Maler, D. Nickovic, "Monitoring temporal properties of continuous signals", FORMATS 2004: the logic.
//! * A. Donzé, O. Maler, "Robust satisfaction of temporal logic over real-valued signals", FORMATS 2010:
//!   robustness.
//! * A. Donzé, T. Ferrère, O. Maler, "Efficient robust monitoring for STL", CAV 2013: `until` by parts.
//! * D. Lemire, "Streaming maximum-minimum filter using no more than three comparisons per element", 2006.

#![allow(
    missing_docs,
    reason = "a crate of this workspace; what others use is documented where `harness` exports it"
)]

mod evaluator;
mod formula;
mod history;
mod mistake;
mod monitor;
mod network;
mod not_finite;
mod number;
mod operators;
mod parse;
mod question;
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
pub use unit::units_differ;
pub use verdict::{NoNumber, Verdict, Violation};
