//! Devices that their users describe without writing Rust: a [`Layout`] from a DBC or from TOML, states and
//! signals from expressions, steps and CSV, and a [`Device`] that does what the [`Description`] says.
//!
//! Nothing here does IO or reads a clock; the verbs of [`Device`] are those of all emulators.
//!
//! ```toml
//! name = "oven"
//! title = "Temperature controller of an oven"
//! dbc = "oven.dbc"            # messages and signals
//! node = "Oven"               # it sends that node's messages and hears the others
//!
//! [parameter.ambient]         # plans set it
//! value = 20.0
//! unit = "degC"
//!
//! [state.temperature]         # `rate`: its derivative per second
//! start = "ambient"
//! rate = "(120 * heater - (temperature - ambient)) / 300"
//! [state.heater]              # or `value`: what it is
//! value = "if(Enable and temperature < Setpoint, 1, 0)"
//!
//! [signal.Temperature]        # of a message that it sends
//! expression = "temperature"
//! noise = 0.05                # rms, in the signal's unit
//!
//! [message.Status]            # what the DBC does not say
//! period_s = 0.1
//! [message.Command]
//! initial = { Setpoint = 20 } # until the first one has come
//! timeout_s = 1.0             # and again when none has come for so long
//! ```
//!
//! # What a file has
//!
//! | key | meaning |
//! |---|---|
//! | `name`, `title`, `source` | the name that random numbers belong to; what it is; where its numbers are from |
//! | `dbc`, `node` | the layout, and which node of it the device is |
//! | `[serial]` | `baud`, `data_bits`, `parity`, `stop_bits` of a serial line |
//! | `step_s` | step of the integration (classic Runge-Kutta of order four), 10 ms |
//! | `[parameter.NAME]` | `value`, `unit`, `minimum`, `maximum`, `doc` |
//! | `[state.NAME]` | `start` (of parameters), one of `rate` and `value` (or neither, where a machine sets it), `unit`, `doc` |
//! | `[machine.NAME]` | `states`, `start`, `transitions` (`from`, `to`, `when`, `on`, `after_s`, `set`), `enter` |
//! | `[table.NAME]` | `x` and `y`, or `x`, `y` and `z`, or `csv`; `outside` |
//! | `[signal.NAME]` | `expression`, `in.MACHINE = { STATE = ... }`, or `steps = [[t, value], ...]`, or `csv` with the columns `time` and `value`; `interpolate`, `repeat`; `noise`; a `model` of the sensor that reads it, below |
//! | `[message.NAME]` | sent: `period_s` and `send`, or `answers = "Command"` with `delay_s`, `when`, `times`, `every_s`, `busy`; heard: `initial`, `timeout_s`, `while_answering`, `queue`; either: `counter`, `checksum`, `e2e`, below |
//!
//! A signal that nobody drives is sent as its start value (`GenSigStartValue`), or as zero; a multiplexer that
//! nobody drives takes its pages in turn. Where several messages have a signal of one name, write
//! `[signal."Status.Temperature"]`, and `Command.Setpoint` in expressions.
//!
//! `[state."cell[1..96]"]` is `cell1` to `cell96` and the array `cell`, with `i` as the index in its expressions; the
//! same of parameters, and of signals, where `[signal."CellVoltage[01..96]"]` has numbers of two digits.
//!
//! # Layouts without a DBC
//!
//! `[[message]]` tables have the keys of `[message.NAME]` too, and say who sends them (`sent_by`). On CAN a
//! message has a `can_id`; on a serial line it is a packet or a line of text:
//!
//! ```toml
//! [serial]
//! baud = 115200
//! [[message]]
//! name = "Status"
//! sent_by = "device"
//! start = [0xAA, 0x55]
//! checksum = "crc16-modbus"   # sum8, xor8 or a CRC of the catalogue; `checksum_order`, `checksum_over`
//! fields = [
//!   { name = "Temperature", type = "i16", scale = 0.01, unit = "degC", order = "little" },
//!   { name = "HeaterOn", type = "u8" },
//! ]
//! [[message]]
//! name = "Reading"
//! sent_by = "device"
//! text = "T={Pressure:.2} P={Power:.0}\r\n"
//! ```
//!
//! Fields lie one behind the other, of the types `u8` to `u64`, `i8` to `i64` (24 bits too), `f32` and `f64`.
//! The checksum stands behind them, least significant byte first unless `checksum_order = "big"`, and covers
//! what is behind the start bytes unless `checksum_over = "all"`. In a line the format behind the colon is that
//! of a number: sign, zeros, width, decimals (`{X:+08.3}`).
//!
//! # Counters and checksums
//!
//! ```text
//! [message.Status]
//! e2e = { profile = "1C", data_id = 0x123, counter = "Alive", checksum = "Crc" }   # AUTOSAR: 1A, 1B, 1C, 2, 4, 5
//! [message.Command]
//! counter = { signal = "Count", first = 0, step = 1, modulo = 15, max_delta = 3 }
//! checksum = { signal = "Sum", crc = "crc8-sae-j1850", bytes = [0, 6], prepend = [], append = [0x02, 0x00] }
//! ```
//!
//! Both are signals of the message. [`Outbox`] puts them in, and a [`Decoder`] says what it thinks of them
//! ([`Verdict`]). A [`Device`] does not use what is not right, and [`Device::refused`] counts it. A counter or a checksum
//! with a `[signal.NAME]` of its own is sent as that says, and the other covers it.
//!
//! # On a change
//!
//! ```text
//! [message.Button]
//! send = "cyclic_and_on_change"          # or cyclic, on_change, on_event
//! period_s = 1.0
//! fast_period_s = 0.02                   # after a change, and
//! fast_times = 3                         # so often
//! min_delay_s = 0.01                     # behind the one before
//! ```
//!
//! A DBC says the same in `GenMsgSendType`, `GenSigSendType`, `GenMsgCycleTimeFast`, `GenMsgNrOfRepetition` and
//! `GenMsgDelayTime`. Values are looked at, without their noise, at the ends of steps and when a message has been heard.
//! `on_event` is a change to another value than the signal's start value.
//!
//! # Sensors
//!
//! ```text
//! [signal.Rate]
//! expression = "yaw_rate"     # what is true, in the signal's unit; or `steps`, or `csv`
//! model = "gyro.model.toml"   # how the sensor errs: what was identified from measured data
//! temperature = "case"        # where the model sees one, degC; and `heading`, deg
//! ```
//!
//! The signal is what is true with the model's terms, late by its lag and its latency, within its dead zone and range. A
//! model of a gyro is for rates, one of kind `sensor` for what it was measured in; what else it sees is the variable of
//! that name. What is true goes straight from one message to the next.
//!
//! # Expressions
//!
//! | written | meaning |
//! |---|---|
//! | `t`, `pi` | seconds since power-on; 3.14159... |
//! | a name | a parameter, a state, or a signal of a message that is heard |
//! | `+ - * / % ^` | as in mathematics: `-x^2` is `-(x^2)`, `2^3^2` is `2^9`; `%` has the sign of its right side |
//! | `< <= > >= == !=` | 1 where it is so, else 0; they do not chain |
//! | `and or not` | of numbers that are not 0 |
//! | `if(c, a, b)` | `a` where `c` is not 0, else `b` |
//! | `min(a, b, ...)`, `max(a, b, ...)`, `clamp(x, low, high)` | |
//! | `abs sign floor ceil round sqrt exp ln log10` | of one value |
//! | `sin cos tan asin acos atan tanh`, `atan2(y, x)` | in radians |
//! | `cell[i]`, `cell[Request.Index]` | an element of an array |
//! | `min max sum mean argmin argmax` `(cell)` | of a whole array |
//! | `ocv(soc)`, `map(x, y)` | the value of a table |
//! | `mode == "Closed"`, `time_in(mode)` | the state of a machine, also the named value of a signal that is heard; seconds in the state |
//! | `part` | which message of an answer it is, from 1 |
//! | `last(state)` | the state at the end of the step before: for what latches |
//!
//! A state whose `value` uses `last` changes at the ends of steps alone, as the output of a sampled controller
//! does. States with a `value` follow from one another in the order that they need; a circle is refused.
//!
//! What is not finite (a division by zero, say) leaves what was before, and [`Device::not_finite`] counts it.
//! What is beyond the range of its signal is sent as the range's end, and [`Device::clipped`] counts it.
//!
//! The expressions are this crate's own: those of the crates for it either bind a sign tighter than a power
//! (`-2^2` would be 4), or divide whole numbers as whole numbers, or take their functions from the platform.

mod description;
mod device;
mod error;
mod expression;
mod file;
mod files;
pub mod hint;
mod layout;
mod lookup;
mod outbox;
mod place;
mod protection;
mod steps;
mod toml_mistake;
mod transport;

pub use description::Description;
pub use device::Device;
pub use error::FileError;
pub use files::Files;
pub use layout::{
    ByteOrder, Carried, DbcNode, Decoded, Decoder, EncodeError, Layout, Medium, Message, NOBODY,
    Note, SIGNAL_BITS_MAX, Selection, SendKind, SendRule, Sender, Signal, SignalName, dbc_nodes,
    dbc_text,
};
pub use outbox::Outbox;
pub use protection::{ProtectionTable, Verdict};
pub use steps::{Input, Step, Steps};

/// The JSON Schema of a description, in either of its forms, for editors.
pub fn schema(generator: schemars::SchemaGenerator) -> schemars::Schema {
    generator.into_root_schema_for::<file::File<file::Messages>>()
}
