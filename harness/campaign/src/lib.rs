//! Campaigns: seeded fault schedules thrown at a plan, until a property breaks; the smallest case that
//! still breaks it; and how much of a fault is tolerated.
//!
//! ```text
//!  Space ──► Search ──► Case ──► Executor ──► CaseResult ──► Journal (resumes where it stopped)
//!              ▲                                  │
//!              └────────── margins ───────────────┤ a violation
//!                                                 ▼
//!                                    shrink ──► Regression (a plan that anyone can run)
//! ```
//!
//! * [`Space`]: which faults can strike a bench and a plan, and strategies (proptest) that draw them.
//! * [`Search`]: which case is next: [`Random`], or [`Guided`]: evenly over the space, and along the margins of the
//!   properties where that pays.
//! * [`Executor`]: carries out one case. In real time, where runs differ, [`Repeatedly`] takes only what breaks again
//!   and again for broken.
//! * [`shrink()`]: less faults, later, shorter, weaker, as long as the same property breaks.
//! * [`Account`]: what a campaign was to do and what came of it, beside its journal: what a report is drawn from.
//! * [`seeds`]: the same plan under many seeds.
//! * [`envelope()`]: the share of runs that pass over the severity of one kind; [`Kept`] lets it go on where it stopped.

mod account;
mod case;
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
#[cfg(any(test, feature = "samples"))]
pub mod toy;
mod window;

pub use account::{ACCOUNT, Account, AccountError, End, FoundCase, Struck};
pub use case::{Case, CaseId, CaseResult, PANIC, PASSES, Repeated, Violated};
pub use envelope::{Envelope, EnvelopeSettings, Level, Measured, envelope};
pub use executor::Executor;
pub use guard::caught;
pub use guided::Guided;
pub use journal::{Journal, JournalError, Line, each_line};
pub use kept::Kept;
pub use regression::{Regression, RegressionError, slug};
pub use repeat::{
    BREAKS_AT_LEAST, CONFIDENCE, REPEATS, REPEATS_MAX, Repeatedly, Repetition, RepetitionError,
};
pub use run::{Campaign, Found, Settings, Tally, run};
pub use search::{Random, Search};
pub use shrink::{Shrunk, shrink};
pub use space::Space;
pub use window::WINDOW;
