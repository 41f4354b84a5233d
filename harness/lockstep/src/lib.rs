//! Runs unmodified programs in the harness's virtual time.
//!
//! A shared library (`shim/`, in C) is preloaded into the program. It answers all queries of time from the harness, and
//! tells the harness when the whole program waits, and until when. A program that loads no library (a static one), or
//! is in Go, is run by a tracer (`tracer/`, in C), which does the same at its system calls. Thus the program is a state
//! machine like any other: [`Lockstep`] is a [`wire::device::Device`]. `docs/virtual-time.md` states the guarantees and
//! how a program can break them.
//!
//! ```no_run
//! use lockstep::Program;
//! use wire::device::Device as _;
//! use wire::time::Timestamp;
//!
//! let program = Program::new(["./controller", "/dev/ttyHIL0", "can0"])
//!     .serial("/dev/ttyHIL0") // Port 0.
//!     .can("can0"); // Port 1.
//! let mut running = program.start()?;
//! running.wake(Timestamp::ZERO);
//! while let Some((port, what)) = running.transmit(Timestamp::ZERO) {
//!     println!("{port:?} {what:?}");
//! }
//! println!("next at {:?}, {:?}", running.next_wakeup(), running.state());
//! # Ok::<(), lockstep::StartError>(())
//! ```

mod binary;
mod device;
mod family;
mod frame;
mod link;
mod output;
mod outside;
mod pace;
mod processor;
mod program;
mod serial_line;
mod spawned;
mod state;
mod talk;
pub mod verify;

pub use binary::BinaryError;
pub use device::Lockstep;
pub use output::{Hearer, Output};
pub use program::{Program, StartError};
pub use state::{Ended, State};
pub use talk::{LINE_BYTES_MAX, Said};
