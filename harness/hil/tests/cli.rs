//! The binary `hil` from outside: its output, its files and its exit status.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

#[path = "cli/bus.rs"]
mod bus;
#[path = "cli/ci.rs"]
mod ci;
#[path = "cli/closing.rs"]
mod closing;
#[cfg(target_os = "linux")]
#[path = "cli/crossing.rs"]
mod crossing;
#[path = "cli/durable.rs"]
mod durable;
#[path = "cli/envelopes.rs"]
mod envelopes;
#[path = "cli/exports.rs"]
mod exports;
#[path = "cli/hil.rs"]
mod hil;
#[path = "cli/input.rs"]
mod input;
#[path = "cli/interrupt.rs"]
mod interrupt;
#[path = "cli/json.rs"]
mod json;
#[path = "cli/measured.rs"]
mod measured;
#[path = "cli/new.rs"]
mod new;
#[path = "cli/operator.rs"]
mod operator;
#[path = "cli/other_nodes.rs"]
mod other_nodes;
#[path = "cli/own_log.rs"]
mod own_log;
#[path = "cli/own_sensor.rs"]
mod own_sensor;
#[cfg(target_os = "linux")]
#[path = "cli/programs.rs"]
mod programs;
#[cfg(unix)]
#[path = "cli/pty.rs"]
mod pty;
#[path = "cli/recorded.rs"]
mod recorded;
#[path = "cli/report.rs"]
mod report;
#[path = "cli/small_bus.rs"]
mod small_bus;
#[path = "cli/watch.rs"]
mod watch;
