//! Devices that users describe without writing Rust: a [`Layout`] from a DBC or from TOML, states and signals from
//! expressions, steps and CSV, and a [`Device`] that executes the [`Description`].
//!
//! Nothing here does IO or reads a clock; [`Device`] has the same verbs as all emulators.
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
//! # Keys of a file
//!
//! | key | meaning |
//! |---|---|
//! | `name`, `title`, `source` | the key of its random numbers; a short description; the source of its numbers |
//! | `dbc`, `node` | the layout, and the device's node in it |
//! | `eds`, `node_id` | instead: the EDS of a CANopen device, see `docs/canopen.md`, and its node identifier |
//! | `[object.NAME]`, `[emergency.NAME]` | objects of the EDS and errors |
//! | `[serial]` | `baud`, `data_bits`, `parity`, `stop_bits` of a serial line |
//! | `step_s` | step of the integration (classic Runge-Kutta of order four), 10 ms |
//! | `[parameter.NAME]` | `value`, `unit`, `minimum`, `maximum`, `doc` |
//! | `[state.NAME]` | `start` (of parameters), one of `rate` and `value` (or neither, if a machine sets it), `unit`, `doc` |
//! | `[machine.NAME]` | `states`, `start`, `transitions` (`from`, `to`, `when`, `on`, `after_s`, `set`), `enter` |
//! | `[table.NAME]` | `x` and `y`, or `x`, `y` and `z`, or `csv`; `outside` |
//! | `[signal.NAME]` | `expression`, `in.MACHINE = { STATE = ... }`, or `steps = [[t, value], ...]`, or `csv` with the columns `time` and `value`; `interpolate`, `repeat`; `noise`; a `model` of its sensor, below |
//! | `[fmu]` | a functional mock-up unit whose outputs are states; `docs/fmu.md` |
//! | `[uds]` | diagnostics: a UDS server on ISO-TP; `docs/uds.md` |
//! | `[message.NAME]` | sent: `period_s` and `send`, or `answers = "Command"` with `delay_s`, `when`, `times`, `every_s`, `busy`; received: `initial`, `timeout_s`, `while_answering`, `queue`; either: `counter`, `checksum`, `e2e`, below |
//!
//! An undriven signal is sent as its start value (`GenSigStartValue`), or as zero; an undriven multiplexer cycles
//! through its pages. If several messages have a signal of the same name, write `[signal."Status.Temperature"]`, and
//! `Command.Setpoint` in expressions.
//!
//! `[state."cell[1..96]"]` is `cell1` to `cell96` and the array `cell`, with `i` as the index in its expressions. The
//! same works for parameters and for signals; `[signal."CellVoltage[01..96]"]` has two-digit numbers.
//!
//! # Layouts without a DBC
//!
//! `[[message]]` tables accept the keys of `[message.NAME]` too, and name the sender (`sent_by`). On CAN a message has
//! a `can_id`; on a serial line it is a packet or a line of text:
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
//! Fields follow one another without gaps. Their types are `u8` to `u64`, `i8` to `i64` (24 bits too), `f32` and
//! `f64`. The checksum follows the fields, least significant byte first unless `checksum_order = "big"`, and covers
//! everything after the start bytes unless `checksum_over = "all"`. In a line, the format after the colon is that of a
//! number: sign, zeros, width, decimals (`{X:+08.3}`). A line with a `checksum` has its hexadecimal digits at `{checksum}`;
//! it covers what is before it, or what is between the two characters of `checksum_between`.
//!
//! Two messages of one sender may look the same if they answer different requests: the last request tells them apart, see
//! [`Decoder::overhear`].
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
//! Both are signals of the message. [`Outbox`] fills them in, and a [`Decoder`] checks them ([`Verdict`]). A
//! [`Device`] ignores a message with a wrong counter or checksum, and [`Device::refused_messages`] counts it. A counter or a
//! checksum with a `[signal.NAME]` of its own is sent with that value, and the other one covers it.
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
//! A DBC specifies this by `GenMsgSendType`, `GenSigSendType`, `GenMsgCycleTimeFast`, `GenMsgNrOfRepetition` and
//! `GenMsgDelayTime`. The device checks values, without their noise, at the ends of steps and when a message arrives.
//! `on_event` is a change to a value other than the signal's start value.
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
//! The signal is the true value with the model's terms, delayed by its lag and its latency, within its dead zone and
//! range. A gyro model is for rates, a model of kind `sensor` for the quantity in which it was measured; its other
//! inputs are the variables of those names. The true value is linear from one message to the next.
//!
//! # Expressions
//!
//! | written | meaning |
//! |---|---|
//! | `t`, `pi` | seconds since power-on; 3.14159... |
//! | a name | a parameter, a state, or a signal of a received message |
//! | `+ - * / % ^` | as in mathematics: `-x^2` is `-(x^2)`, `2^3^2` is `2^9`; `%` has the sign of its right side |
//! | `< <= > >= == !=` | 1 if true, else 0; they do not chain |
//! | `and or not` | every number except 0 is true |
//! | `if(c, a, b)` | `a` if `c` is not 0, else `b` |
//! | `min(a, b, ...)`, `max(a, b, ...)`, `clamp(x, low, high)` | |
//! | `abs sign floor ceil round sqrt exp ln log10` | of one value |
//! | `sin cos tan asin acos atan tanh`, `atan2(y, x)` | in radians |
//! | `cell[i]`, `cell[Request.Index]` | an element of an array |
//! | `bit_and bit_or bit_xor` `(a, b, ...)`, `0x5A` | the bits of whole numbers below 2^53; a hexadecimal number |
//! | `min max sum mean argmin argmax` `(cell)` | of a whole array |
//! | `ocv(soc)`, `map(x, y)` | the value of a table |
//! | `mode == "Closed"`, `time_in(mode)` | the state of a machine, or the named value of a received signal; seconds in the state |
//! | `part` | the number of the message within an answer, from 1 |
//! | `last(state)` | the state at the end of the previous step, for latches |
//!
//! A state whose `value` uses `last` changes only at the ends of steps, like the output of a sampled controller.
//! States with a `value` are evaluated in the order of their dependencies; a cycle is refused.
//!
//! A non-finite result (a division by zero, for example) keeps the previous value, and [`Device::not_finite`] counts
//! it. A value beyond the range of its signal is clipped, and [`Device::clipped`] says so.
//!
//! The expressions are implemented in this crate: other crates either bind a sign tighter than a power (`-2^2` would
//! be 4), or divide whole numbers as integers, or use the platform's functions.

mod bits;
mod canopen;
mod clipped;
mod codes;
mod description;
mod device;
mod error;
mod expression;
mod files;
mod fmu;
pub mod hint;
mod isotp;
mod layout;
mod lookup;
mod outbox;
mod place;
mod protection;
mod steps;
mod toml_mistake;
mod transport;
mod uds;

pub use bits::SIGNAL_BITS_MAX;
pub use canopen::{Abort, Dictionary, Entry, Progress, SDO_REQUEST, SDO_RESPONSE, SdoClient};
pub use clipped::Clipped;
use described_file as file;
pub use described_file::{ByteOrder, IsoTpTable, OneOrSeveral, ProtectionTable};
pub use description::Description;
pub use device::Device;
pub use error::{FileError, Mistake};
pub use files::Files;
pub use fmu::{Fmu, FmuInstance, FmuRole, FmuVariable};
pub use isotp::IsoTp;
pub use layout::{
    Carried, Dbc, DbcNode, Dbcs, Decoded, Decoder, EncodeError, Layout, Medium, Message, NOBODY,
    Note, Selection, SendKind, SendRule, Sender, Signal, SignalName, SignalValue, dbc_text,
};
pub use outbox::Outbox;
pub use place::Place;
pub use protection::Verdict;
pub use steps::{Input, Step, Steps};
pub use uds::{
    KeyFunction, Number, NumberType, Reply, Request, UdsClient, UdsListener, negative_response,
};

/// The JSON Schema of a description, in both of its forms, for editors.
pub fn schema(generator: schemars::SchemaGenerator) -> schemars::Schema {
    generator.into_root_schema_for::<file::File>()
}
