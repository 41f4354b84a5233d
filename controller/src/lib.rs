//! stub
#![no_std]
#[cfg(test)]
extern crate std;
pub mod calibration;
pub mod health;
pub mod mission;
