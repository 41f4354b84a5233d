//! Campaigns: run a plan under seeded fault schedules until a property breaks, find the smallest case that still breaks
//! it, and measure how much of a fault is tolerated.
//!
//! ```text
//!  Space ──► Search ──► Case ──► Executor ──► CaseResult ──► Journal (resumes where it stopped)
//!              ▲                                  │
//!              └────────── margins ───────────────┤ a violation
//!                                                 ▼
//!                                    shrink ──► Regression (a plan that anyone can run)
//! ```
//!
//! * [`Space`]: the faults that are possible on a bench with a plan, and strategies (proptest) that draw them.
//! * [`Search`]: chooses the next case: [`Random`], or [`Guided`], which covers the space evenly and descends along the
//!   margins of the properties where that pays off.
//! * [`Executor`]: carries out one case. In real time, where runs differ, [`Repeatedly`] counts only what breaks in
//!   repeated runs as broken.
//! * [`shrink()`]: fewer faults, later, shorter, weaker, as long as the same property breaks.
//! * [`Account`]: settings and result of a campaign, beside its journal; the source of reports.
//! * [`seeds`]: the same plan under many seeds.
//! * [`envelope()`]: the share of passing runs over the severity of one kind; [`Kept`] lets it resume.

mod account;
mod case;
mod course;
mod envelope;
mod executor;
mod guard;
mod guided;
mod journal;
mod kept;
mod mutation;
mod regression;
mod repeat;
mod run;
mod search;
pub mod seeds;
mod shrink;
mod space;
mod survey;
mod targets;
#[cfg(any(test, feature = "samples"))]
pub mod toy;
mod window;

pub use account::{ACCOUNT, Account, AccountError, End, FoundCase, Struck};
pub use case::{Case, CaseId, CaseResult, KEEPS_RUNNING, PANIC, PASSES, Repeated, Violated};
pub use course::Course;
pub use envelope::{Envelope, EnvelopeSettings, Level, Measured, envelope};
pub use executor::Executor;
pub use guard::caught;
pub use guided::Guided;
pub use journal::{Journal, JournalError, Line, each_line};
pub use kept::Kept;
pub use regression::{Regression, RegressionError, remove_saved, slug};
pub use repeat::{
    BREAKS_AT_LEAST, CONFIDENCE, REPEATS, REPEATS_MAX, Repeatedly, Repetition, RepetitionError,
};
pub use run::{Campaign, Found, Settings, Tally, run};
pub use search::{Random, Search};
pub use shrink::{Shrunk, Small, shrink};
pub use space::{NUMBERS_MAX, Space};
pub use targets::{Targets, UnknownTarget};
pub use window::WINDOW;
