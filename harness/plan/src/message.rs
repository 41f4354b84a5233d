//! Steps that send messages to a device of the user's own.

use super::number;
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
    /// Signals and their values, in their units; the others stay what they were last, or were at first.
    #[serde(default, deserialize_with = "values")]
    pub set: BTreeMap<String, f64>,
    /// It is sent again after each such time, until it is sent anew or stopped; 0 sends it once. Where it is absent, as
    /// the layout says.
    #[serde(rename = "every_s", default, deserialize_with = "number::sending_period")]
    #[schemars(schema_with = "number::schema::sending_period")]
    pub every: Option<Span>,
}

/// A message is no longer sent again: `stop_sending = "Command"`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct StopSending {
    /// Its name in the layout of the device.
    pub message: String,
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

fn values<'de, D: serde::Deserializer<'de>>(d: D) -> Result<BTreeMap<String, f64>, D::Error> {
    #[derive(Deserialize)]
    #[serde(transparent)]
    struct Value(#[serde(deserialize_with = "number::finite")] f64);
    let values = BTreeMap::<String, Value>::deserialize(d)?;
    Ok(values.into_iter().map(|(name, value)| (name, value.0)).collect())
}
