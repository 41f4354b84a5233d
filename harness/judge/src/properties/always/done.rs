//! Whether the base really completed a turn or straight that a healthy controller reports as done, and really stands
//! when it is said to stand.

use super::Judge;
use crate::properties::seen::Truth;
use crate::properties::senses::{Fact, Order, Senses, Topic};
use crate::properties::verdict::{Judgement, below};
use controller::health::Level;
use controller::mission::{HeadingSource, MissionId, Report};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, Length};

/// Time from a stop until a state that says "at rest" is taken at its word: as long as the end of a run waits before it
/// asks for one. Before, it may rest on motion from before the stop.
const STOP_AGE_MIN: Span = Span::from_millis(200);

/// Judged at each answer while the gyro closes the loops, and rest also at the states after a stop.
#[derive(Debug, Clone, Default)]
pub(super) struct DoneIsDone {
    pub(super) turn_max: Angle,
    pub(super) distance_max: Length,
    pub(super) began: Option<(MissionId, Truth)>,
    pub(super) stopped: Option<Timestamp>,
    /// Where the base has to face by the orders since it first moved, or since one of them was broken off.
    pub(super) facing: Option<Angle>,
}

impl DoneIsDone {
    fn done(
        &self,
        senses: &Senses,
        judgement: &mut Judgement,
        order: Order,
        (from, to): (Truth, Truth),
    ) {
        match order {
            Order::Turn(ordered) => {
                let (ordered, limit) = (ordered.deg(), self.turn_max.deg());
                let turned = (to.pose.heading - from.pose.heading).deg();
                // A turn makes good by what the drive before it ended off its heading.
                let off =
                    self.facing.map_or(f64::INFINITY, |facing| (to.pose.heading - facing).deg());
                let off = (turned - ordered).abs().min(off.abs());
                judgement.take(senses.now, below(off, limit), || {
                    format!(
                        "a turn of {ordered:.1} deg is called done and was one of {turned:.1} deg, \
                         expected within {limit} deg"
                    )
                });
            }
            Order::Straight(ordered) => {
                let (ordered, limit) = (ordered.m(), self.distance_max.m());
                let (x, y) = (to.pose.x - from.pose.x, to.pose.y - from.pose.y);
                let along = from.pose.heading;
                let went = (x * along.cos() + y * along.sin()).m();
                judgement.take(senses.now, below((went - ordered).abs(), limit), || {
                    format!(
                        "a straight of {ordered:.3} m is called done and was one of {went:.3} m, \
                         expected within {limit} m"
                    )
                });
            }
            _ => {}
        }
    }
}

/// Judges a base that is said to stand. There is no margin: whatever moves does not stand.
fn stands(judgement: &mut Judgement, senses: &Senses, truth: Truth) {
    let margin = if truth.is_moving() { -1.0 } else { 1.0 };
    judgement.take(senses.now, margin, || {
        format!(
            "the base is said to stand and moves at {:.4} m/s and {:.3} deg/s",
            truth.speed.m_per_s(),
            truth.steer_rate.deg_per_s()
        )
    });
}

impl Judge for DoneIsDone {
    fn hears(&self) -> &'static [Topic] {
        &[Topic::Mission, Topic::Step, Topic::State]
    }

    fn judge(&mut self, senses: &Senses, fact: &Fact, judgement: &mut Judgement) {
        match (fact, senses.truth) {
            (Fact::Told(id, order @ (Order::Turn(_) | Order::Straight(_))), Some(truth)) => {
                self.began = Some((*id, truth));
                self.stopped = None;
                let facing = self.facing.get_or_insert(truth.pose.heading);
                if let Order::Turn(ordered) = order {
                    *facing += *ordered;
                }
            }
            (Fact::Told(_, Order::Stop), _) => self.stopped = Some(senses.now),
            (Fact::State(state), Some(truth)) => {
                let stopped = self.stopped.is_some_and(|at| senses.now - at >= STOP_AGE_MIN);
                let believed = !state.moving && !senses.is_misheard();
                if stopped && believed && senses.health.level == Level::Ok {
                    stands(judgement, senses, truth);
                }
            }
            (Fact::Placed, _) => (self.began, self.facing) = (None, None),
            (Fact::Answered(_, _, Report::Refused { .. } | Report::Aborted { .. }), _)
            | (Fact::Answered(_, Order::Setting | Order::Source(_), _), _) => self.facing = None,
            (Fact::Answered(id, order, Report::Done { .. }), Some(truth)) => {
                let Some((began, from)) = self.began else { return };
                let well = senses.health.level == Level::Ok;
                if began == *id && well && !senses.is_misheard() {
                    stands(judgement, senses, truth);
                }
                if began == *id && well && senses.source == HeadingSource::Gyro {
                    self.done(senses, judgement, *order, (from, truth));
                }
            }
            _ => {}
        }
    }
}
