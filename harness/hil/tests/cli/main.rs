//! The binary `hil` from outside: its output, its files and its exit status.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod bus;
mod campaigns;
mod ci;
mod closing;
#[cfg(target_os = "linux")]
mod crossing;
mod diagnostic_log;
mod durable;
mod envelopes;
mod exports;
mod hil;
mod input;
mod interrupt;
mod json;
mod judged_again;
mod log_lines;
mod log_times;
mod measured;
mod new;
mod operator;
mod other_nodes;
mod own_log;
mod own_sensor;
#[cfg(target_os = "linux")]
mod programs;
#[cfg(unix)]
mod pty;
mod recorded;
mod report;
mod reruns;
#[cfg(target_os = "linux")]
mod several_buses;
mod shared_line;
mod silent_controller;
mod small_bus;
mod watch;
