//! What is shown of a run while it goes on: a plain model, fed by what the run records.
//!
//! * [`Model`]: everything that can be shown, as numbers and words. No terminal, no clock.
//! * [`Feed`]: the one model of a run, shared by the run that writes it and whoever draws it.
//! * [`Watched`]: a record sink that shows what goes through it to a feed; the record stays what it is.
//!
//! The run never waits for a terminal. It changes the model under a lock that a drawer holds only while it
//! copies the model: the latest state is what counts, and a channel would have to be bounded and lose some
//! of what happened, or would let a slow terminal hold the run up.

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

/// The model of a run that goes on. A clone is the same model.
#[derive(Debug, Clone)]
pub struct Feed(Arc<Mutex<Model>>);

impl Feed {
    /// Of a run of `plan` that has not begun; `header` is that of its record.
    pub fn new(plan: &Plan, header: &Header) -> Self {
        Self(Arc::new(Mutex::new(Model::new(plan, header))))
    }

    /// What is so now.
    pub fn snapshot(&self) -> Model {
        self.model().clone()
    }

    /// Takes how far the run is.
    pub fn progress(&self, progress: Progress) {
        self.model().progress(progress);
    }

    /// News after the piece with this number, and how many of them were lost for want of room.
    pub fn news_after(&self, number: u64) -> (Vec<Piece>, u64) {
        self.model().news.after(number)
    }

    fn take(&self, record: &Record) {
        self.model().take(record);
    }

    /// A model that somebody panicked over is as good as it was: nothing rests on it.
    fn model(&self) -> MutexGuard<'_, Model> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
