//! Somebody else's programs prove the emulated devices: pyserial, python-can, cantools and can-utils, and
//! a controller in Python that shares no code with ours (`tests/interop/`). pandas, asammdf and the reader of MCAP prove the
//! exports; files of asammdf prove measured data.
//!
//! The Python packages are looked for in the interpreter that `HIL_TESTS_PYTHON` names, else in `python3`.
//! With `HIL_TESTS_NEED_PYTHON` or `HIL_TESTS_NEED_CAN` set, what would be skipped fails.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "in a test what cannot go on may panic")]

mod base;
mod can_utils;
mod control;
mod controller;
mod dbc_files;
mod exports;
mod gyro;
mod measured;
mod own_device;
mod pytest;
mod python_package;
mod rig;
