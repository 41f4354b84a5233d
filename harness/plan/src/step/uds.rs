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
    /// Its first byte in the response, from 0. Where this is absent, the number is all that follows the echo of an
    /// identifier, from byte 3.
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
        let echoed = echo(&self.request);
        let echoes = response
            .is_some_and(|response| response.get(1..).unwrap_or_default().starts_with(&echoed));
        let is_right = match (&self.expect, response) {
            (Expected::Any, _) | (Expected::Silence, None) => true,
            (Expected::Positive, Some(_)) => is_positive && echoes,
            (Expected::Negative(code), Some(response)) => response == [NEGATIVE, asked, *code],
            (Expected::Data(data), Some(response)) => response == data.as_slice(),
            (Expected::Text(text), Some(response)) => {
                let data = response.get(BEHIND_IDENTIFIER..);
                is_positive && echoes && data == Some(text.as_bytes())
            }
            _ => false,
        };
        if !is_right {
            let found = response.map_or_else(|| "no response".to_owned(), shown);
            let other = if is_positive && !echoes { ", which answers another request" } else { "" };
            return Err(format!("expected {}, and {found} came{other}", self.expect));
        }
        let (Some(read), Some(response), true) = (&self.read, response, is_positive) else {
            return Ok(None);
        };
        let data = response.get(read.at.unwrap_or(BEHIND_IDENTIFIER)..);
        let name = read.name.as_str();
        let number = read.number().zip(data);
        if read.at.is_none() && number.is_some_and(|(number, data)| data.len() > number.bytes()) {
            return Err(format!("{} is longer than `{name}`; `at` picks a part", hex(response)));
        }
        let value = number.and_then(|(number, data)| number.value(data));
        value.map(Some).ok_or_else(|| format!("{} is too short for `{name}`", hex(response)))
    }
}

/// What a positive response repeats behind its service (ISO 14229-1): a sub-function without the bit that suppresses
/// responses, an identifier, a block counter.
fn echo(request: &[u8]) -> Vec<u8> {
    let [service, rest @ ..] = request else { return Vec::new() };
    let bytes = match service {
        0x10 | 0x11 | 0x19 | 0x27 | 0x28 | 0x36 | 0x3E | 0x85 | 0x87 => 1,
        0x22 | 0x2E | 0x2F => 2,
        0x31 => 3,
        _ => 0,
    };
    let mut echo: Vec<u8> = rest.iter().take(bytes).copied().collect();
    let has_sub_function = !matches!(service, 0x22 | 0x2E | 0x2F | 0x36);
    if let (true, Some(sub_function)) = (has_sub_function, echo.first_mut()) {
        *sub_function &= 0x7F;
    }
    echo
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

    fn judges(&self) -> bool {
        self.expect != Expected::Any
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
                return Err(at.key("read").mistake("a scale is finite and not zero"));
            }
            survey.reads("uds", &read.name, Some(read.unit().to_owned()), at)?;
        }
        survey.subject.asked(self.node(), at)
    }

    fn limit(&self) -> Span {
        self.p2 + self.p2_star * PENDING_MAX + SLACK
    }
}

#[cfg(test)]
mod tests {
    use super::{Reply, Uds};

    fn judged(step: &str, response: &[u8]) -> Result<Option<f64>, String> {
        let step: Uds = toml::from_str(step).unwrap();
        step.judge(&Reply::Response(response.to_vec()))
    }

    #[test]
    fn a_response_to_another_request_is_refused() {
        for (request, right, wrong) in [
            ("[0x22, 0x10, 1]", &[0x62, 0x10, 1, 5][..], &[0x62, 0x10, 2, 5][..]),
            ("[0x2E, 0x20, 0, 7]", &[0x6E, 0x20, 0], &[0x6E, 0x30, 0]),
            ("[0x31, 1, 0xFF, 0]", &[0x71, 1, 0xFF, 0], &[0x71, 2, 0xFF, 1]),
            ("[0x10, 3]", &[0x50, 3, 0, 50, 1, 0xF4], &[0x50, 1, 0, 50, 1, 0xF4]),
            ("[0x27, 1]", &[0x67, 1, 9, 9], &[0x67, 3, 9, 9]),
            ("[0x3E, 0x80]", &[0x7E, 0], &[0x7E, 1]),
            ("[0x19, 2, 0xFF]", &[0x59, 2, 0xFF], &[0x59, 1, 0xFF]),
            ("[0x36, 1, 0xAA]", &[0x76, 1], &[0x76, 2]),
            ("[0x14, 0xFF, 0xFF, 0xFF]", &[0x54], &[0x55]),
        ] {
            let step = format!("request = {request}");
            assert_eq!(judged(&step, right), Ok(None), "{request}");
            assert!(judged(&step, wrong).is_err(), "{request}");
        }
        let other = judged("request = [0x22, 0xF1, 0x90]", &[0x62, 0xF1, 0x91, 1]).unwrap_err();
        let told =
            "expected a positive response, and 62 F1 91 01 came, which answers another request";
        assert_eq!(other, told);
    }

    #[test]
    fn a_number_is_all_that_follows_the_echo_or_where_it_begins() {
        let read = |at: &str| {
            format!("request = [0x22, 1, 0]\nread = {{ name = \"x\", type = \"u8\"{at} }}")
        };
        assert!(judged(&read(""), &[0x62, 1, 0, 7, 8]).unwrap_err().ends_with("`at` picks a part"));
        assert_eq!(judged(&read(", at = 4"), &[0x62, 1, 0, 7, 8]), Ok(Some(8.0)));
    }
}
