//! What a step waits for.

use super::Segment;
use controller::mission::MissionId;
use plan::{Answer, Condition, Op, Uds};
use wire::time::{Span, Timestamp};

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Waiting {
    /// Nothing: the next operation can begin.
    Nothing,
    Mission(MissionId),
    Until(Timestamp),
    /// The end of a log, and of its interval.
    Log {
        until: Timestamp,
        interval: Span,
        due: Timestamp,
    },
    /// The end of a window at rest.
    Residual(Timestamp),
    Condition(Condition),
    Reaction,
    Sdo,
    /// A state in which nothing moves.
    Rest,
    /// The same before the first mission, until this instant.
    FirstRest(Timestamp),
    Absolute(Op),
    Look(Option<Segment>),
    /// The world's confirmation, with a number if one is asked for.
    Answer(Option<Answer>),
    /// The response to a diagnostic request.
    Reply(Box<Uds>),
    TableWord,
    /// The table's state, queried again at this instant while it turns.
    TableRest {
        ask_at: Timestamp,
    },
}
