//! The shared vocabulary of the bench: what crosses a wire and the quantities it carries.
//!
//! * [`time`]: instants and spans in nanoseconds; nothing here reads a clock.
//! * [`units`]: SI newtypes; degrees and counts enter and leave only through named constructors.
//! * [`can`]: classic CAN frames. [`can_error`]: what a controller says of its bus. [`packet`]: a bounded run of serial bytes.
//! * [`gyro`]: four byte streams of fibre-optic gyros, each an encoder and a resynchronising decoder.
//! * [`j1939`]: identifiers of 29 bits, and messages longer than a frame.
//! * [`base`]: the command set of a K2A-style mobile base, once, on two transports (CAN and serial).
//! * [`table`]: the line protocol of a stepper-driven rotary table.
//! * [`slcan`]: CAN frames as ASCII lines, the host's end and the adapter's.
//! * [`device`]: what every end of a line does, and what it sends.
//! * [`serial`]: what a serial port is set to, and how long a byte takes.
//!
//! No IO, no allocation, no `std`; no bytes from outside make any of it panic.

#![no_std]

#[cfg(test)]
extern crate std;

pub mod base;
pub mod can;
pub mod can_error;
pub mod device;
pub mod gyro;
pub mod j1939;
pub mod packet;
pub mod serial;
pub mod slcan;
pub mod table;
pub mod time;
pub mod units;
