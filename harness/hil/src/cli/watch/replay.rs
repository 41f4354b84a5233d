//! `hil replay`: a recorded run in the live view, at any speed, forwards and backwards.

use super::draw::Look;
use super::stand::{Playing, SharedStand};
use super::view::View;
use super::why_not;
use crate::cli::completions;
use crate::cli::debug::recorded;
use crate::cli::failure::Failure;
use crate::cli::interrupt::Interrupt;
use crate::cli::progress::Screen;
use clap::Args;
use harness::stopwatch::Stopwatch;
use plan::Plan;
use record::header::Header;
use record::outcome::{Outcome, PropertySummary};
use record::reader::RecordReader;
use record::run_folder::RunFolder;
use record::sink::{NullSink, RecordSink};
use record::{Progress, Record, RecordKind, Violation};
use std::iter::Peekable;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::Duration;
use views::watch::{Feed, Watched};
use wire::time::Timestamp;

/// Interval at which the replay moves on; the view draws about as often.
const PERIOD: Duration = Duration::from_millis(50);

/// Shows a recorded run in the live view, at any speed, forwards and backwards.
///
/// Space pauses, ← and → move by a hundredth of the run, Home and End to its ends, < and > halve and double the speed, q
/// leaves. It needs a terminal; `hil show` prints the record, and `hil debug` repeats the run itself.
#[derive(Debug, Args)]
pub(in crate::cli) struct ReplayArguments {
    /// A run folder.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Bench time at which to begin (s).
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, allow_negative_numbers = true)]
    at: f64,
    /// Speed, as a multiple of that of the run.
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    speed: f64,
    /// The plan of the run, if the record does not hold it: a name or path.
    #[arg(long, value_name = "PLAN", add = completions::plan())]
    plan: Option<String>,
}

impl ReplayArguments {
    #[expect(clippy::disallowed_methods, reason = "a replay is paced by the clock")]
    pub(in crate::cli) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        if !(self.speed.is_finite() && self.speed > 0.0 && self.at.is_finite() && self.at >= 0.0) {
            let message = "expected a speed above 0, and a time of 0 s or later".to_owned();
            return Err(Failure::arguments(message, "for instance --speed 10 --at 60"));
        }
        let (name, folder) = screen.opened(&self.run)?;
        let records = folder.records()?;
        let header = records.header().clone();
        let (mut end_s, mut steps) = (0.0_f64, 0);
        for record in records {
            let record = record.map_err(|source| folder.unreadable(source))?;
            end_s = end_s.max(record.at.as_secs_f64());
            steps += u64::from(matches!(record.kind, RecordKind::StepBegan { .. }));
        }
        if let Some(why) = why_not() {
            let message = format!("a replay needs a terminal: {why}");
            return Err(Failure::arguments(message, "hil show prints the record"));
        }
        let plan = recorded(self.plan.as_deref(), &header, &name)?.plan;
        let broken = folder.summary_if_any()?.map(|summary| summary.properties).unwrap_or_default();
        let interrupt = Interrupt::install(screen)?;
        let stand = SharedStand::new(&[&header.plan], false);
        let at_s = self.at.min(end_s);
        stand.lock().replay = Some(Playing { at_s, end_s, speed: self.speed, is_held: false });
        let look = Look::new(screen.fancy());
        let view = View::start(stand.clone(), look, &interrupt, screen).map_err(Failure::output)?;
        // The bar of the first reading would be drawn over the view.
        let folder = RunFolder::open(&self.run)?;
        let film = Film { folder: &folder, plan: &plan, header: &header, broken: &broken, steps };
        let mut shown = film.begun(&view)?;
        let clock = Stopwatch::start();
        let mut before_s = 0.0;
        while !interrupt.requested() && !stand.lock().is_over {
            let now_s = clock.elapsed_s();
            let wanted_s = stand.lock().moved_on(now_s - before_s);
            before_s = now_s;
            if wanted_s < shown.at_s {
                shown = film.begun(&view)?;
            }
            shown.to(wanted_s, &film);
            thread::sleep(PERIOD);
        }
        Ok(Outcome::Passed)
    }
}

struct Film<'a> {
    folder: &'a RunFolder,
    plan: &'a Arc<Plan>,
    header: &'a Header,
    broken: &'a [PropertySummary],
    steps: u64,
}

struct Shown {
    records: Peekable<RecordReader>,
    feed: Feed,
    sink: Watched<NullSink>,
    at_s: f64,
    steps_done: u64,
}

impl Film<'_> {
    fn begun(&self, view: &View) -> Result<Shown, Failure> {
        let feed = Feed::new(self.plan, self.header);
        view.plan(0, feed.clone());
        let sink = Watched::new(NullSink, Some(&feed));
        let records = self.folder.records()?.peekable();
        Ok(Shown { records, feed, sink, at_s: 0.0, steps_done: 0 })
    }
}

impl Shown {
    /// Shows the run up to a bench time, which is not before the one shown.
    fn to(&mut self, wanted_s: f64, film: &Film<'_>) {
        let is_due = |record: &Record| record.at.as_secs_f64() <= wanted_s;
        // All records were read before.
        while let Some(Ok(record)) =
            self.records.next_if(|record| record.as_ref().is_ok_and(is_due))
        {
            match record.kind {
                RecordKind::Bytes(bytes) => self.sink.bytes(record.at, record.device, &bytes),
                RecordKind::Frame(frame) => self.sink.frame(record.at, record.device, frame),
                kind => {
                    self.steps_done += u64::from(matches!(kind, RecordKind::StepEnded { .. }));
                    self.sink.record(Record { kind, ..record });
                }
            }
        }
        self.sink.show_traffic();
        for property in film.broken {
            let at_s = property.broken_s.filter(|at_s| *at_s > self.at_s && *at_s <= wanted_s);
            if let Some(at_s) = at_s {
                let at = Timestamp::from_secs_f64(at_s);
                let what = property.what.clone().unwrap_or_default();
                self.sink.broken(&property.name, &Violation { at, what });
            }
        }
        self.at_s = wanted_s;
        let now = Timestamp::from_secs_f64(wanted_s);
        self.feed.progress(Progress { now, steps_done: self.steps_done, steps: film.steps });
    }
}
