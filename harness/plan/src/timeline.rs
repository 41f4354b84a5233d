//! Phases of a plan before its run: their order, which is known, and bounds for their times.

use super::Plan;
use super::phases::names;
use super::step::{Action, Step};
use wire::time::Span;

/// The most starts and ends of phases that are examined; beyond that nothing is known of a plan.
const WALK_MAX: u64 = 20_000;
/// Shortest time of a motion, as a share of the prescribed time. Assumption: no base drives at twice the commanded
/// speed.
const MOTION_LEAST: f64 = 0.5;

/// Bounds of an instant, counted from the start of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Bounds {
    pub(crate) earliest: Span,
    pub(crate) latest: Span,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stretch {
    /// Indices of its start and its end among all starts and ends of the plan.
    pub(crate) order: (u64, u64),
    pub(crate) begins: Bounds,
    pub(crate) ends: Bounds,
}

/// The phases with these names and numbers, counted from 1. `None` if a repeat that may end early comes before, or if
/// the phase does not occur.
pub(crate) fn stretches(plan: &Plan, wanted: &[(&str, u32)]) -> Vec<Option<Stretch>> {
    let zero = Bounds { earliest: Span::ZERO, latest: Span::ZERO };
    let mut walk = Walk {
        wanted,
        seen: vec![0; wanted.len()],
        found: vec![None; wanted.len()],
        closed: vec![false; wanted.len()],
        order: 0,
        now: zero,
        uncertain: false,
    };
    walk.steps(&plan.steps);
    walk.found.iter().zip(&walk.closed).map(|(found, closed)| found.filter(|_| *closed)).collect()
}

/// Whether a phase with this name can contain another of the same name. If not, they follow one another.
pub(crate) fn nests(plan: &Plan, name: &str) -> bool {
    let gives =
        |step: &Step| step.action.kind().missions().iter().any(|(mission, _)| *mission == name);
    let is = |step: &Step| names(step).any(|one| one == name);
    let mut within = Step::walk(&plan.steps).filter(|step| is(step));
    within.any(|step| {
        gives(step) || Step::walk(step.action.steps()).any(|inner| is(inner) || gives(inner))
    })
}

struct Walk<'a> {
    wanted: &'a [(&'a str, u32)],
    seen: Vec<u32>,
    found: Vec<Option<Stretch>>,
    /// Whether its end is known too.
    closed: Vec<bool>,
    order: u64,
    now: Bounds,
    /// Whether phase numbers are unknown from here on.
    uncertain: bool,
}

impl Walk<'_> {
    fn is_over(&self) -> bool {
        self.uncertain || self.order > WALK_MAX || self.closed.iter().all(|closed| *closed)
    }

    fn steps(&mut self, steps: &[Step]) {
        for step in steps {
            if self.is_over() {
                return;
            }
            self.step(step);
        }
    }

    fn step(&mut self, step: &Step) {
        let began = self.now;
        let limit = began.latest + step.time_limit();
        if step.action.steps().is_empty() {
            self.leaf(step, limit);
        } else {
            self.rounds(step);
            self.now.latest = self.now.latest.min(limit);
        }
    }

    fn rounds(&mut self, step: &Step) {
        let (period, may_end) = match &step.action {
            Action::Repeat(repeat) => (repeat.period, repeat.until.is_some()),
            _ => (None, false),
        };
        let names: Vec<&str> = names(step).collect();
        let mut began: Option<Bounds> = None;
        for round in 0..step.action.repetitions() {
            self.uncertain |= may_end && round > 0;
            if self.is_over() {
                return;
            }
            if let (Some(period), Some(before)) = (period, began) {
                self.now.earliest = self.now.earliest.max(before.earliest + period);
                self.now.latest = self.now.latest.max(before.latest + period);
            }
            began = Some(self.now);
            let open = self.enter(&names);
            self.steps(step.action.steps());
            self.leave(&open);
        }
    }

    /// A step without inner steps.
    fn leaf(&mut self, step: &Step, limit: Span) {
        let began = self.now;
        let names: Vec<&str> = names(step).collect();
        let open = self.enter(&names);
        let pieces: u64 = step.action.kind().missions().iter().map(|(_, times)| times).sum();
        let least = least(&step.action);
        let kinds = step.action.kind().missions();
        // A lap alternates a straight and a turn; only the lap as a whole bounds their durations.
        let rounds = kinds.first().map_or(0, |(_, times)| *times);
        for _ in 0..rounds {
            for (name, _) in kinds {
                let open = self.enter(&[name]);
                if pieces == 1 {
                    self.now.earliest = began.earliest + least;
                }
                self.now.latest = limit;
                self.leave(&open);
            }
        }
        self.now = Bounds { earliest: began.earliest + least, latest: limit };
        self.leave(&open);
    }

    fn enter(&mut self, names: &[&str]) -> Vec<usize> {
        self.order += 1;
        let mut open = Vec::new();
        for (index, (wanted, number)) in self.wanted.iter().enumerate() {
            for _ in names.iter().filter(|name| *name == wanted) {
                self.seen[index] += 1;
                if self.seen[index] == *number {
                    let order = (self.order, u64::MAX);
                    self.found[index] = Some(Stretch { order, begins: self.now, ends: self.now });
                    open.push(index);
                }
            }
        }
        open
    }

    fn leave(&mut self, open: &[usize]) {
        self.order += 1;
        for &index in open {
            if let Some(found) = &mut self.found[index] {
                found.order.1 = self.order;
                found.ends = self.now;
                self.closed[index] = !self.uncertain;
            }
        }
    }
}

/// The shortest time of a step in a run that continues after it.
fn least(action: &Action) -> Span {
    action.rest() + Span::from_secs_f64(action.motion().as_secs_f64() * MOTION_LEAST)
}

#[cfg(test)]
mod tests {
    use super::stretches;
    use crate::Plan;

    fn plan(steps: &str) -> Plan {
        let text = format!(
            "name = \"p\"\ntitle = \"\"\ndevices = \"paper\"\nsteps = [{steps}]\n[[measurement]]\nname = \"m\"\n\
             doc = \"d\"\nquantity = \"lap.gyro_error\"\nunit = \"deg\"\ncheck = {{ all_within = [-1, 1] }}"
        );
        Plan::parse("p.toml", &text).unwrap()
    }

    /// `earliest..latest` of start and end in seconds, and whether the first comes before the second.
    fn shown(steps: &str, wanted: &[(&str, u32)]) -> Vec<String> {
        let found = stretches(&plan(steps), wanted);
        let one = |found: &Option<super::Stretch>| match found {
            None => "unknown".to_owned(),
            Some(found) => {
                let bounds = |b: super::Bounds| {
                    format!("{:.1}..{:.1}", b.earliest.as_secs_f64(), b.latest.as_secs_f64())
                };
                format!("{} to {}", bounds(found.begins), bounds(found.ends))
            }
        };
        found.iter().map(one).collect()
    }

    #[test]
    fn bounds_add_up_along_the_plan() {
        let steps = "{ wait = { duration_s = 10 } }, { repeat = { times = 3, period_s = 60, steps = [\
                     { bias_test = { duration_s = 20 } }, { turn = { angle_deg = 90 } }] } }";
        // A turn of 90 deg at 30 deg/s takes 5 s; the bounds are half of that and 25 s.
        assert_eq!(
            shown(steps, &[("bias_test", 1), ("turn", 1), ("bias_test", 3), ("turn", 4)]),
            [
                "10.0..20.0 to 30.0..50.0",
                "30.0..50.0 to 32.5..75.0",
                "130.0..140.0 to 150.0..170.0",
                "unknown"
            ]
        );
    }

    #[test]
    fn turns_of_a_lap_are_counted_and_what_may_end_early_says_nothing_of_what_follows() {
        let laps = "{ lap = { direction = \"cw\" } }, { turn = { angle_deg = 90 } }";
        let found = stretches(&plan(laps), &[("turn", 4), ("turn", 5), ("lap", 1)]);
        let order: Vec<_> = found.iter().map(|one| one.unwrap().order).collect();
        assert!(order[0].1 < order[1].0 && order[2].0 < order[0].0 && order[0].1 < order[2].1);
        let until = "{ wait = { duration_s = 1 } }, { repeat = { times = 9, steps = [{ wait = { duration_s = 5 } }], \
                     until = { below = { quantity = \"gyro.rate\", limit = 1 } } } }, { turn = { angle_deg = 90 } }";
        assert_eq!(
            shown(until, &[("wait", 2), ("wait", 3), ("turn", 1)]),
            ["1.0..11.0 to 6.0..26.0", "unknown", "unknown"]
        );
    }
}
