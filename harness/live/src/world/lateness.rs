//! How late the harness was, and whether that spoils the measurements.

use super::histogram::Histogram;
use record::figures;
use record::outcome::{Spread, Timing};
use wire::time::{Span, Timestamp};

/// Default limit for the lateness of the harness. Assumption: one sample period of the paper's gyro (10 Hz); a
/// controller without input for longer rightly breaks off.
pub const LATE_MAX_DEFAULT: Span = Span::from_millis(100);

/// A property that breaks within this time after the machine was late may break because of it. Assumption: the longest
/// time that a property gives a controller to recover is 5 s, and it is notified within one more.
const AFTERMATH: Span = Span::from_secs(6);
/// The limit for the machine's lateness for other programs is the harness's limit divided by this: a controller whose
/// time-out equals the limit has broken off before data is late by the whole limit.
const MACHINE_SHARE: i64 = 2;
/// Misses within this time are kept as one.
const MISS_GRAIN: Span = Span::from_secs(1);
/// Most misses kept: hours of a machine that is always late.
const MISSES_KEPT_MAX: usize = 10_000;

/// Start of a reason that blames the machine.
const NOT_IN_TIME: &str = "this machine did not keep real time";

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Course {
    /// Completed steps.
    pub(super) steps: u64,
    /// Number of observations.
    pub(super) observations: usize,
}

/// Counts of events that were later than allowed.
#[derive(Debug, Default)]
struct Misses {
    all: u64,
    /// In steps with measurements; those of the harness's own loop in all steps, if properties are judged throughout.
    judged: u64,
    /// In the current step.
    in_step: u64,
    /// In the step in which the run ended, once it has ended.
    at_end: Option<u64>,
    worst: Span,
}

#[derive(Debug)]
pub(super) struct Lateness {
    late_max: Span,
    histogram: Histogram,
    /// Misses of the harness's own loop.
    own: Misses,
    /// Misses of the machine for other programs; see [`super::machine_watch`].
    machine: Misses,
    /// Times of both, one per [`MISS_GRAIN`]; once full, the last entry stands for all later ones.
    missed: Vec<Timestamp>,
    /// Progress of the plan at the start of the step.
    step_began: Course,
    /// Properties judge the whole run, and every message by the time at which the harness heard it.
    judged_throughout: bool,
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
            judged_throughout: false,
        }
    }

    /// Every miss of the harness's own loop counts: properties judge the whole run.
    pub(super) const fn judge_throughout(&mut self) {
        self.judged_throughout = true;
    }

    pub(super) const fn late_max(&self) -> Span {
        self.late_max
    }

    /// Adds the lateness of something that the loop did at `now`.
    pub(super) fn add(&mut self, now: Timestamp, late: Span) {
        self.histogram.add(late);
        self.count(now, (late, self.late_max), |lateness| &mut lateness.own);
    }

    /// Adds the lateness of the machine for other programs.
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

    /// Why the device under test is not to blame for a property that broke between these times, or that lacked something
    /// between them; `None` if it is.
    pub(super) fn verdict_on_violation(
        &self,
        property: &str,
        (from, to): (Timestamp, Timestamp),
    ) -> Option<String> {
        let before = |miss: &&Timestamp| **miss <= to + MISS_GRAIN && from - **miss <= AFTERMATH;
        self.missed.iter().find(before)?;
        let when = format!("in all, and shortly before {property} broke");
        self.too_late(|misses| misses.all, &when)
    }

    /// Updates the progress of the plan. Lateness in a step counts against the observations of that step.
    pub(super) fn reach(&mut self, course: Course) {
        if course.steps != self.step_began.steps {
            self.end_step(course);
        }
    }

    pub(super) const fn is_broken_off(&self) -> bool {
        self.own.at_end.is_some()
    }

    /// The run ends here, and only the tear-down follows. Lateness in the step so far may be why it was broken off.
    pub(super) fn break_off(&mut self) {
        for misses in [&mut self.own, &mut self.machine] {
            misses.at_end.get_or_insert(misses.in_step);
        }
    }

    /// Ends the current step.
    pub(super) fn end_step(&mut self, course: Course) {
        let measured = course.observations > self.step_began.observations;
        for (misses, counts) in
            [(&mut self.own, measured || self.judged_throughout), (&mut self.machine, measured)]
        {
            misses.judged += if counts { misses.in_step } else { 0 };
            misses.in_step = 0;
        }
        self.step_began = course;
    }

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

    /// Why the measurements of a passed plan cannot be trusted; `None` if they can. Lateness of the machine for other
    /// programs only made it harder to pass.
    pub(super) fn verdict_on_pass(&self) -> Option<String> {
        let judged = self.own.judged;
        let late = (judged > 0).then(|| self.late(judged, self.when_judged()))?;
        Some(format!("{NOT_IN_TIME}: {late}"))
    }

    /// Why the device under test is not to blame for a failed plan or an aborted step; `None` if it is.
    pub(super) fn verdict_on_failure(&self) -> Option<String> {
        self.too_late(|misses| misses.judged, self.when_judged()).or_else(|| {
            let at_end = |misses: &Misses| misses.at_end.unwrap_or_default();
            self.too_late(at_end, "in the step that was broken off")
        })
    }

    const fn when_judged(&self) -> &'static str {
        if self.judged_throughout {
            "while something was judged"
        } else {
            "while something was measured"
        }
    }

    fn too_late(&self, of: fn(&Misses) -> u64, when: &str) -> Option<String> {
        let own = Some(of(&self.own)).filter(|misses| *misses > 0);
        let machine = Some(of(&self.machine)).filter(|misses| *misses > 0);
        let late = own.map(|misses| self.late(misses, when));
        let held_up = machine.map(|misses| {
            let worst = worst(self.machine.worst, self.late_max / MACHINE_SHARE);
            format!("other programs waited {} {when}, {worst}", figures::times(misses))
        });
        let said: Vec<String> = late.into_iter().chain(held_up).collect();
        (!said.is_empty()).then(|| format!("{NOT_IN_TIME}: {}", said.join("; ")))
    }

    fn late(&self, misses: u64, when: &str) -> String {
        format!("late {} {when}, {}", figures::times(misses), worst(self.own.worst, self.late_max))
    }
}

fn worst(worst: Span, allowed: Span) -> String {
    let milliseconds = |span: Span| span.as_secs_f64() * 1e3;
    let (worst, allowed) = (milliseconds(worst), milliseconds(allowed));
    format!("by {worst:.0} ms at worst, where {allowed} ms are allowed")
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
            @"this machine did not keep real time: late once while something was measured, by 300 ms at worst, where 20 ms are allowed"
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
        assert!(why.contains("once in the step that was broken off"), "{why}");
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
            @"this machine did not keep real time: other programs waited once while something was measured, by 11 ms at worst, where 10 ms are allowed"
        );
        let timing = lateness.timing(None, "normal".to_owned());
        assert_eq!((timing.misses, timing.machine_misses), (0, 1));
    }

    #[test]
    fn a_property_that_broke_soon_after_the_machine_was_late_is_excused() {
        let mut lateness = Lateness::new(Span::from_millis(20));
        lateness.add(AT, Span::from_millis(20));
        assert_eq!(lateness.verdict_on_violation("fresh_heading", (AT, AT)), None, "in time");
        for _ in 0..3 {
            lateness.add(AT, Span::from_millis(21));
        }
        let excused = |at| lateness.verdict_on_violation("fresh_heading", (at, at));
        let why = excused(AT + AFTERMATH).unwrap();
        assert!(why.contains("3 times in all, and shortly before fresh_heading broke"), "{why}");
        assert_eq!(excused(AT + AFTERMATH + MISS_GRAIN), None, "long before");
        assert_eq!(excused(AT - MISS_GRAIN - MISS_GRAIN), None, "after");
        let long = AFTERMATH + AFTERMATH;
        let awaited = lateness.verdict_on_violation("acks", (AT - long, AT + long));
        assert!(awaited.is_some(), "it was late while an answer was awaited");
    }

    /// Found by a user: a plan of properties alone passed although its harness had been stopped for 2.5 s, and heard
    /// two messages at one time that were a second apart.
    #[test]
    fn properties_judge_every_step() {
        let mut lateness = Lateness::new(Span::from_millis(20));
        lateness.judge_throughout();
        lateness.add_machine(AT, Span::from_millis(300));
        lateness.end_step(Course { steps: 1, observations: 0 });
        assert_eq!(lateness.verdict_on_pass(), None, "only other programs were late");
        lateness.add(AT, Span::from_millis(300));
        lateness.end_step(Course { steps: 2, observations: 0 });
        insta::assert_snapshot!(
            lateness.verdict_on_pass().unwrap(),
            @"this machine did not keep real time: late once while something was judged, by 300 ms at worst, where 20 ms are allowed"
        );
        assert_eq!(lateness.timing(None, String::new()).misses_judged, 1);
    }
}
