//! Independent programs test the emulated devices: pyserial, python-can, cantools and can-utils, and a controller in
//! Python that shares no code with ours (`tests/interop/`). pandas, asammdf and the reader of MCAP test the exports;
//! files written by asammdf test measured data.
//!
//! The Python packages are those of the interpreter in `HIL_TESTS_PYTHON`, else of `python3`. With
//! `HIL_TESTS_NEED_PYTHON` or `HIL_TESTS_NEED_CAN` set, tests fail instead of being skipped.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "in a test what cannot go on may panic")]

mod base;
mod can_utils;
mod control;
mod controller;
mod dbc_files;
mod exported_device;
mod exports;
mod gyro;
mod measured;
mod own_device;
mod pytest;
mod python_package;
mod rig;
