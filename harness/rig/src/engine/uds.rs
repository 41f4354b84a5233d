//! Responses to diagnostic requests.

use super::{Engine, Waiting};
use described::Reply;
use plan::Op;
use record::outcome::Outcome;
use wire::time::Timestamp;

impl Engine {
    pub fn replied(&mut self, now: Timestamp, reply: &Reply) {
        let Waiting::Reply(step) = &self.waiting else { return };
        let step = step.clone();
        self.waiting = Waiting::Nothing;
        let judged = match step.unlocks(reply) {
            Ok(Some(second)) => {
                self.ops.push_front(Op::Uds(Box::new(second)));
                Ok(None)
            }
            Ok(None) => step.judge(reply),
            Err(why) => Err(why),
        };
        match (judged, step.quantity()) {
            (Ok(Some(value)), Some(name)) => {
                self.observe(now, |collector| collector.add_named(&name, value, 0.0, &[]));
            }
            (Ok(_), _) => {}
            (Err(why), _) => {
                return self.end_here(now, Outcome::Failed, &why);
            }
        }
        self.advance(now);
    }
}
