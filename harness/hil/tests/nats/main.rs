//! Campaigns over a NATS server: a private one, workers as processes of their own, and what may go wrong between them.
//!
//! * [`campaign`]: the same as in one process, whoever dies meanwhile.
//! * [`away`]: a server that disappears, a coordinator that is killed, a case that nobody survives.
//! * [`bench`]: cases on a worker's bench, in real time.
//! * [`programs`]: a program under test in virtual time, which the workers start.
//! * [`refused`]: another version, a bench that is taken, no server.
//! * [`secured`]: TLS, passwords, keys.
//!
//! With `HIL_TESTS_NEED_NATS` set, what would be skipped for want of a server fails.

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
