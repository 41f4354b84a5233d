//! What is true on the bench: emulated devices, from their physics to their bytes.
//!
//! * [`gyro`]: a fibre-optic gyro on one of four streams.
//! * [`base`]: a synchro-drive base on CAN or a serial line.
//! * [`table`]: a stepper-driven rotary table.
//! * [`absolute`]: the absolute measurement of pose that runs are judged by.
//! * [`device_file`]: which devices a run has, and how imperfect each is.
//! * [`fault`]: what goes wrong in a device on purpose is switched on and off by number.
//! * [`parameters`]: the named numbers that make a device imperfect; [`random`]: its noise.
//!
//! A device is a state machine without IO: bytes or frames go in by `receive`, time by `wake`; bytes
//! or frames come out by `transmit`, and `next_wakeup` says when it wants to be woken. Time is always
//! an argument. Whoever connects devices hands the true heading of the carrier, turret or table, to
//! the gyro at the gyro's own instants.
//!
//! Every imperfection is off until a device file turns it on, and every random number belongs to one
//! device and one purpose. No emulator knows the code that is tested with it.

pub mod absolute;
pub mod base;
pub mod device_file;
pub mod fault;
pub mod gyro;
pub mod parameters;
pub mod random;
pub mod table;
