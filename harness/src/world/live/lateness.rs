//! How late the harness was with what was due, and whether that spoils what was measured.

use super::histogram::Histogram;
use crate::outcome::{Spread, Timing};
use wire::time::{Span, Timestamp};

/// How late the harness may be where the bench does not say. Assumption: one sample period of the paper's
/// gyro (10 Hz); a controller that hears nothing for longer rightly breaks off.
pub const LATE_MAX_DEFAULT: Span = Span::from_millis(100);

/// A property that breaks within this after the machine was late may break because of it. Assumption: the longest time
/// that a property gives a controller to recover is 5 s, and it is told within one more.
const AFTERMATH: Span = Span::from_secs(6);
/// Misses are remembered once within this.
const MISS_GRAIN: Span = Span::from_secs(1);
/// Misses that are remembered: hours of a machine that is always late.
const MISSES_KEPT_MAX: usize = 10_000;

/// How far a plan has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Course {
    /// Steps done.
    pub(super) steps: u64,
    /// Observations made.
    pub(super) observations: usize,
}

/// Counts how late things were done.
#[derive(Debug)]
pub(super) struct Lateness {
    late_max: Span,
    histogram: Histogram,
    misses: u64,
    misses_judged: u64,
    /// When they were, one a [`MISS_GRAIN`]; what finds no room is as the last one.
    missed: Vec<Timestamp>,
    /// In the step that is under way, and the plan's course at its beginning.
    misses_in_step: u64,
    step_began: Course,
    /// Misses in the step that the run ended in, once it has.
    misses_at_end: Option<u64>,
}

impl Lateness {
    pub(super) fn new(late_max: Span) -> Self {
        Self {
            late_max,
            histogram: Histogram::default(),
            misses: 0,
            misses_judged: 0,
            missed: Vec::new(),
            misses_in_step: 0,
            step_began: Course::default(),
            misses_at_end: None,
        }
    }

    /// Something was done this late, at `now`.
    pub(super) fn add(&mut self, now: Timestamp, late: Span) {
        self.histogram.add(late);
        if late > self.late_max {
            self.misses += 1;
            self.misses_in_step += 1;
            let last = self.missed.last();
            if last.is_none_or(|last| now - *last >= MISS_GRAIN)
                && self.missed.len() < MISSES_KEPT_MAX
            {
                self.missed.push(now);
            }
        }
    }

    /// Why a property that broke at `at` is not to be held against the device under test; `None` where it is.
    pub(super) fn verdict_on_violation(&self, property: &str, at: Timestamp) -> Option<String> {
        let before = |miss: &&Timestamp| **miss <= at + MISS_GRAIN && at - **miss <= AFTERMATH;
        self.missed.iter().find(before)?;
        Some(self.too_late(self.misses, &format!("in all, and shortly before {property} broke")))
    }

    /// The plan has come this far. What was late in a step counts against what was observed in it.
    pub(super) fn reach(&mut self, course: Course) {
        if course.steps != self.step_began.steps {
            self.end_step(course);
        }
    }

    /// The run ends here, and is only torn down after this. What was late in the step until now may be why it
    /// came to nothing.
    pub(super) fn break_off(&mut self) {
        self.misses_at_end.get_or_insert(self.misses_in_step);
    }

    /// Why a step that came to nothing is not to be held against the device under test; `None` where it is.
    pub(super) fn verdict_on_broken_step(&self) -> Option<String> {
        let misses = self.misses_at_end.filter(|misses| *misses > 0)?;
        Some(self.too_late(misses, "in the step that was broken off"))
    }

    /// The plan is over.
    pub(super) fn end_step(&mut self, course: Course) {
        if course.observations > self.step_began.observations {
            self.misses_judged += self.misses_in_step;
        }
        self.misses_in_step = 0;
        self.step_began = course;
    }

    /// How well time was kept, for the summary.
    pub(super) fn timing(&self, bus_to_command: Option<Spread>, scheduling: String) -> Timing {
        Timing {
            late: self.histogram.spread(),
            bus_to_command,
            late_ms_max: self.late_max.as_secs_f64() * 1e3,
            misses: self.misses,
            misses_judged: self.misses_judged,
            scheduling,
        }
    }

    /// Why nothing that was measured can be believed; `None` where it can.
    pub(super) fn verdict(&self) -> Option<String> {
        let misses = self.misses_judged;
        (misses > 0).then(|| self.too_late(misses, "while something was measured"))
    }

    fn too_late(&self, misses: u64, when: &str) -> String {
        format!(
            "this machine did not keep real time: late by more than {} ms {misses} times {when}, by {:.0} \
             ms at worst",
            self.late_max.as_secs_f64() * 1e3,
            self.histogram.max().as_secs_f64() * 1e3,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{AFTERMATH, Course, Lateness, MISS_GRAIN, Span, Timestamp};

    const AT: Timestamp = Timestamp::from_nanos(30_000_000_000);

    #[test]
    fn only_steps_in_which_something_was_measured_count() {
        let mut lateness = Lateness::new(Span::from_millis(20));
        let at = |steps, observations| Course { steps, observations };
        lateness.add(AT, Span::from_millis(300));
        lateness.reach(at(1, 0));
        assert_eq!((lateness.misses, lateness.verdict()), (1, None));
        lateness.add(AT, Span::from_millis(20));
        lateness.reach(at(2, 4));
        assert_eq!(lateness.verdict(), None);
        lateness.add(AT, Span::from_millis(21));
        lateness.reach(at(2, 5));
        assert_eq!(lateness.verdict(), None);
        lateness.end_step(at(2, 5));
        assert_eq!((lateness.misses, lateness.misses_judged), (2, 1));
        insta::assert_snapshot!(
            lateness.verdict().unwrap(),
            @"this machine did not keep real time: late by more than 20 ms 1 times while something was measured, by 300 ms at worst"
        );
    }

    #[test]
    fn a_step_that_was_broken_off_is_looked_at_until_then() {
        let late = Span::from_millis(300);
        let mut lateness = Lateness::new(Span::from_millis(20));
        lateness.add(AT, late);
        lateness.reach(Course { steps: 1, observations: 0 });
        lateness.break_off();
        assert_eq!(lateness.verdict_on_broken_step(), None, "the step before was late");
        let mut lateness = Lateness::new(Span::from_millis(20));
        lateness.add(AT, late);
        lateness.break_off();
        lateness.add(AT, late);
        lateness.break_off();
        lateness.end_step(Course::default());
        let why = lateness.verdict_on_broken_step().unwrap();
        assert!(why.contains("20 ms 1 times in the step that was broken off"), "{why}");
        assert_eq!(lateness.verdict(), None);
    }

    #[test]
    fn a_property_that_broke_soon_after_the_machine_was_late_is_excused() {
        let mut lateness = Lateness::new(Span::from_millis(20));
        lateness.add(AT, Span::from_millis(20));
        assert_eq!(lateness.verdict_on_violation("fresh_heading", AT), None, "in time");
        for _ in 0..3 {
            lateness.add(AT, Span::from_millis(21));
        }
        let excused = |at| lateness.verdict_on_violation("fresh_heading", at);
        let why = excused(AT + AFTERMATH).unwrap();
        assert!(why.contains("3 times in all, and shortly before fresh_heading broke"), "{why}");
        assert_eq!(excused(AT + AFTERMATH + MISS_GRAIN), None, "long before");
        assert_eq!(excused(AT - MISS_GRAIN - MISS_GRAIN), None, "after");
    }
}
