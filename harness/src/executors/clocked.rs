//! How long each phase of a run took, from its record.

use crate::campaign::{Course, NUMBERS_MAX};
use crate::plan::Plan;
use crate::record::sink::{Level, RecordSink};
use crate::record::{Record, RecordKind};
use plan::Step;
use plan::phases::{names, of_command};
use std::collections::BTreeMap;
use std::io;
use wire::time::{Span, Timestamp};

/// Takes the time of each phase, and keeps nothing else.
#[derive(Debug)]
pub(super) struct Clocked<'a> {
    plan: &'a Plan,
    phases: BTreeMap<String, Vec<Span>>,
    /// The steps that are under way, outermost first: the repeats around the current one, and that.
    open: Vec<Open>,
    mission: Option<Open>,
    /// The place of the last step in each list of steps, outermost first.
    place: Vec<usize>,
    /// The last beginning or end of a step or a command.
    now: Timestamp,
    /// Not between steps, and not while the base is brought to rest at the end.
    is_in_step: bool,
}

#[derive(Debug)]
struct Open {
    since: Timestamp,
    /// The phases, and the number of the occurrence of each.
    phases: Vec<(String, usize)>,
}

impl<'a> Clocked<'a> {
    pub(super) fn new(plan: &'a Plan) -> Self {
        let (phases, open, place) = <_>::default();
        let now = Timestamp::ZERO;
        Self { plan, phases, open, mission: None, place, now, is_in_step: false }
    }

    /// The course of the run, which took `lasted`.
    pub(super) fn course(mut self, lasted: Span) -> Course {
        self.close(0);
        Course { lasted, phases: self.phases }
    }

    fn began<'b>(&mut self, phases: impl Iterator<Item = &'b str>) -> Open {
        let mut begin = |name: &str| {
            let all = self.phases.entry(name.to_owned()).or_default();
            if (all.len() as u64) < NUMBERS_MAX {
                all.push(Span::ZERO);
                return Some((name.to_owned(), all.len() - 1));
            }
            None
        };
        Open { since: self.now, phases: phases.filter_map(&mut begin).collect() }
    }

    fn ended(&mut self, open: Open) {
        for (name, place) in open.phases {
            if let Some(length) = self.phases.get_mut(&name).and_then(|all| all.get_mut(place)) {
                *length = self.now - open.since;
            }
        }
    }

    /// Ends all but the outermost `left` steps.
    fn close(&mut self, left: usize) {
        if let Some(mission) = self.mission.take() {
            self.ended(mission);
        }
        while self.open.len() > left
            && let Some(open) = self.open.pop()
        {
            self.ended(open);
        }
    }

    fn step_began(&mut self, path: &str) {
        let (place, is_first_round) = parsed(path);
        let same = place.iter().zip(&self.place).take_while(|(now, before)| now == before).count();
        let is_further = match (place.get(same), self.place.get(same)) {
            (Some(now), Some(before)) => now > before,
            // The same step again.
            _ => false,
        };
        // Whatever does not go on from where it was is in another round of what is around it; and if that is the first
        // round there, what is around that began anew as well.
        let innermost = place.len().saturating_sub(1);
        let anew =
            if is_further { 0 } else { 1 + usize::from(is_first_round && same >= innermost) };
        let same = same.min(innermost).saturating_sub(anew);
        self.close(same);
        let plan = self.plan;
        let mut steps: &[Step] = &plan.steps;
        for (depth, index) in place.iter().enumerate() {
            let Some(step) = steps.get(*index) else { break };
            if depth >= same {
                let open = self.began(names(step));
                self.open.push(open);
            }
            steps = step.action.steps();
        }
        self.place = place;
    }
}

/// The place of a step in each list of steps, from `steps[2].repeat[0] (round 7 of 40)`, and whether this is a first round.
fn parsed(path: &str) -> (Vec<usize>, bool) {
    let (place, round) = path.split_once(" (round ").unwrap_or((path, ""));
    let indices = place.split('[').skip(1);
    let index = |text: &str| text.split(']').next()?.parse().ok();
    (indices.map_while(index).collect(), round.starts_with("1 "))
}

impl RecordSink for Clocked<'_> {
    fn record(&mut self, record: Record) {
        match record.kind {
            RecordKind::StepBegan { path, .. } => {
                (self.now, self.is_in_step) = (record.at, true);
                self.step_began(&path);
            }
            // What is around it may go on.
            RecordKind::StepEnded { .. } => {
                (self.now, self.is_in_step) = (record.at, false);
                self.close(self.open.len().saturating_sub(1));
            }
            // A command follows when that before it has been carried out.
            RecordKind::Command(command) if self.is_in_step => {
                self.now = record.at;
                if let Some(mission) = self.mission.take() {
                    self.ended(mission);
                }
                let began = of_command(&command);
                self.mission = began.map(|name| self.began(std::iter::once(name)));
            }
            _ => {}
        }
    }

    fn level(&self) -> Level {
        Level::Events
    }

    fn failed(&self) -> Option<&io::Error> {
        None
    }

    fn finish(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::{
        Clocked, NUMBERS_MAX, Plan, Record, RecordKind, RecordSink as _, Span, Timestamp, parsed,
    };
    use crate::campaign::{Course, Executor as _};
    use crate::executors::Simulated;
    use crate::record::Device;
    use crate::run::Prepared;
    use plan::made::Made;
    use rig::operator::Answers;

    #[test]
    fn a_place_is_read() {
        assert_eq!(parsed("steps[2].repeat[0] (round 7 of 40)"), (vec![2, 0], false));
        assert_eq!(parsed("steps[2].repeat[0].sweep[11] (round 1 of 4)"), (vec![2, 0, 11], true));
        assert_eq!(parsed("steps[3]"), (vec![3], false));
    }

    const WAIT: &str = "{ wait = { duration_s = 1 } }";

    /// The course of steps at these places that take a second each.
    fn course(steps: &str, places: &[&str]) -> Course {
        let text = format!("name = \"x\"\ntitle = \"\"\ndevices = \"paper\"\nsteps = [{steps}]");
        let plan: Plan = toml::from_str(&text).unwrap();
        let mut clocked = Clocked::new(&plan);
        for (second, place) in (0..).zip(places) {
            let mut take = |at, kind| {
                let at = Timestamp::ZERO + Span::from_secs(at);
                clocked.record(Record { at, device: Device::Plan, kind });
            };
            let path = format!("steps{place}");
            take(second, RecordKind::StepBegan { path: path.clone(), title: String::new() });
            take(second + 1, RecordKind::StepEnded { path });
        }
        clocked.course(Span::from_secs(places.len() as i64))
    }

    fn seconds(course: &Course, phase: &str) -> Vec<f64> {
        course.phases[phase].iter().map(|length| length.as_secs_f64()).collect()
    }

    #[test]
    fn each_round_of_a_repeat_is_an_occurrence_of_it() {
        let two =
            format!("{{ repeat = {{ times = 2, steps = [{WAIT}, {WAIT}] }}, label = \"both\" }}");
        let course = course(
            &format!("{WAIT}, {two}"),
            &[
                "[0]",
                "[1].repeat[0] (round 1 of 2)",
                "[1].repeat[1] (round 1 of 2)",
                "[1].repeat[0] (round 2 of 2)",
                "[1].repeat[1] (round 2 of 2)",
            ],
        );
        assert_eq!(seconds(&course, "wait"), [1.0; 5]);
        assert_eq!(seconds(&course, "repeat"), [2.0, 2.0]);
        assert_eq!(seconds(&course, "both"), [2.0, 2.0]);
    }

    #[test]
    fn rounds_within_rounds_are_told_apart() {
        let inner = format!("{{ repeat = {{ times = 2, steps = [{WAIT}] }}, label = \"inner\" }}");
        let outer = |steps: &str| {
            format!("{{ repeat = {{ times = 2, steps = [{steps}] }}, label = \"outer\" }}")
        };
        let round = |number: u32| format!("[0].repeat[0].repeat[0] (round {number} of 2)");
        let (first, second) = (round(1), round(2));
        let of_inner = course(&outer(&inner), &[&first, &second, &first, &second]);
        assert_eq!(seconds(&of_inner, "inner"), [1.0; 4]);
        assert_eq!(seconds(&of_inner, "outer"), [2.0, 2.0]);
        let last = |number: u32| format!("[0].repeat[1] (round {number} of 2)");
        let places =
            [&*first, &*second, &*last(1), &*first, &*second, &*last(2)].map(str::to_owned);
        let places: Vec<&str> = places.iter().map(String::as_str).collect();
        let with_more = course(&outer(&format!("{inner}, {WAIT}")), &places);
        assert_eq!(seconds(&with_more, "inner"), [1.0; 4]);
        assert_eq!(seconds(&with_more, "outer"), [3.0, 3.0]);
    }

    /// A lap is turns and straights, which are counted by the commands to the controller.
    #[test]
    fn commands_are_phases_and_fill_the_step() {
        let prepared = Prepared::load("laps-corrected", &Made::default()).unwrap();
        let (course, _) = Simulated::new(prepared, Answers::default()).without_faults(1);
        let first =
            |phase: &str, count: usize| -> f64 { seconds(&course, phase).iter().take(count).sum() };
        let (lap, turns, straights) = (first("lap", 1), first("turn", 4), first("straight", 4));
        assert!((turns + straights - lap).abs() < 0.01 * lap, "{turns} {straights} {lap}");
        // There are more than are kept.
        assert_eq!(course.phases["turn"].len() as u64, NUMBERS_MAX);
        assert!(lap < course.lasted.as_secs_f64());
    }
}
