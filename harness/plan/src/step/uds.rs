//! Sends a diagnostic request and judges its response.

use super::{Known, Op, StepKind};
use crate::Checked;
use crate::name::Name;
use crate::number;
use crate::quantities::UDS_PREFIX;
use crate::speakers::DEVICE;
use crate::survey::Survey;
use crate::time_limits::SLACK;
use described::Place;
use described::{KeyFunction, Number, NumberType, Reply, Request, negative_response};
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// Waits for a response to begin. Assumption: as a tester does that is not told otherwise; P2* is that of ISO 14229-2.
const P2: Span = Span::from_secs(1);
const P2_STAR: Span = Span::from_secs(5);

/// First byte of a number behind the echo of an identifier.
const BEHIND_IDENTIFIER: usize = 3;

/// First byte of a negative response, and what a positive one adds to the service.
const NEGATIVE: u8 = 0x7F;
const POSITIVE: u8 = 0x40;

/// Most response pendings that the default time limit allows for.
const PENDING_MAX: i64 = 10;

/// A diagnostic request (UDS) and its response:
/// `uds = { node = "ecu", request = [0x22, 0xF1, 0x90] }`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Uds {
    /// The node; the only device where this is absent.
    #[serde(default)]
    pub node: Option<Name>,
    /// Service and what follows it, in bytes.
    #[schemars(length(min = 1, max = 4095))]
    pub request: Vec<u8>,
    /// To all servers, in a single frame.
    #[serde(default)]
    pub functional: bool,
    /// The response that is right.
    #[serde(default)]
    pub expect: Expected,
    /// After a request for a seed: the key that is sent in a second request, as an expression of `seed`.
    #[serde(default)]
    pub key: Option<String>,
    /// Length of the key in bytes; that of the seed where this is absent.
    #[serde(default)]
    #[schemars(range(min = 1, max = 6))]
    pub key_bytes: Option<usize>,
    /// A number of the response, observed as `uds.<name>`.
    #[serde(default)]
    pub read: Option<Read>,
    /// How long to wait for a response to begin.
    #[serde(rename = "p2_s", default = "p2", with = "number::Duration")]
    pub p2: Span,
    /// The same after a response pending.
    #[serde(rename = "p2_star_s", default = "p2_star", with = "number::Duration")]
    pub p2_star: Span,
}

const fn p2() -> Span {
    P2
}

const fn p2_star() -> Span {
    P2_STAR
}

/// A response.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Expected {
    /// A positive one.
    #[default]
    Positive,
    /// None.
    Silence,
    /// Any, or none.
    Any,
    /// A negative one with this code.
    Negative(u8),
    /// These bytes.
    Data(Vec<u8>),
    /// A positive one with this text behind the echo of an identifier.
    Text(String),
}

/// A number in a response, most significant byte first.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Read {
    /// Its name.
    pub name: Name,
    /// Its type.
    #[serde(rename = "type")]
    pub kind: NumberType,
    /// Its value per count; 1 where this is absent.
    #[serde(default)]
    pub scale: Option<f64>,
    /// Its value at count 0; 0 where this is absent.
    #[serde(default)]
    pub offset: Option<f64>,
    /// Its unit; `1` where this is absent.
    #[serde(default)]
    pub unit: Option<String>,
    /// Its first byte in the response, from 0; 3 where this is absent, behind the echo of an identifier.
    #[serde(default)]
    pub at: Option<usize>,
}

impl Read {
    /// Its unit.
    pub fn unit(&self) -> &str {
        self.unit.as_deref().unwrap_or("1")
    }

    fn number(&self) -> Option<Number> {
        Number::new(self.kind, self.scale.unwrap_or(1.0), self.offset.unwrap_or(0.0))
    }
}

impl Uds {
    /// The node that is asked.
    pub fn node(&self) -> &str {
        self.node.as_ref().map_or(DEVICE, Name::as_str)
    }

    /// The quantity that it reads.
    pub fn quantity(&self) -> Option<String> {
        self.read.as_ref().map(|read| format!("{UDS_PREFIX}{}", read.name))
    }

    /// The request for a client.
    pub fn request(&self) -> Request {
        let (data, functional) = (self.request.clone(), self.functional);
        Request { data, functional, p2: self.p2, p2_star: self.p2_star }
    }

    /// The request with the key that belongs to the seed in a response, if the step has a key. `None` if there is
    /// nothing to send: no seed, or one of zeros, which says that the level is unlocked.
    ///
    /// # Errors
    /// When the expression gives no key for this seed.
    pub fn unlocks(&self, reply: &Reply) -> Result<Option<Self>, String> {
        let (Some(key), Reply::Response(response)) = (&self.key, reply) else { return Ok(None) };
        let [service, level, ..] = *self.request.as_slice() else { return Ok(None) };
        let Some(seed) = response.strip_prefix(&[service | POSITIVE, level]) else {
            return Ok(None);
        };
        if seed.iter().all(|byte| *byte == 0) {
            return Ok(None);
        }
        let bytes = self.key_bytes.unwrap_or(seed.len());
        let function = KeyFunction::parse(key).map_err(|(_, message, _)| message)?;
        let key = function.key(seed, bytes);
        let key =
            key.ok_or_else(|| format!("no key of {bytes} bytes for the seed {}", hex(seed)))?;
        let request = [&[service, level.wrapping_add(1)], key.as_slice()].concat();
        Ok(Some(Self { request, key: None, ..self.clone() }))
    }

    /// The number that the step reads from a right response.
    ///
    /// # Errors
    /// When the response is not the expected one.
    pub fn judge(&self, reply: &Reply) -> Result<Option<f64>, String> {
        let asked = self.request.first().copied().unwrap_or_default();
        let response = match reply {
            Reply::Response(response) => Some(response.as_slice()),
            Reply::Silence => None,
            Reply::Failed(why) => return Err(why.clone()),
        };
        let is_positive = response.and_then(<[u8]>::first) == Some(&(asked | POSITIVE));
        let is_right = match (&self.expect, response) {
            (Expected::Any, _) | (Expected::Silence, None) => true,
            (Expected::Positive, Some(_)) => is_positive,
            (Expected::Negative(code), Some(response)) => response == [NEGATIVE, asked, *code],
            (Expected::Data(data), Some(response)) => response == data.as_slice(),
            (Expected::Text(text), Some(response)) => {
                is_positive && response.get(BEHIND_IDENTIFIER..) == Some(text.as_bytes())
            }
            _ => false,
        };
        if !is_right {
            let found = response.map_or_else(|| "no response".to_owned(), shown);
            return Err(format!("expected {}, and {found} came", self.expect));
        }
        let (Some(read), Some(response), true) = (&self.read, response, is_positive) else {
            return Ok(None);
        };
        let data = response.get(read.at.unwrap_or(BEHIND_IDENTIFIER)..);
        let value = read.number().zip(data).and_then(|(number, data)| number.value(data));
        let name = read.name.as_str();
        value.map(Some).ok_or_else(|| format!("{} is too short for `{name}`", hex(response)))
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" ")
}

fn shown(response: &[u8]) -> String {
    match response {
        [NEGATIVE, _, code] => format!("{} ({})", hex(response), negative_response(*code)),
        _ => hex(response),
    }
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Positive => f.write_str("a positive response"),
            Self::Silence => f.write_str("no response"),
            Self::Any => f.write_str("any response"),
            Self::Negative(code) => write!(f, "{code:#04X} ({})", negative_response(*code)),
            Self::Data(data) => f.write_str(&hex(data)),
            Self::Text(text) => write!(f, "\"{text}\""),
        }
    }
}

impl StepKind for Uds {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ask {} {}", self.node(), hex(&self.request))
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Uds(Box::new(self.clone()))])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        if !(1..=4095).contains(&self.request.len()) {
            let message = format!("a request of {} bytes, expected 1 to 4095", self.request.len());
            return Err(at.key("request").mistake(message));
        }
        if let Some(key) = &self.key
            && let Err((range, message, help)) = KeyFunction::parse(key)
        {
            return Err(at.key("key").within(range).mistake(message).with_help(help));
        }
        if let Some(read) = &self.read {
            if read.number().is_none() {
                let message = "a scale is finite and not zero".to_owned();
                return Err(at.key("read").mistake(message));
            }
            survey.reads("uds", &read.name, Some(read.unit().to_owned()), at)?;
        }
        survey.subject.asked(self.node(), at)
    }

    fn limit(&self) -> Span {
        self.p2 + self.p2_star * PENDING_MAX + SLACK
    }
}
