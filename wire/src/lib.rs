//! The shared vocabulary of the bench: data on a wire and physical quantities.
//!
//! * [`time`]: instants and spans in nanoseconds; nothing here reads a clock.
//! * [`units`]: SI newtypes; degrees and counts enter and leave only through named constructors.
//! * [`can`]: CAN frames. [`can_error`]: error reports of a CAN controller. [`packet`]: a bounded run of serial bytes.
//! * [`gyro`]: four byte streams of fibre-optic gyros, each an encoder and a resynchronising decoder.
//! * [`j1939`]: 29-bit identifiers, and messages longer than a frame.
//! * [`base`]: the command set of a K2A-style mobile base, defined once for two transports (CAN and serial).
//! * [`table`]: the line protocol of a stepper-driven rotary table.
//! * [`slcan`]: CAN frames as ASCII lines, the host's end and the adapter's.
//! * [`digits`]: numbers in the text of a formula.
//! * [`device`]: the interface of every device on a line.
//! * [`serial`]: settings of a serial port, and the duration of a byte.
//!
//! No IO, no allocation, no `std`; no input bytes cause a panic.

#![no_std]

#[cfg(test)]
extern crate std;

pub mod base;
pub mod can;
pub mod can_error;
pub mod device;
pub mod digits;
mod either;
pub mod gyro;
pub mod j1939;
mod operator;
pub mod packet;
pub mod serial;
pub mod slcan;
pub mod table;
mod terms;
pub mod time;
pub mod units;
mod words;
