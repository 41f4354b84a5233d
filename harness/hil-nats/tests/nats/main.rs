//! Campaigns over a NATS server: a private one, workers as separate processes, and failures between them.
//!
//! * [`campaign`]: the same results as in one process, even if processes die.
//! * [`away`]: a server that disappears, a coordinator that is killed, a case that kills every worker.
//! * [`bench`]: cases on a worker's bench, in real time.
//! * [`programs`]: a program under test in virtual time, which the workers start.
//! * [`refused`]: another version, a bench in use, no server.
//! * [`secured`]: TLS, passwords, keys.
//!
//! With `HIL_TESTS_NEED_NATS` set, tests fail instead of being skipped if there is no server.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod away;
mod bench;
mod campaign;
mod hil;
mod jwt;
mod programs;
mod refused;
mod secured;
mod server;
