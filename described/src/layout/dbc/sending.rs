//! Send conditions of a message by Vector's interaction layer.

use super::parts::{Of, Value};
use super::syntax::{
    CYCLE_TIME_FAST_MS, CYCLE_TIME_MS, DELAY_TIME_MS, MessageLine, REPETITIONS, SEND_TYPE,
    SIGNAL_SEND_TYPE, Syntax,
};
use crate::layout::SendKind;
use crate::layout::send_rule::SendRule;
use crate::layout::signal::Signal;
use wire::time::Span;

/// The message's period and other send conditions; `signals` are the kept ones, by name.
pub(super) fn sending(
    syntax: &Syntax,
    message: &MessageLine,
    signals: &[Signal],
    name_of: &dyn Fn(usize) -> String,
) -> (Option<Span>, SendRule) {
    let of = Of::Message(message.id);
    let time = |name: &str| {
        let ms = syntax.attribute(of.clone(), name).and_then(Value::number);
        ms.filter(|ms| *ms > 0.0 && ms.is_finite()).map(|ms| Span::from_secs_f64(ms / 1e3))
    };
    let period = time(CYCLE_TIME_MS);
    let changing: Vec<usize> = (0..message.signals.len())
        .filter(|place| {
            let of = Of::Signal(message.id, message.signals[*place].name.clone());
            let kind = syntax.choice(of, SIGNAL_SEND_TYPE).map(plain);
            // `OnWrite`, `OnChange`, and both with repetition.
            kind.is_some_and(|kind| kind.starts_with("onwrite") || kind.starts_with("onchange"))
        })
        .filter_map(|place| signals.iter().position(|signal| signal.name == name_of(place)))
        .collect();
    let said = syntax.choice(of.clone(), SEND_TYPE).map(plain).unwrap_or_default();
    let of_signals = || match (period, changing.is_empty()) {
        (_, true) => SendKind::Cyclic,
        (None, false) => SendKind::OnChange,
        (Some(_), false) => SendKind::CyclicAndOnChange,
    };
    let kind = match said.as_str() {
        "spontaneous" | "event" | "onevent" | "eventdriven" | "triggered" => SendKind::OnEvent,
        "onchange" | "onwrite" => SendKind::OnChange,
        // `CyclicAndSpontaneous`, `cyclicAndSpontanX`, `CyclicAndTriggered`, `CyclicAndOnChange`
        said if said.starts_with("cyclicand") && period.is_some() => SendKind::CyclicAndOnChange,
        said if said.starts_with("cyclicand") => SendKind::OnChange,
        _ => of_signals(),
    };
    let times = syntax.attribute(of.clone(), REPETITIONS).and_then(Value::number);
    let times = times.filter(|times| (1.0..=f64::from(u16::MAX)).contains(times));
    let rule = SendRule {
        kind,
        signals: (!changing.is_empty()).then_some(changing),
        fast: time(CYCLE_TIME_FAST_MS).zip(times.map(|times| times as u32)),
        min_delay: time(DELAY_TIME_MS).unwrap_or(Span::ZERO),
    };
    if kind == SendKind::Cyclic {
        return (period, SendRule::default());
    }
    (period.filter(|_| rule.is_cyclic()), rule)
}

/// The letters and digits of a name, in lower case: tools write `cyclicAndSpontaneous` and `Cyclic and Spontaneous`.
fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_ascii_alphanumeric()).collect::<String>().to_lowercase()
}
