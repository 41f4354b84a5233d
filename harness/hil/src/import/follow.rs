//! Matches moves of the base to the plan's steps, in the plan's order.
//!
//! A repeat is assumed to do all its rounds: the bus does not show whether a condition ended it sooner.

use super::moves::Move;
use plan::{Plan, Segment, Step};
use rig::engine::observe::Tags;
use rig::engine::program::{Next, Program};
use std::collections::VecDeque;
use std::sync::Arc;
use wire::time::Timestamp;

/// A move matches a step if its size is within this share of the step's. Assumption: half, so that a bad stop is judged
/// while another mission does not match.
pub const SIZE_SHARE: f64 = 0.5;

fn is(segment: Segment, seen: &Move) -> bool {
    let (is_kind, size, nominal) = match segment {
        Segment::Straight(distance) => (seen.is_straight(), seen.travelled.m(), distance.m()),
        Segment::Turn(angle) => (!seen.is_straight(), seen.turned.rad(), angle.rad()),
    };
    is_kind && (size / nominal - 1.0).abs() <= SIZE_SHARE
}

/// Describes an observed move like an expected one.
pub(super) fn in_words(seen: &Move) -> Segment {
    match seen.is_straight() {
        true => Segment::Straight(seen.travelled),
        false => Segment::Turn(seen.turned),
    }
}

/// A part of a plan that moves the base, and its place.
#[derive(Debug, Clone)]
pub struct Leg {
    pub expected: Segment,
    /// Place in the plan: `steps[2].repeat[1] (round 7 of 40)`.
    pub place: String,
    pub tags: Tags,
}

/// The moves of a plan, in order.
#[derive(Debug)]
pub struct Legs {
    program: Program,
    waiting: VecDeque<Leg>,
    rounds: u64,
    round_begun: bool,
}

impl Legs {
    /// Creates the iterator over the moves of `plan`.
    pub fn new(plan: &Arc<Plan>) -> Self {
        let program = Program::new(Arc::clone(plan), Timestamp::ZERO, Timestamp::MAX);
        Self { program, waiting: VecDeque::new(), rounds: 0, round_begun: false }
    }

    fn step(&mut self, step: &Step) {
        // As in a run: a round that contains only another repeat does not count.
        self.rounds += u64::from(std::mem::take(&mut self.round_begun));
        let label = step.label.as_ref().map(|label| label.as_str());
        let tags = self.program.tags(&step.action, label, self.rounds);
        let place = self.program.place();
        let leg = |expected| Leg { expected, place: place.clone(), tags: tags.clone() };
        self.waiting.extend(step.action.segments().map(leg));
        self.program.step_done();
    }
}

impl Iterator for Legs {
    type Item = Leg;

    fn next(&mut self) -> Option<Leg> {
        loop {
            if let Some(leg) = self.waiting.pop_front() {
                return Some(leg);
            }
            // No time passes here, so no limit can be exceeded.
            match self.program.next(Timestamp::ZERO, |_| false) {
                Next::Step(step) => self.step(&step),
                Next::Round { .. } => self.round_begun = true,
                Next::Done => return None,
            }
        }
    }
}

pub fn moves_base(plan: &Plan) -> bool {
    Step::walk(&plan.steps).any(|step| step.action.segments().next().is_some())
}

/// Returns the leg of a move.
///
/// # Errors
/// When the move differs from the plan's next.
pub(super) fn follow(legs: &mut Legs, seen: &Move) -> Result<Option<Leg>, String> {
    let Some(leg) = legs.next() else { return Ok(None) };
    if is(leg.expected, seen) {
        return Ok(Some(leg));
    }
    Err(format!(
        "the log does not follow the plan: at {:.3} s it has {}, where {} is {}",
        seen.began.as_secs_f64(),
        in_words(seen),
        leg.place,
        leg.expected
    ))
}
