//! Sends a message.

use super::{Known, Op, Order, StepKind};
use crate::Checked;
use crate::number;
use crate::survey::Survey;
use described::Place;
use described::SignalValue;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt;
use wire::time::Span;

/// A message is sent to the device, once or again and again:
/// `send = { message = "Command", set = { Setpoint = 60 }, every_s = 0.1 }`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Send {
    /// Its name in the layout of the device.
    pub message: String,
    /// Signals and their values, in their units or by their names in the DBC; the others stay what they were last, or were at first.
    #[serde(default)]
    pub set: BTreeMap<String, SignalValue>,
    /// It is sent again after each such time, until it is sent anew or stopped; 0 sends it once. Where it is absent, as
    /// the layout says.
    #[serde(rename = "every_s", default, with = "number::SendingPeriod")]
    pub every: Option<Span>,
}

/// `Command with Setpoint = 60, every 0.1 s`.
impl fmt::Display for Send {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        for (index, (signal, value)) in self.set.iter().enumerate() {
            let before = if index == 0 { " with" } else { "," };
            write!(f, "{before} {signal} = {value}")?;
        }
        match self.every {
            Some(Span::ZERO) => f.write_str(", once"),
            Some(every) => write!(f, ", every {} s", every.as_secs_f64()),
            None => Ok(()),
        }
    }
}

impl StepKind for Send {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "send {self}")
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Order(Order::Send(self.clone()))])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        survey.sent.insert(&self.message);
        survey.subject.send(&self.message, &self.set, at)
    }
}
