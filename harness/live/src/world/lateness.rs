//! How late the harness was with what was due, and whether that spoils what was measured.

use super::histogram::Histogram;
use record::outcome::{Spread, Timing};
use wire::time::{Span, Timestamp};

/// How late the harness may be where the bench does not say. Assumption: one sample period of the paper's
/// gyro (10 Hz); a controller that hears nothing for longer rightly breaks off.
pub const LATE_MAX_DEFAULT: Span = Span::from_millis(100);

/// A property that breaks within this after the machine was late may break because of it. Assumption: the longest time
/// that a property gives a controller to recover is 5 s, and it is told within one more.
const AFTERMATH: Span = Span::from_secs(6);
/// The machine may be late with what it does for others by half of that: a controller whose time-out is as long has broken
/// off before what is on its way is a whole one late.
const MACHINE_SHARE: i64 = 2;
/// Misses are remembered once within this.
const MISS_GRAIN: Span = Span::from_secs(1);
/// Misses that are remembered: hours of a machine that is always late.
const MISSES_KEPT_MAX: usize = 10_000;

/// What a reason begins with that blames the machine.
const NOT_IN_TIME: &str = "this machine did not keep real time";

/// How far a plan has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Course {
    /// Steps done.
    pub(super) steps: u64,
    /// Observations made.
    pub(super) observations: usize,
}

/// Times that something was later than it may be.
#[derive(Debug, Default)]
struct Misses {
    all: u64,
    /// In steps that something was measured in.
    judged: u64,
    /// In the step that is under way.
    in_step: u64,
    /// In the step that the run ended in, once it has.
    at_end: Option<u64>,
    worst: Span,
}

/// Counts how late things were done.
#[derive(Debug)]
pub(super) struct Lateness {
    late_max: Span,
    histogram: Histogram,
    /// Of the harness's own loop.
    own: Misses,
    /// Of the machine with what it does for others; see [`super::machine_watch`].
    machine: Misses,
    /// When either was, one a [`MISS_GRAIN`]; what finds no room is as the last one.
    missed: Vec<Timestamp>,
    /// The plan's course when the step began.
    step_began: Course,
}

impl Lateness {
    pub(super) fn new(late_max: Span) -> Self {
        Self {
            late_max,
            histogram: Histogram::default(),
            own: Misses::default(),
            machine: Misses::default(),
            missed: Vec::new(),
            step_began: Course::default(),
        }
    }

    /// How late the harness may be.
    pub(super) const fn late_max(&self) -> Span {
        self.late_max
    }

    /// The loop did something this late, at `now`.
    pub(super) fn add(&mut self, now: Timestamp, late: Span) {
        self.histogram.add(late);
        self.count(now, (late, self.late_max), |lateness| &mut lateness.own);
    }

    /// The machine was this late with what it does for others.
    pub(super) fn add_machine(&mut self, now: Timestamp, late: Span) {
        let late_max = self.late_max / MACHINE_SHARE;
        self.count(now, (late, late_max), |lateness| &mut lateness.machine);
    }

    fn count(
        &mut self,
        now: Timestamp,
        (late, late_max): (Span, Span),
        of: fn(&mut Self) -> &mut Misses,
    ) {
        if late <= late_max {
            return;
        }
        let misses = of(self);
        misses.all += 1;
        misses.in_step += 1;
        misses.worst = misses.worst.max(late);
        let last = self.missed.last();
        if last.is_none_or(|last| now - *last >= MISS_GRAIN) && self.missed.len() < MISSES_KEPT_MAX
        {
            self.missed.push(now);
        }
    }

    /// Why a property that broke at `at` is not to be held against the device under test; `None` where it is.
    pub(super) fn verdict_on_violation(&self, property: &str, at: Timestamp) -> Option<String> {
        let before = |miss: &&Timestamp| **miss <= at + MISS_GRAIN && at - **miss <= AFTERMATH;
        self.missed.iter().find(before)?;
        let when = format!("in all, and shortly before {property} broke");
        self.too_late(|misses| misses.all, &when)
    }

    /// The plan has come this far. What was late in a step counts against what was observed in it.
    pub(super) fn reach(&mut self, course: Course) {
        if course.steps != self.step_began.steps {
            self.end_step(course);
        }
    }

    pub(super) const fn is_broken_off(&self) -> bool {
        self.own.at_end.is_some()
    }

    /// The run ends here, and is only torn down after this. What was late in the step until now may be why it
    /// was broken off.
    pub(super) fn break_off(&mut self) {
        for misses in [&mut self.own, &mut self.machine] {
            misses.at_end.get_or_insert(misses.in_step);
        }
    }

    /// The plan is over.
    pub(super) fn end_step(&mut self, course: Course) {
        let measured = course.observations > self.step_began.observations;
        for misses in [&mut self.own, &mut self.machine] {
            misses.judged += if measured { misses.in_step } else { 0 };
            misses.in_step = 0;
        }
        self.step_began = course;
    }

    /// How well time was kept, for the summary.
    pub(super) fn timing(&self, bus_to_command: Option<Spread>, scheduling: String) -> Timing {
        Timing {
            late: self.histogram.spread(),
            bus_to_command,
            late_ms_max: self.late_max.as_secs_f64() * 1e3,
            misses: self.own.all,
            misses_judged: self.own.judged,
            machine_misses: self.machine.all,
            scheduling,
        }
    }

    /// Why nothing that was measured can be believed, though the plan passed; `None` where it can. What the machine held up
    /// for others made it harder to pass.
    pub(super) fn verdict_on_pass(&self) -> Option<String> {
        let judged = self.own.judged;
        (judged > 0).then(|| self.say(judged, self.own.worst, "while something was measured"))
    }

    /// Why a plan that failed, or a step that was broken off, is not to be held against the device under test; `None` where
    /// it is.
    pub(super) fn verdict_on_failure(&self) -> Option<String> {
        self.too_late(|misses| misses.judged, "while something was measured").or_else(|| {
            let at_end = |misses: &Misses| misses.at_end.unwrap_or_default();
            self.too_late(at_end, "in the step that was broken off")
        })
    }

    fn too_late(&self, of: fn(&Misses) -> u64, when: &str) -> Option<String> {
        let of_either = [&self.own, &self.machine];
        let misses = of_either.into_iter().map(of).sum();
        let worst =
            of_either.into_iter().filter(|misses| of(misses) > 0).map(|misses| misses.worst);
        (misses > 0).then(|| self.say(misses, worst.max().unwrap_or_default(), when))
    }

    fn say(&self, misses: u64, worst: Span, when: &str) -> String {
        let milliseconds = |span: Span| span.as_secs_f64() * 1e3;
        format!(
            "{NOT_IN_TIME}: late {misses} times {when}, by {:.0} ms at worst, where {} ms are allowed",
            milliseconds(worst),
            milliseconds(self.late_max),
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
        assert_eq!((lateness.own.all, lateness.verdict_on_pass()), (1, None));
        lateness.add(AT, Span::from_millis(20));
        lateness.reach(at(2, 4));
        assert_eq!(lateness.verdict_on_pass(), None);
        lateness.add(AT, Span::from_millis(21));
        lateness.reach(at(2, 5));
        assert_eq!(lateness.verdict_on_pass(), None);
        lateness.end_step(at(2, 5));
        assert_eq!((lateness.own.all, lateness.own.judged), (2, 1));
        insta::assert_snapshot!(
            lateness.verdict_on_pass().unwrap(),
            @"this machine did not keep real time: late 1 times while something was measured, by 300 ms at worst, where 20 ms are allowed"
        );
    }

    #[test]
    fn a_step_that_was_broken_off_is_looked_at_until_then() {
        let late = Span::from_millis(300);
        let mut lateness = Lateness::new(Span::from_millis(20));
        lateness.add(AT, late);
        lateness.reach(Course { steps: 1, observations: 0 });
        lateness.break_off();
        assert_eq!(lateness.verdict_on_failure(), None, "the step before was late");
        let mut lateness = Lateness::new(Span::from_millis(20));
        lateness.add(AT, late);
        lateness.break_off();
        lateness.add(AT, late);
        lateness.break_off();
        lateness.end_step(Course::default());
        let why = lateness.verdict_on_failure().unwrap();
        assert!(why.contains("1 times in the step that was broken off"), "{why}");
        assert_eq!(lateness.verdict_on_pass(), None);
    }

    #[test]
    fn what_the_machine_held_up_excuses_a_failure_and_spoils_no_pass() {
        let mut lateness = Lateness::new(Span::from_millis(20));
        lateness.add_machine(AT, Span::from_millis(10));
        lateness.end_step(Course { steps: 1, observations: 1 });
        assert_eq!(lateness.verdict_on_failure(), None, "in time");
        lateness.add_machine(AT, Span::from_millis(11));
        lateness.add(AT, Span::from_millis(2));
        lateness.end_step(Course { steps: 2, observations: 2 });
        assert_eq!(lateness.verdict_on_pass(), None);
        insta::assert_snapshot!(
            lateness.verdict_on_failure().unwrap(),
            @"this machine did not keep real time: late 1 times while something was measured, by 11 ms at worst, where 20 ms are allowed"
        );
        let timing = lateness.timing(None, "normal".to_owned());
        assert_eq!((timing.misses, timing.machine_misses), (0, 1));
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
