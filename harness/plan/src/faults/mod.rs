//! Faults that a plan or a campaign injects: kind, target and time.
//!
//! ```toml
//! [[fault]]
//! target = "gyro"
//! what = { burst_loss = { loss_percent = 1, recover_percent = 10, bad_percent = 100, good_percent = 0 } }
//! when = { step = "lap", number = 3, after_s = 2 }
//! duration_s = 2
//! probability = 0.3
//! ```
//!
//! * [`FaultKind`]: the vocabulary; `docs/faults.md` has [`FaultKind::all`] as a table.
//! * [`Fault`], [`When`], [`Schedule`]: the faults of a plan or a campaign.
//! * [`Schedule::check`]: rejects faults that are not applicable to a plan or a bench, as far as this is known before
//!   the run.
//!
//! A fault of a line is a layer of that line; a fault of a device is a switch of its emulator. The controller is not
//! aware of faults.

mod apart;
mod chance;
mod check;
mod fault;
mod kind;
mod lines;
mod schedule;
pub mod table;
mod target;
mod when;

pub use chance::{Chance, Chances};
pub use fault::{Fault, Toward};
pub(crate) use kind::schema::name as kind_name_schema;
pub use kind::{FaultKind, KindInfo, KindParameter, Lasts, Reach, Share, UnknownKind};
pub use lines::{LineKind, Lines, Ride, Said};
pub use schedule::{FAULTS_MAX, Schedule};
pub use target::{Target, TargetName};
pub use when::When;
