//! An order to move that the base has not been heard to end: it moves, whatever it said before.
//!
//! On CAN nothing answers an order, and one can be late by any time. A base that stands has had all orders if it was
//! heard to have moved, and did not stop by itself. Otherwise some may still be on their way. On the serial line an
//! answer that was asked for after an order shows that the order has arrived.

use wire::base::{Motion, Request};
use wire::time::Timestamp;
use wire::units::{AngularRate, Speed};

/// The order in force, and what became of the last one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ordered {
    /// The base answers orders.
    answered: bool,
    order: Option<Order>,
    stood: Stood,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Order {
    began: Timestamp,
    /// What the base had said before.
    from: Option<Motion>,
    /// The base was heard to have moved since.
    followed: bool,
    /// When the order to stand was sent.
    ended: Option<Timestamp>,
}

/// Why the base stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stood {
    AsTold,
    /// It was not heard to have moved.
    Still,
    /// It stopped because orders no longer arrived, and says so.
    ByItself,
}

impl Ordered {
    /// No order yet, to a base that answers orders or does not.
    pub(crate) const fn new(answered: bool) -> Self {
        Self { answered, order: None, stood: Stood::AsTold }
    }

    /// Time of the order.
    pub(crate) fn since(&self) -> Option<Timestamp> {
        self.order.map(|order| order.began)
    }

    /// True unless an order to move is in force and the base was not heard to have moved since.
    pub(crate) fn is_followed(&self) -> bool {
        self.order.is_none_or(|order| order.followed)
    }

    /// True if the last message ended the order without a sign that it arrived: it may still move the base.
    pub(crate) fn was_not_followed(&self) -> bool {
        self.stood == Stood::Still
    }

    /// True if the base stopped by itself, and has not received an order since. Orders to move may be on their way. An
    /// order to stand is answered: the base no longer says that it stopped by itself.
    pub(crate) fn waits_for_answer(&self) -> bool {
        self.stood == Stood::ByItself
    }

    /// `request` is sent at `now` to a base that last said `from`.
    pub(crate) fn sends(&mut self, now: Timestamp, request: &Request, from: Option<Motion>) {
        let moves = match *request {
            Request::SetVelocity { drive, steer } => {
                drive != Speed::ZERO || steer != AngularRate::ZERO
            }
            Request::Stop => false,
            _ => return,
        };
        if moves {
            let order = Order { began: now, from, followed: false, ended: None };
            self.order.get_or_insert(order).ended = None;
        } else if let Some(order) = &mut self.order {
            order.ended.get_or_insert(now);
        }
    }

    /// The base said this, and sampled it at `sampled` or later.
    pub(crate) fn hears(&mut self, sampled: Timestamp, motion: &Motion) {
        let ended = self.ends(sampled, motion);
        let by_itself = motion.command_timed_out && !motion.moving;
        self.stood = match ended {
            Some(false) if !self.answered => Stood::Still,
            Some(true) if !self.answered && by_itself => Stood::ByItself,
            None if by_itself && self.waits_for_answer() => Stood::ByItself,
            _ => Stood::AsTold,
        };
    }

    /// Ends the order if the base stands. Returns whether it had followed.
    fn ends(&mut self, sampled: Timestamp, motion: &Motion) -> Option<bool> {
        let order = self.order.as_mut()?;
        let elsewhere = order.from.is_none_or(|from| {
            from.displacement != motion.displacement || from.heading != motion.heading
        });
        order.followed |= motion.moving || elsewhere;
        let (followed, ended) = (order.followed, order.ended?);
        if motion.moving || sampled <= ended {
            return None;
        }
        self.order = None;
        Some(followed)
    }
}

#[cfg(test)]
mod tests {
    use super::{AngularRate, Motion, Ordered, Request, Speed, Timestamp};
    use wire::time::Span;
    use wire::units::Length;

    /// A base that was ordered to move and to stand, and then says each of `said`: whether the order is followed, and
    /// whether an answer is missing.
    fn after(answered: bool, said: &[Motion]) -> (bool, bool) {
        let at = |ms| Timestamp::ZERO + Span::from_millis(ms);
        let rests = Motion::default();
        let mut ordered = Ordered::new(answered);
        let (drive, steer) = (Speed::from_m_per_s(0.4), AngularRate::ZERO);
        ordered.sends(at(0), &Request::SetVelocity { drive, steer }, Some(rests));
        ordered.hears(at(10), &rests);
        assert!(ordered.since() == Some(at(0)) && !ordered.was_not_followed());
        ordered.sends(at(20), &Request::Stop, Some(rests));
        for (n, motion) in said.iter().enumerate() {
            ordered.hears(at(30 + n as i64), motion);
        }
        (!ordered.was_not_followed(), ordered.waits_for_answer())
    }

    #[test]
    fn a_base_has_had_all_orders_if_it_moved_and_stopped_because_it_was_told_to() {
        let rests = Motion::default();
        let moves = Motion { moving: true, ..rests };
        let went = Motion { displacement: Length::from_m(0.01), ..rests };
        let timed_out = Motion { command_timed_out: true, ..went };
        assert_eq!(after(false, &[moves, went]), (true, false));
        assert_eq!(after(false, &[went]), (true, false), "its motion was not heard, but shows");
        assert_eq!(after(false, &[rests]), (false, false));
        assert_eq!(after(true, &[rests]), (true, false), "it answers orders");
        assert_eq!(after(false, &[moves, timed_out, timed_out]), (true, true));
        assert_eq!(after(false, &[moves, timed_out, went]), (true, false), "it had an order since");
        assert_eq!(after(true, &[moves, timed_out]), (true, false));
    }
}
