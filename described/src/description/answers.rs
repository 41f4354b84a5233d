//! Messages that answer others: conditions, number and timing, and the handling of a question while another is being
//! answered.

use super::formula::formula;
use super::parts::{PERIOD_S_MIN, question, seconds};
use super::scope::Local;
use super::variables::Variables;
use crate::error::{Mistake, Read};
use crate::expression::Expression;
use crate::file::{self, MessageRules};
use crate::place::{Place, given};
use wire::time::Span;

/// Default number of messages waiting to be answered.
const QUEUE: usize = 8;

/// Maximum of that number. Assumption: no device stores more.
const QUEUE_MAX: usize = 1000;

/// Maximum number of messages in one answer.
pub(crate) const TIMES_MAX: f64 = 10_000.0;

#[derive(Debug, Clone)]
pub(crate) struct Answer {
    /// The index of the message that it answers.
    pub(crate) question: usize,
    pub(crate) delay: Span,
    /// Condition, evaluated when the question arrives.
    pub(crate) when: Option<Expression>,
    /// Number of messages, and the time between them.
    pub(crate) times: Option<(Expression, Span)>,
    pub(crate) busy: bool,
}

/// Handling of a message while another is being answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WhileAnswering {
    Refuse,
    /// Up to this many wait.
    Queue(usize),
}

/// Parses the keys of an answer, which are valid only together with `answers`.
pub(super) fn answer(
    rules: &MessageRules,
    variables: &Variables,
    place: &Place,
) -> Read<Option<Answer>> {
    let Some(name) = &rules.answers else {
        let given = given!(rules; delay_s, when, times, every_s, busy);
        let Some(key) = given else { return Ok(None) };
        let text = match key {
            "delay_s" => "a delay without a question".to_owned(),
            key => format!("`{key}` without a question"),
        };
        return Err(Mistake::new(place.key(key).name(), text)
            .help("add `answers`: the message that it comes after"));
    };
    let delay = seconds(rules.delay_s.unwrap_or(0.0), 0.0, &place.key("delay_s"))?;
    let question = question(name, &variables.layout, &place.key("answers"))?;
    let scope = Local { scope: variables, index: None, has_parts: false };
    let when = rules.when.as_ref().map(|when| formula(when, &scope, &place.key("when")));
    let times = match (&rules.times, rules.every_s) {
        (Some(times), Some(every)) => {
            let every = seconds(every, PERIOD_S_MIN, &place.key("every_s"))?;
            let times = formula(times, &scope, &place.key("times"))?;
            let is_count = |number: f64| (1.0..=TIMES_MAX).contains(&number) && number % 1.0 == 0.0;
            if let Some(number) = times.known().filter(|number| !is_count(*number)) {
                let text = format!("an answer of {number} messages");
                return Err(Mistake::new(place.key("times"), text)
                    .help(format!("a whole number from 1 to {TIMES_MAX}")));
            }
            Some((times, every))
        }
        (None, None) => None,
        (Some(_), None) => {
            return Err(Mistake::new(
                place.key("times").name(),
                "several messages, and it is not said when",
            )
            .help("add `every_s`: from one to the next"));
        }
        (None, Some(_)) => {
            return Err(Mistake::new(place.key("every_s").name(), "a period without an end")
                .help("add `times`: how many messages the answer is"));
        }
    };
    let busy = rules.busy.unwrap_or(false);
    Ok(Some(Answer { question, delay, when: when.transpose()?, times, busy }))
}

/// Parses the handling of a message that arrives while another is being answered.
pub(super) fn while_answering(rules: &MessageRules, place: &Place) -> Read<Option<WhileAnswering>> {
    match (rules.while_answering, rules.queue) {
        (Some(file::WhileAnswering::Queue), queue) => match queue.unwrap_or(QUEUE) {
            length @ 1..=QUEUE_MAX => Ok(Some(WhileAnswering::Queue(length))),
            length => Err(Mistake::new(place.key("queue"), format!("a queue of {length}"))
                .help(format!("from 1 to {QUEUE_MAX}"))),
        },
        (_, Some(_)) => Err(Mistake::new(place.key("queue").name(), "`queue` has no meaning here")
            .help("it is of `while_answering = \"queue\"`")),
        (Some(file::WhileAnswering::Refuse), None) => Ok(Some(WhileAnswering::Refuse)),
        (None, None) => Ok(None),
    }
}
