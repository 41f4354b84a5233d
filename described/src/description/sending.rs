//! When a message is sent, from its file and its DBC.

use super::parts::{PERIOD_S_MIN, seconds};
use crate::error::{Mistake, Read};
use crate::file::MessageRules;
use crate::layout::{Message, SendKind, Sender};
use crate::place::{Place, given};

/// Applies the file's period and other send conditions to the message.
pub(super) fn ruled(message: &mut Message, rules: &MessageRules, place: &Place) -> Read {
    let period = rules.period_s.map(|s| seconds(s, PERIOD_S_MIN, &place.key("period_s")));
    let period = period.transpose()?;
    match (rules.send, period) {
        (Some(kind @ (SendKind::OnChange | SendKind::OnEvent)), Some(_)) => {
            let name = if kind == SendKind::OnChange { "on_change" } else { "on_event" };
            let text = format!("`{}` is sent `{name}`, and has no period", message.name);
            return Err(Mistake::new(place.key("period_s").name(), text)
                .help("both is `send = \"cyclic_and_on_change\"`"));
        }
        (Some(kind), _) if kind != SendKind::Cyclic && never_changes(message) => {
            let text = format!("`{}` has no field: it never changes", message.name);
            return Err(Mistake::new(place.key("send"), text)
                .help("give it a field, or a `period_s`, or say which message it `answers`"));
        }
        (Some(kind), _) => message.send.kind = kind,
        // The file's period applies, whatever the DBC specifies.
        (None, Some(_)) if !message.send.is_cyclic() => {
            message.send.kind = SendKind::CyclicAndOnChange;
        }
        (None, _) => {}
    }
    if period.is_some() {
        message.period = period;
    }
    if rules.answers.is_some() && period.is_none() || !message.send.is_cyclic() {
        // An answer is not periodic, whatever the DBC specifies.
        message.period = None;
    }
    if rules.send.is_some_and(|_| message.send.is_cyclic()) && message.period.is_none() {
        let text = format!("`{}` is cyclic, and has no period", message.name);
        return Err(Mistake::new(place.key("send"), text).help("add its `period_s`"));
    }
    occasions(message, rules, place)
}

/// Whether the device sends it, and it is always the same. What the host sends, a plan may repeat.
fn never_changes(message: &Message) -> bool {
    message.sender == Sender::Device && message.signals.is_empty()
}

/// Applies the rules for sending after a change.
fn occasions(message: &mut Message, rules: &MessageRules, place: &Place) -> Read {
    let after_change = given!(rules; fast_period_s, fast_times, min_delay_s);
    if let (SendKind::Cyclic, Some(key)) = (message.send.kind, after_change) {
        let text = format!("`{}` is not sent on a change", message.name);
        return Err(Mistake::new(place.key(key).name(), text)
            .help("add `send`: \"on_change\", \"on_event\" or \"cyclic_and_on_change\""));
    }
    match (rules.fast_period_s, rules.fast_times) {
        (Some(period), Some(times)) => {
            let period = seconds(period, PERIOD_S_MIN, &place.key("fast_period_s"))?;
            message.send.fast = Some((period, times));
        }
        (Some(_), None) => {
            let text = "a fast period without an end";
            return Err(Mistake::new(place.key("fast_period_s").name(), text)
                .help("add `fast_times`: how often it is sent again after a change"));
        }
        (None, Some(_)) => {
            let text = "sent again, and it is not said when";
            return Err(Mistake::new(place.key("fast_times").name(), text)
                .help("add `fast_period_s`: from one to the next after a change"));
        }
        (None, None) => {}
    }
    if let Some(delay) = rules.min_delay_s {
        message.send.min_delay = seconds(delay, 0.0, &place.key("min_delay_s"))?;
    }
    Ok(())
}
