//! The end of every run: stops the base and queries it until it stands still.

use super::Action;
use controller::mission::{Command, Mission, MissionId, Report};
use record::{Device, RecordKind};
use std::collections::VecDeque;
use wire::table;
use wire::time::{Span, Timestamp};

/// Time limit for the base. Assumption: the longest braking (0.78 m/s at 0.4 m/s^2) takes 2 s.
const REST_WAIT: Span = Span::from_secs(5);
/// Time from the stop to the first query, and between two queries: by then the stop is on its line and an answer is
/// back (60 ms, the longest exchange, and 20 ms, a report in motion).
const ASK_PERIOD: Span = Span::from_millis(200);

/// Longest time between two states of a controller that is asked for one every [`ASK_PERIOD`]. Assumption: as long as
/// between two that it sends unasked.
const STATE_PERIOD_MAX: Span = Span::from_secs(1);

/// Stops base and table and waits for rest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Teardown {
    give_up: Timestamp,
    ask_at: Timestamp,
    told_at: Option<Timestamp>,
    at_rest: bool,
    /// When a state last said that the base moves, unless one said since that it stands.
    moved_at: Option<Timestamp>,
}

impl Teardown {
    pub(super) const fn begin(now: Timestamp) -> Self {
        Self { give_up: now_plus(now), ask_at: now, told_at: None, at_rest: false, moved_at: None }
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        self.ask_at.min(self.give_up)
    }

    pub(super) const fn at_rest(&self) -> bool {
        self.at_rest
    }

    /// Whether the controller still says that the base moves.
    pub(super) fn moves(&self, now: Timestamp) -> bool {
        self.moved_at.is_some_and(|at| now - at <= STATE_PERIOD_MAX)
    }

    pub(super) fn report(&mut self, now: Timestamp, report: &Report) {
        if let Report::State(state) = report {
            // A state from before the stop took effect proves nothing.
            let stopped = self.told_at.is_some_and(|told_at| now - told_at >= ASK_PERIOD);
            self.at_rest |= stopped && !state.moving;
            self.moved_at = (stopped && state.moving).then_some(now);
        }
    }

    /// Queries again when due; returns `true` when nothing is left to wait for.
    pub(super) fn step(
        &mut self,
        now: Timestamp,
        next_id: &mut MissionId,
        actions: &mut VecDeque<Action>,
    ) -> bool {
        if self.at_rest || now >= self.give_up {
            return true;
        }
        if now < self.ask_at {
            return false;
        }
        let mut send = |command: Command| {
            let record = RecordKind::Command(Box::new(command.clone()));
            actions.push_back(Action::Record(Device::Plan, record));
            let mission = Mission { id: *next_id, command };
            *next_id = next_id.wrapping_add(1);
            actions.push_back(Action::Mission(Box::new(mission)));
        };
        if self.told_at.is_none() {
            self.told_at = Some(now);
            send(Command::Stop);
            actions.push_back(Action::Table(table::Command::Stop));
        } else {
            send(Command::RequestState);
        }
        self.ask_at = now + ASK_PERIOD;
        false
    }
}

const fn now_plus(now: Timestamp) -> Timestamp {
    Timestamp::from_nanos(now.as_nanos().saturating_add(REST_WAIT.as_nanos()))
}

#[cfg(test)]
mod tests {
    use super::{Action, REST_WAIT, Timestamp};
    use crate::engine::robot::NO_REST;
    use crate::engine::{BenchFacts, Engine};
    use plan::Plan;
    use record::RecordKind;
    use std::collections::BTreeMap;
    use std::sync::Arc;

    const PLAN: &str = "name = \"still\"\ntitle = \"Nothing moves\"\ndevices = \"paper\"\n\
        steps = [{ log = { duration_s = 1, interval_s = 1 } }]\n\
        [[measurement]]\nname = \"degraded\"\ndoc = \"Times degraded\"\nquantity = \"health.degraded\"\n\
        unit = \"1\"\ncheck = { all_within = [0, 0] }\n";

    #[test]
    fn a_base_that_nobody_saw_at_rest_is_said_in_the_reason_and_in_the_record() {
        let plan = Arc::new(Plan::parse("still.toml", PLAN).expect("a plan"));
        let (facts, none) = (BenchFacts::default(), BTreeMap::new());
        let mut engine = Engine::new(plan, Timestamp::ZERO).with_robot(facts, none);
        engine.abort(Timestamp::ZERO);
        assert_eq!(engine.ending(), None, "the base may still move");
        engine.wake(Timestamp::ZERO + REST_WAIT);
        let reason = engine.ending().and_then(|ending| ending.reason.clone());
        assert_eq!(reason.as_deref(), Some(&*format!("stopped by request; {NO_REST}")));
        let noted = std::iter::from_fn(|| engine.action()).any(
            |action| matches!(action, Action::Record(_, RecordKind::Note(note)) if note == NO_REST),
        );
        assert!(noted);
    }

    /// A person may take an hour to carry a robot; a controller may not take as long to believe where it is.
    #[test]
    fn an_answer_that_never_comes_ends_the_run_before_a_person_would() {
        let text = PLAN.replace(
            "{ log = { duration_s = 1, interval_s = 1 } }",
            "{ place = { x_m = 0, y_m = 0, heading_deg = 0 } }",
        );
        let plan = Arc::new(Plan::parse("still.toml", &text).expect("a plan"));
        let limit = plan.steps[0].answer_limit().expect("a person takes part");
        let (facts, none) = (BenchFacts::default(), BTreeMap::new());
        let mut engine = Engine::new(plan, Timestamp::ZERO).with_robot(facts, none);
        engine.answer_limit = Some(limit);
        engine.send(Timestamp::ZERO, controller::mission::Command::RequestState);
        assert_eq!(engine.next_wakeup(), Timestamp::ZERO + limit);
        engine.wake(Timestamp::ZERO + limit);
        engine.wake(Timestamp::ZERO + limit + REST_WAIT);
        let reason = engine.ending().and_then(|ending| ending.reason.clone()).unwrap_or_default();
        assert!(reason.contains("the controller did not answer the mission"), "{reason}");
    }
}
