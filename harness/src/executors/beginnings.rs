//! What cases with one seed share: everything up to the first fault of a case is run once, and each case goes on from a
//! snapshot of it.

use crate::run::{Prepared, Underway};
use plan::faults::Schedule;
use record::sink::NullSink;
use rig::operator::Answers;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wire::time::{Span, Timestamp};

/// Snapshots kept of one seed. Beyond them every second one is dropped, and later ones are twice as far apart.
const SNAPSHOTS_MAX: usize = 16;
/// The first snapshots are this far apart.
const APART: Span = Span::from_secs(2);
/// A snapshot holds the observations so far, at most this many bytes: 512 MiB in all of the snapshots of [`SEEDS_MAX`].
const OBSERVED_MAX: usize = 1 << 19;
/// Seeds whose snapshots are kept. Those that were not used for the longest time go first.
const SEEDS_MAX: usize = 64;

/// The beginnings of runs without faults, by seed.
#[derive(Default)]
pub(super) struct Beginnings(Mutex<Kept>);

#[derive(Default)]
struct Kept {
    of: BTreeMap<u64, (u64, Arc<Mutex<Beginning>>)>,
    /// Counts uses.
    uses: u64,
}

impl Beginnings {
    /// The run of `prepared` with `seed` and these faults, shortly before the first of them begins. `None` if it begins at
    /// once, or if user code, a program or a person takes part, which cannot be copied.
    pub(super) fn before(
        &self,
        prepared: &Prepared,
        (seed, schedule): (u64, &Schedule),
        answers: &Answers,
    ) -> Option<Underway> {
        let beginning = lock(&self.0).of(seed);
        let mut beginning = lock(&beginning);
        beginning.before(schedule, prepared.plan.seed_of_run(seed), || {
            let judged = prepared.plan.judged(&prepared.rig);
            Underway::new(None, prepared, seed, answers, Some(&judged))
        })
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A case that panicked has left what it had kept before.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Kept {
    fn of(&mut self, seed: u64) -> Arc<Mutex<Beginning>> {
        self.uses += 1;
        if self.of.len() == SEEDS_MAX && !self.of.contains_key(&seed) {
            let oldest = self.of.iter().min_by_key(|(_, (used, _))| *used).map(|(seed, _)| *seed);
            oldest.map(|oldest| self.of.remove(&oldest));
        }
        let (used, beginning) = self.of.entry(seed).or_default();
        *used = self.uses;
        Arc::clone(beginning)
    }
}

/// One run without faults, as far as cases needed it.
#[derive(Default)]
struct Beginning {
    began: bool,
    /// It goes on from here; `None` once it has ended or panicked, has observed too much, or cannot be copied.
    ahead: Option<Underway>,
    /// How far it has gone.
    until: Timestamp,
    /// In the order of time.
    snapshots: Vec<Underway>,
    apart: Span,
}

impl Beginning {
    fn before(
        &mut self,
        schedule: &Schedule,
        seed: u64,
        run: impl FnOnce() -> Underway,
    ) -> Option<Underway> {
        if !self.began {
            (self.began, self.apart) = (true, APART);
            self.keep(run().before_faults());
        }
        while let Some(ahead) = &self.ahead
            && ahead.simulation.first_fault(schedule, seed) > self.until + self.apart
        {
            self.advance();
        }
        let is_before =
            |one: &Underway| one.simulation.first_fault(schedule, seed) > one.simulation.now();
        // The later a snapshot, the more faults are due.
        let before = self.snapshots.partition_point(is_before);
        let mut snapshot = self.snapshots.get(before.checked_sub(1)?)?.snapshot()?;
        snapshot.simulation = snapshot.simulation.with_faults(schedule, seed);
        Some(snapshot)
    }

    fn advance(&mut self) {
        self.until += self.apart;
        // Taken, so that nothing half done is left if it panics.
        if let Some(mut ahead) = self.ahead.take()
            && ahead.run_before(self.until)
        {
            self.keep(ahead);
        }
    }

    fn keep(&mut self, ahead: Underway) {
        let observed = ahead.simulation.director.engine.observations().bytes();
        let snapshot = ahead.snapshot().filter(|_| observed <= OBSERVED_MAX);
        self.ahead = snapshot.is_some().then_some(ahead);
        self.snapshots.extend(snapshot);
        if self.snapshots.len() > SNAPSHOTS_MAX {
            let mut at = 0;
            self.snapshots.retain(|_| {
                at += 1;
                at % 2 == 1
            });
            self.apart = self.apart * 2;
        }
    }
}

impl Underway {
    fn before_faults(mut self) -> Self {
        let made = &mut self.made;
        let simulation =
            self.simulation.before_faults(&mut NullSink, &mut |action| action.keep_in(made));
        Self { simulation, made: self.made }
    }

    pub(super) fn run_before(&mut self, until: Timestamp) -> bool {
        let Self { simulation, made } = self;
        simulation.run_before(until, &mut NullSink, &mut |action| action.keep_in(made))
    }

    fn snapshot(&self) -> Option<Self> {
        Some(Self { simulation: self.simulation.snapshot()?, made: self.made.clone() })
    }
}

impl fmt::Debug for Beginnings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Beginnings").field("seeds", &lock(&self.0).of.len()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::{Beginning, Beginnings, SEEDS_MAX, SNAPSHOTS_MAX};
    use crate::campaign::{Case, Executor as _, Random, Search as _, Space};
    use crate::executors::Simulated;
    use crate::executors::simulated::struck;
    use crate::plan::{Plan, Property};
    use crate::record::sink::{Level, MemorySink};
    use crate::run::{Prepared, Underway, simulate_watched};
    use plan::Always;
    use plan::made::Made;
    use rig::operator::Answers;
    use std::sync::Arc;
    use wire::time::{Span, Timestamp};

    const LAP: &str = r#"
        name = "one-lap"
        title = "One lap of a small square"
        devices = "paper"
        steps = [
            { use_calibration = "temperature" },
            { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
            { bias_test = { duration_s = 5 } },
            { lap = { direction = "cw", side_m = 1, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
        ]
        [[measurement]]
        name = "return_heading"
        doc = "Heading after the lap"
        quantity = "lap.return_heading"
        unit = "deg"
        check = { all_within = [-2, 2] }
    "#;

    fn lap() -> Prepared {
        let mut prepared = Prepared::load("laps-corrected", &Made::default()).unwrap();
        prepared.plan = Arc::new(Plan::parse("one-lap.toml", LAP).unwrap());
        prepared
    }

    /// Cases of few seeds, so that they meet in their beginnings.
    fn cases(prepared: &Prepared, count: usize) -> Vec<Case> {
        let (horizon, _) = Simulated::new(prepared.clone(), Answers::default()).without_faults(1);
        let space = Space::new(&prepared.plan, prepared.rig.struck(), horizon, 3, &[]);
        let mut search = Random::new(&space, 5);
        let few = |case: Case| Case { seed: case.seed % 3, ..case };
        (0..count).map(|_| few(search.next())).collect()
    }

    #[test]
    fn a_case_from_a_snapshot_ends_as_one_from_the_beginning() {
        let prepared = lap();
        let (answers, beginnings) = (Answers::default(), Beginnings::default());
        let mut later = 0;
        for case in cases(&prepared, 150) {
            let of_case = (case.seed, &case.schedule);
            let Some(underway) = beginnings.before(&prepared, of_case, &answers) else { continue };
            later += usize::from(underway.simulation.now() > Timestamp::ZERO + Span::from_secs(5));
            let run = underway.into_end(&mut super::NullSink);
            let struck = struck(&prepared, &case);
            let whole =
                simulate_watched(&struck, case.seed, &answers, &mut super::NullSink, &mut |_| true);
            assert_eq!(format!("{run:?}"), format!("{whole:?}"), "{case:?}");
        }
        assert!(later > 50, "{later} began late");
    }

    #[test]
    fn a_case_that_stops_at_a_violation_tells_the_same_of_it() {
        // A bound so tight that faults of the gyro break it.
        let mut prepared = lap();
        let tight = Always::FreshHeading { age_max: Some(Span::from_millis(60)) };
        Arc::make_mut(&mut prepared.plan).properties = vec![Property::Always(tight)];
        let executor = Simulated::new(prepared.clone(), Answers::default());
        let mut stopped = 0;
        for case in cases(&prepared, 200) {
            let whole = executor.execute(&case);
            for violated in &whole.violated {
                let until = executor.execute_until(&case, &violated.property);
                stopped += usize::from(until.stopped);
                assert!(until.violated.contains(violated), "{until:?} of {whole:?}");
            }
            let held = executor.execute_until(&case, "not judged");
            assert_eq!(held, whole, "{case:?}");
        }
        assert!(stopped > 0, "nothing broke early");
    }

    #[test]
    fn its_record_goes_on_byte_for_byte() {
        let prepared = lap();
        let seed = prepared.plan.seed_of_run(7);
        let answers = Answers::default();
        let case = cases(&prepared, 1).remove(0);
        let case = Case { seed: 7, ..case };
        let (struck, sink) = (struck(&prepared, &case), || MemorySink::new(Level::Full));
        let mut whole = sink();
        simulate_watched(&struck, 7, &answers, &mut whole, &mut |_| true);

        let run = Underway::new(None, &prepared, 7, &answers, Some(&[]));
        let mut record = sink();
        let mut simulation = run.simulation.before_faults(&mut record, &mut |_| ());
        let second = Span::from_secs(1);
        // To the second before the first fault, by way of a copy each second.
        while simulation.first_fault(&case.schedule, seed) > simulation.now() + second {
            assert!(simulation.run_before(simulation.now() + second, &mut record, &mut |_| ()));
            simulation = simulation.snapshot().unwrap();
        }
        let mut struck = simulation.with_faults(&case.schedule, seed);
        struck.go_on(&mut record, &mut |_| (), &mut |_| true);
        assert!(whole.records().len() > 1_000);
        assert!(record.records() == whole.records());
    }

    #[test]
    fn only_so_much_is_kept() {
        let prepared = lap();
        let beginnings = Beginnings::default();
        let case = cases(&prepared, 1).remove(0);
        for seed in 0..SEEDS_MAX as u64 + 9 {
            beginnings.before(&prepared, (seed, &case.schedule), &Answers::default());
        }
        let kept = super::lock(&beginnings.0);
        assert_eq!((kept.of.len(), kept.of.contains_key(&0)), (SEEDS_MAX, false));
        let beginning: &Beginning = &super::lock(&kept.of[&(SEEDS_MAX as u64)].1);
        assert!(beginning.snapshots.len() <= SNAPSHOTS_MAX);
    }
}
