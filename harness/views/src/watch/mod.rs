//! Live view of a run in progress: a plain model, fed by the records of the run.
//!
//! * [`Model`]: everything that can be shown, as numbers and words. No terminal, no clock.
//! * [`Feed`]: the one model of a run, shared by the run that writes it and its viewers.
//! * [`Watched`]: a record sink that shows its records to a feed and does not change them.
//!
//! The run never waits for a terminal. It changes the model under a lock that a viewer holds only while it copies the
//! model: only the latest state matters. A channel would have to be bounded and lose events, or a slow terminal would
//! delay the run.

mod estimate;
mod gauge;
mod model;
mod news;
mod robot;
mod series;
mod sink;
mod traffic;

pub use estimate::Estimate;
pub use gauge::Gauge;
pub use model::{BROKEN_MAX, FAULTS_MAX, Model, UnderWay, in_words};
pub use news::{NEWS_MAX, News, NewsKind, Piece};
pub use robot::Robot;
pub use series::{POINTS_MAX, Series};
pub use sink::Watched;
pub use traffic::{Traffic, Way};

use plan::Plan;
use record::Progress;
use record::Record;
use record::header::Header;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The model of a run in progress. A clone is the same model.
#[derive(Debug, Clone)]
pub struct Feed(Arc<Mutex<Model>>);

impl Feed {
    /// Creates the model of a run of `plan` that has not begun; `header` is that of its record.
    pub fn new(plan: &Plan, header: &Header) -> Self {
        Self(Arc::new(Mutex::new(Model::new(plan, header))))
    }

    pub fn snapshot(&self) -> Model {
        self.model().clone()
    }

    pub fn progress(&self, progress: Progress) {
        self.model().progress(progress);
    }

    /// Returns the news after the piece with this number, and how many of them were lost for lack of room.
    pub fn news_after(&self, number: u64) -> (Vec<Piece>, u64) {
        self.model().news.after(number)
    }

    fn take(&self, record: &Record) {
        self.model().take(record);
    }

    /// A panic while locked leaves the model usable: nothing depends on it.
    fn model(&self) -> MutexGuard<'_, Model> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
