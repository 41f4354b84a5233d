//! The faults that are possible on one bench during one plan, and how they are drawn.

use super::course::Course;
use super::targets::Targets;
use plan::faults::{Fault, FaultKind, Lasts, Lines, Reach, Schedule, Target, Toward, When};
use plan::phases::names;
use plan::{Action, Name, Plan, Step};
use proptest::prelude::*;
use proptest::sample::select;
use wire::time::Span;

/// Shortest fault drawn. Assumption: a tenth of the gyro's time-out; anything shorter is a lost sample.
pub const DURATION_MIN: Span = Span::from_millis(10);
/// The most repetitions of one phase that faults are drawn for; a plan may have thousands.
pub const NUMBERS_MAX: u64 = 100;
/// A phase that takes less than this takes no time.
const PHASE_MIN: Span = Span::from_millis(1);

/// The set of all faults that can be drawn.
#[derive(Debug, Clone)]
pub struct Space {
    plan: Plan,
    lines: Lines,
    kinds: Vec<(Target, FaultKind)>,
    phases: Vec<(Name, u32)>,
    course: Course,
    faults_max: usize,
}

impl Space {
    /// The space for `plan` on a bench with these `lines`; at most `faults_max` at a time. A run without faults goes by
    /// like `course`. `only` names the kinds; if empty, all of them.
    pub fn new(
        plan: &Plan,
        lines: Lines,
        course: impl Into<Course>,
        faults_max: usize,
        only: &[String],
    ) -> Self {
        Self::among(plan, lines, course, faults_max, only, &Targets::default())
    }

    /// The same of these `targets`.
    pub fn among(
        plan: &Plan,
        lines: Lines,
        course: impl Into<Course>,
        faults_max: usize,
        only: &[String],
        targets: &Targets,
    ) -> Self {
        let course = course.into();
        let mut kinds = Vec::new();
        for info in FaultKind::all() {
            if !only.is_empty() && !only.iter().any(|name| name == info.name) {
                continue;
            }
            for target in targets.struck(info, &lines) {
                let schedule = Schedule { faults: vec![Fault::new(target, info.typical)] };
                // Checked alone: a fault that conflicts with one of the plan may still occur at another time.
                if schedule.fits(plan, &lines).is_ok() {
                    kinds.push((target, info.typical));
                }
            }
        }
        let phases = plan
            .phases()
            .into_iter()
            .filter(|(name, _)| takes_time(plan, name) && took_time(&course, name))
            .filter_map(|(name, times)| {
                let times =
                    u32::try_from(times.min(NUMBERS_MAX)).ok().filter(|times| *times > 0)?;
                Some((Name::new(name)?, times))
            })
            .collect();
        Self { plan: plan.clone(), lines, kinds, phases, course, faults_max: faults_max.max(1) }
    }

    /// The direction of a fault, as far as there is one.
    pub(super) fn toward(&self, (target, kind): (Target, FaultKind), drawn: Toward) -> Toward {
        let has_one = kind.info().reach.is_line() && !self.lines.shared.contains(&target);
        if has_one { drawn } else { Toward::Both }
    }

    /// Removes the faults that `can_suffer` rejects: a real bench has devices on which faults are impossible.
    #[must_use]
    pub fn within(mut self, can_suffer: impl Fn(Target, FaultKind) -> bool) -> Self {
        self.kinds.retain(|(target, what)| can_suffer(*target, *what));
        self
    }

    /// The kinds that can be drawn, with their targets.
    pub fn kinds(&self) -> &[(Target, FaultKind)] {
        &self.kinds
    }

    /// The kinds by what is drawn as often as others, by their indices: each kind on each target, but a kind of messages or
    /// signals on each node, which may have a thousand of them.
    pub(super) fn lanes(&self) -> Vec<Vec<usize>> {
        let mut lanes: Vec<Vec<usize>> = Vec::new();
        for (index, (target, kind)) in self.kinds.iter().enumerate() {
            let is_of_message = matches!(kind.info().reach, Reach::Message(_));
            let known = |lane: &&mut Vec<usize>| {
                let (first, known) = &self.kinds[lane[0]];
                known.name() == kind.name() && first.node() == target.node()
            };
            match lanes.iter_mut().find(known).filter(|_| is_of_message) {
                Some(lane) => lane.push(index),
                None => lanes.push(vec![index]),
            }
        }
        lanes
    }

    /// The kind on this target with the severity at `share` of its range, in the other direction if `negative` and it has
    /// one. The value of a signal is that share of its own range, or of the way back.
    pub(super) fn sized(
        &self,
        (target, kind): (Target, FaultKind),
        share: f64,
        negative: bool,
    ) -> FaultKind {
        if !kind.is_graded() {
            let (least, greatest) = self.values(target, kind);
            let share = if negative { 1.0 - share } else { share };
            return kind.with_value(0, least + (greatest - least) * share);
        }
        let sized = kind.with_severity(severity(kind, share));
        if negative && kind.is_signed() { sized.reversed() } else { sized }
    }

    /// The range of the values that this kind can give the signal: its own, as far as a plan can state it.
    pub(super) fn values(&self, signal: Target, kind: FaultKind) -> (f64, f64) {
        let (least, greatest) = self.lines.range(signal).unwrap_or_default();
        let (lowest, highest) = kind.info().parameters[0].range;
        (least.clamp(lowest, highest), greatest.clamp(lowest, highest))
    }

    /// The phases that a fault can be tied to, with their number of repetitions, up to the limit for drawing.
    pub fn phases(&self) -> &[(Name, u32)] {
        &self.phases
    }

    /// Duration of a run without faults.
    pub const fn horizon(&self) -> Span {
        self.course.lasted
    }

    /// How a run without faults went by.
    pub(super) const fn course(&self) -> &Course {
        &self.course
    }

    /// The most faults of one case.
    pub const fn faults_max(&self) -> usize {
        self.faults_max
    }

    /// Whether this schedule is applicable to the plan and the bench, together with the plan's own faults.
    pub fn takes(&self, schedule: &Schedule) -> bool {
        schedule.beside(&self.plan.faults).fits(&self.plan, &self.lines).is_ok()
    }

    /// Draws one fault: all kinds are equally likely, the severity is drawn over orders of magnitude, and both directions
    /// of one that has them.
    pub fn fault(&self) -> BoxedStrategy<Fault> {
        let (when, horizon, space) = (self.when(), self.horizon(), self.clone());
        let toward = select(vec![Toward::Host, Toward::Device, Toward::Both]);
        let unit = || 0.0..1.0_f64;
        (select(self.lanes()), unit(), when, toward, unit(), unit())
            .prop_map(move |(lane, which, when, toward, size, lasting)| {
                let place = lane[(which * lane.len() as f64) as usize];
                let (target, what) = space.kinds[place];
                let info = what.info();
                let (share, negative) = match what.is_signed() {
                    true => ((2.0 * size - 1.0).abs(), size < 0.5),
                    false => (size, false),
                };
                let what = space.sized((target, what), share, negative);
                let duration = (info.lasts == Lasts::Scheduled).then(|| duration(horizon, lasting));
                let toward = space.toward((target, what), toward);
                Fault { toward, when, duration, ..Fault::new(target, what) }
            })
            .boxed()
    }

    /// Draws the start of a fault.
    pub fn when(&self) -> BoxedStrategy<When> {
        let horizon_ms = (self.horizon().as_nanos() / 1_000_000).max(1);
        let at = (0..horizon_ms).prop_map(|ms| When::At(Span::from_millis(ms)));
        if self.phases.is_empty() {
            return at.boxed();
        }
        let phase =
            select(self.phases.clone()).prop_flat_map(|(phase, times)| (Just(phase), 1..=times));
        let space = self.clone();
        let step = (phase.clone(), 0.0..1.0_f64).prop_map(move |((phase, number), share)| {
            let after = space.course.within(&phase, number, share);
            When::Step { phase, number, after }
        });
        let during = phase.prop_map(|(phase, number)| When::During { phase, number });
        prop_oneof![2 => at, 2 => step, 1 => during].boxed()
    }

    /// Draws an applicable schedule of one or more faults.
    pub fn schedule(&self) -> BoxedStrategy<Schedule> {
        let space = self.clone();
        proptest::collection::vec(self.fault(), 1..=self.faults_max)
            .prop_map(|faults| Schedule { faults })
            .prop_filter("it can apply", move |schedule| space.takes(schedule))
            .boxed()
    }
}

/// Whether a phase takes time in a run. A fault during one that takes none cannot act.
fn takes_time(plan: &Plan, phase: &str) -> bool {
    let in_an_instant = |step: &Step| {
        matches!(step.action, Action::Send(_) | Action::StopSending(_) | Action::SetParameter(_))
    };
    let named = |step: &&Step| names(step).any(|name| name == phase);
    let mut steps = Step::walk(&plan.steps).filter(named).peekable();
    // A phase that no step is named after is one of a command to the controller.
    steps.peek().is_none() || steps.any(|step| !in_an_instant(step))
}

/// Whether a phase took time in the run without faults, as far as it is known.
fn took_time(course: &Course, phase: &str) -> bool {
    course.phases.get(phase).is_none_or(|all| all.iter().any(|length| *length >= PHASE_MIN))
}

/// The smallest severity drawn, as a share of the greatest.
const LEAST: f64 = 1e-4;

/// The smallest and the greatest severity drawn for a kind: at most four orders of magnitude.
pub(super) fn severities(what: FaultKind) -> (f64, f64) {
    let (least, greatest) = what.severity_range();
    (least.max(greatest * LEAST), greatest)
}

/// The severity at `share` of the range, on a logarithmic scale.
pub(super) fn severity(what: FaultKind, share: f64) -> f64 {
    let (least, greatest) = severities(what);
    plain(what, least * (greatest / least).powf(share))
}

/// The severity with four digits, or in whole milliseconds if it is a duration: what a person would write.
pub(super) fn plain(what: FaultKind, severity: f64) -> f64 {
    let (least, greatest) = what.severity_range();
    let is_duration = what.info().lasts == Lasts::Itself;
    let near = match is_duration {
        true => whole_ms(severity).as_secs_f64(),
        false => format!("{severity:.3e}").parse().unwrap_or(severity),
    };
    near.clamp(least, greatest)
}

/// Times of faults are in whole milliseconds, for readability.
pub(super) fn whole_ms(seconds: f64) -> Span {
    Span::from_millis((seconds * 1e3).round() as i64)
}

/// The duration at `share` of the range from the shortest to the whole run, on a logarithmic scale; whole ms.
pub(super) fn duration(horizon: Span, share: f64) -> Span {
    let (least, greatest) = (DURATION_MIN.as_secs_f64(), horizon.max(DURATION_MIN).as_secs_f64());
    whole_ms(least * (greatest / least).powf(share))
}

#[cfg(test)]
mod tests {
    use super::{Plan, Space, Span};
    use crate::toy;
    use plan::faults::{Fault, FaultKind, LineKind, Lines, Said, Schedule, Target, When};

    #[test]
    fn what_is_at_odds_with_a_fault_of_the_plan_is_not_taken() {
        let restart = FaultKind::typical("restart").unwrap();
        let stuck = Schedule {
            faults: vec![Fault::new(Target::Gyro, FaultKind::typical("stuck").unwrap())],
        };
        let mut plan = toy::plan();
        let space = |plan: &Plan| Space::new(plan, Lines::CAN_BASE, Span::from_secs(100), 4, &[]);
        assert!(space(&plan).takes(&stuck));
        plan.faults = Schedule { faults: vec![Fault::new(Target::Gyro, restart)] };
        assert!(!space(&plan).takes(&stuck));
        assert!(space(&plan).kinds().contains(&(Target::Gyro, stuck.faults[0].what)));
    }

    /// Found by a user: values of signals were drawn from 1e8 to 1e12, and faults of messages and signals only on request.
    #[test]
    fn signals_take_turns_and_their_values_are_those_that_they_can_have() {
        let said = |message: &str, least: f64, most: f64| Said {
            node: "motor".to_owned(),
            message: message.to_owned(),
            line: LineKind::Can,
            signals: vec!["Temp".to_owned(), "State".to_owned()],
            ranges: vec![(least, most), (0.0, 7.0)],
            counter: false,
            checksum: false,
            never_alone: None,
        };
        let nodes = vec![(Target::named("motor").unwrap(), LineKind::Can)];
        let said = vec![said("A", -40.0, 87.0), said("B", 5.0, 6.0)];
        let lines = Lines { nodes, said, ..Lines::default() };
        let plan = "name = \"p\"\ntitle = \"\"\nrig = \"r\"\nsteps = [{ wait = { duration_s = 1 } }]\n\
            [[property]]\nname = \"on\"\nalways = \"motor.State > 0\"\n";
        let plan = Plan::parse("p.toml", plan).unwrap();
        let space = Space::new(&plan, lines, Span::from_secs(1), 4, &[]);
        let of = |name: &str| space.kinds().iter().filter(|(_, kind)| kind.name() == name).count();
        assert_eq!((of("signal_value"), of("stuck_signal"), of("frozen_message")), (4, 4, 2));
        assert_eq!(space.lanes().iter().filter(|lane| lane.len() > 1).count(), 4);
        for name in ["guided", "random"] {
            let mut search: Box<dyn crate::Search> = match name {
                "guided" => Box::new(crate::Guided::new(&space, 1)),
                _ => Box::new(crate::Random::new(&space, 1)),
            };
            let mut temps = Vec::new();
            for _ in 0..600 {
                for fault in search.next().schedule.faults {
                    if fault.what.name() == "signal_value" && fault.target.name() == "motor.A.Temp"
                    {
                        temps.push(fault.what.values()[0]);
                    }
                }
            }
            assert!(temps.iter().all(|value| (-40.0..=87.0).contains(value)), "{temps:?}");
            let some =
                |share: std::ops::RangeInclusive<f64>| temps.iter().any(|t| share.contains(t));
            assert!(some(-40.0..=-20.0) && some(67.0..=87.0), "{name}: {temps:?}");
        }
    }

    /// In a plan of 2 s, a third of the faults waited for longer than the run took.
    #[test]
    fn no_fault_waits_longer_than_the_run_takes() {
        let plan = toy::plan();
        let horizon = Span::from_secs(2);
        let space = Space::new(&plan, Lines::CAN_BASE, horizon, 4, &[]);
        let random = &mut crate::Random::new(&space, 1) as &mut dyn crate::Search;
        let guided = &mut crate::Guided::new(&space, 1) as &mut dyn crate::Search;
        for search in [random, guided] {
            let mut waited = 0;
            for _ in 0..100 {
                for fault in search.next().schedule.faults {
                    if let When::Step { after, .. } = fault.when {
                        assert!(after <= horizon, "{after:?}");
                        waited += 1;
                    }
                }
            }
            assert!(waited > 20, "{waited}");
        }
    }

    #[test]
    fn what_a_bench_cannot_suffer_is_not_drawn() {
        let plan = toy::plan();
        let space = Space::new(&plan, Lines::CAN_BASE, Span::from_secs(100), 4, &[]);
        let some = space.clone().within(|target, _| target != Target::Gyro);
        assert!(some.kinds().len() < space.kinds().len() && !some.kinds().is_empty());
        let mut search = crate::Random::new(&some, 1);
        for _ in 0..100 {
            let case = crate::Search::next(&mut search);
            assert!(case.schedule.faults.iter().all(|fault| fault.target != Target::Gyro));
        }
    }
}
