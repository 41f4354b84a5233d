//! The true state of the bench: emulated devices, from their physics to their bytes.
//!
//! * [`gyro`]: a fibre-optic gyro on one of four streams.
//! * [`base`]: a synchro-drive base on CAN or a serial line.
//! * [`table`]: a stepper-driven rotary table.
//! * [`absolute`]: the absolute measurement of pose that serves as the reference in a run.
//! * [`device_file`]: the devices of a run and their imperfections.
//! * [`fault`]: switches deliberate faults of a device on and off by number.
//! * [`parameters`]: the named numbers that make a device imperfect; [`random`]: its noise.
//!
//! A device is a state machine without IO: `receive` takes bytes or frames, `wake` takes the time; `transmit` returns
//! bytes or frames, and `next_wakeup` the time of the next wake-up. Time is always an argument. The caller passes the
//! true heading of the carrier, turret or table, to the gyro at the gyro's own instants.
//!
//! Every imperfection is off until a device file turns it on, and every random number belongs to one device and one
//! purpose. No emulator knows the code under test.

pub mod absolute;
pub mod base;
pub mod device_file;
pub mod fault;
pub mod gyro;
pub mod parameters;
pub mod random;
pub mod table;
