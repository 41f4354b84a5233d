//! An order to move that the base has not been heard to end: it moves, whatever it said before.

use wire::base::{Motion, Request};
use wire::time::Timestamp;
use wire::units::{AngularRate, Speed};

/// The order in force, if any.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Ordered(Option<Order>);

#[derive(Debug, Clone, Copy, PartialEq)]
struct Order {
    began: Timestamp,
    /// When the order to stand was sent.
    ended: Option<Timestamp>,
}

impl Ordered {
    /// Time of the order.
    pub(crate) fn since(&self) -> Option<Timestamp> {
        self.0.map(|order| order.began)
    }

    /// `request` is sent at `now`.
    pub(crate) fn sends(&mut self, now: Timestamp, request: &Request) {
        let moves = match *request {
            Request::SetVelocity { drive, steer } => {
                drive != Speed::ZERO || steer != AngularRate::ZERO
            }
            Request::Stop => false,
            _ => return,
        };
        if moves {
            let began = self.since().unwrap_or(now);
            self.0 = Some(Order { began, ended: None });
        } else if let Some(order) = &mut self.0 {
            order.ended.get_or_insert(now);
        }
    }

    /// The base said this, and sampled it at `sampled` or later.
    pub(crate) fn hears(&mut self, sampled: Timestamp, motion: &Motion) {
        let ended = self.0.and_then(|order| order.ended);
        if !motion.moving && ended.is_some_and(|ended| sampled > ended) {
            self.0 = None;
        }
    }
}
