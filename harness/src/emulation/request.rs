//! What can be asked of emulated devices while they run, a JSON line each. `docs/emulators.md` has
//! every key.

use super::Role;
use super::link::LinkFault;
use emulators::parameters::ParameterError;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::fmt;
use wire::time::Span;

/// The longest line that is read as a request: dozens of parameters.
pub const LINE_BYTES_MAX: usize = 16 * 1_024;
/// Share of bytes or frames that `drop` loses where none is said (assumption: hurts, and is survived).
pub const SHARE_USUAL: f64 = 0.01;
/// How much later outputs come where it is not said, s. Assumption: the latency timer of a USB adapter that is set
/// to its most, 255 ms.
const DELAY_USUAL_S: f64 = 0.255;
/// The most that outputs may come later, s: a stream of 10 Hz then has 100 outputs on their way.
const DELAY_MAX_S: f64 = 10.0;
/// Fastest that a gyro alone can be turned, deg/s. Assumption: beyond what any of the gyros measures.
pub const RATE_MAX_DEG_PER_S: f64 = 1_000.0;

/// A request.
#[derive(Debug, Clone, PartialEq)]
pub enum Request {
    /// Set parameters of a device by name: all of them, or none.
    Set {
        /// Which device; needed where there are several.
        device: Option<Role>,
        /// Values by the parameters' names.
        values: BTreeMap<String, f64>,
    },
    /// Tell something.
    Get(Get),
    /// Turn a gyro that nothing carries, counter-clockwise positive, in deg/s.
    Turn(f64),
    /// Let something go wrong.
    Fault {
        /// Which device; needed where there are several.
        device: Option<Role>,
        /// What.
        fault: Fault,
        /// For how long; until told otherwise where it is absent.
        duration: Option<Span>,
    },
    /// Tell devices, parameters and faults.
    List,
}

/// What can be told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Get {
    /// What is true of all devices now.
    Truth,
    /// What has been counted.
    Counters,
}

/// What can go wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// All that the device sends.
    Link(LinkFault),
    /// The base's emergency stop is pressed.
    EmergencyStop,
    /// A drive of the base reports a fault.
    DriveFault,
    /// Nothing any more.
    None,
}

impl Fault {
    /// Its name in requests.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Link(LinkFault::Silent) => "silent",
            Self::Link(LinkFault::Stuck) => "stuck",
            Self::Link(LinkFault::Drop { .. }) => "drop",
            Self::Link(LinkFault::Delay { .. }) => "delay",
            Self::EmergencyStop => "emergency_stop",
            Self::DriveFault => "drive_fault",
            Self::None => "none",
        }
    }
}

/// Why a request was not carried out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RequestError {
    /// No JSON object, an unknown key, a value of the wrong kind.
    #[error("failed to read the request: {0}")]
    Malformed(String),
    /// None or several of the keys that say what to do.
    #[error("failed to tell what to do: give exactly one of set, get, rate_deg_per_s, fault, list")]
    NotOne,
    /// A key that belongs to another request.
    #[error("failed to read the request: \"{key}\" goes with {with} only")]
    Stray {
        /// The key.
        key: &'static str,
        /// Where it would have a meaning.
        with: &'static str,
    },
    /// A number that cannot be meant.
    #[error("failed to read the request: \"{key}\" is {value}, expected {expected}")]
    Number {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// Several devices, and none named.
    #[error("failed to choose a device: add \"device\", one of {there}")]
    WhichDevice {
        /// Those there are.
        there: String,
    },
    /// It is not emulated here.
    #[error("failed to find the {device}: emulated here: {there}")]
    NoDevice {
        /// The device asked for.
        device: Role,
        /// Those there are.
        there: String,
    },
    /// A parameter that does not exist, or a value that it may not take.
    #[error("failed to set {device}.{parameter}: {error}; {{\"list\":true}} names all")]
    Parameter {
        /// The device.
        device: Role,
        /// The name asked for.
        parameter: String,
        /// What is wrong.
        error: ParameterError,
    },
    /// The gyro is turned by what carries it.
    #[error("failed to turn the gyro: {0}")]
    NotTurned(&'static str),
    /// This device cannot fail in this way.
    #[error("failed to make the {device} fail by \"{fault}\": {why}; it can by {known}")]
    CannotFail {
        /// The device.
        device: Role,
        /// The fault asked for.
        fault: &'static str,
        /// Why not.
        why: &'static str,
        /// The faults that it knows.
        known: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    #[serde(rename = "id")]
    _id: Option<Value>,
    device: Option<Role>,
    set: Option<BTreeMap<String, f64>>,
    get: Option<Get>,
    rate_deg_per_s: Option<f64>,
    fault: Option<FaultName>,
    for_s: Option<f64>,
    share: Option<f64>,
    delay_s: Option<f64>,
    list: Option<bool>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum FaultName {
    Silent,
    Stuck,
    Drop,
    Delay,
    EmergencyStop,
    DriveFault,
    None,
}

/// Reads a line: the `id` that its answer carries, `null` where there is none to be read, and the
/// request.
pub fn read(line: &[u8]) -> (Value, Result<Request, RequestError>) {
    let (id, keys) = keys(line);
    (id, keys.and_then(of_keys).and_then(understand))
}

/// The `id` of a line, and all of its keys.
pub(super) fn keys(line: &[u8]) -> (Value, Result<Map<String, Value>, RequestError>) {
    let malformed = |error: String| (Value::Null, Err(RequestError::Malformed(error)));
    if line.len() > LINE_BYTES_MAX {
        return malformed(format!("it is longer than {LINE_BYTES_MAX} bytes"));
    }
    match serde_json::from_slice(line) {
        Ok(Value::Object(keys)) => (keys.get("id").cloned().unwrap_or_default(), Ok(keys)),
        // A list would be taken for the values of all keys in their order.
        Ok(_) => malformed("expected an object, such as {\"get\":\"truth\"}".to_owned()),
        Err(error) => malformed(error.to_string()),
    }
}

/// What these keys say.
pub(super) fn of_keys<T: DeserializeOwned>(keys: Map<String, Value>) -> Result<T, RequestError> {
    let read = serde_json::from_value(Value::Object(keys));
    read.map_err(|error| RequestError::Malformed(error.to_string()))
}

/// The answer to a request as a line, without its end.
pub fn answer(id: Value, result: Result<Value, impl fmt::Display>) -> String {
    match result {
        Ok(told) => json!({ "id": id, "ok": told }),
        Err(error) => json!({ "id": id, "error": error.to_string() }),
    }
    .to_string()
}

fn understand(keys: Keys) -> Result<Request, RequestError> {
    let said = [
        keys.set.is_some(),
        keys.get.is_some(),
        keys.rate_deg_per_s.is_some(),
        keys.fault.is_some(),
        keys.list.is_some(),
    ];
    if said.into_iter().filter(|said| *said).count() != 1 {
        return Err(RequestError::NotOne);
    }
    let stray = |key, with| Err(RequestError::Stray { key, with });
    if keys.for_s.is_some() && keys.fault.is_none() {
        return stray("for_s", "\"fault\"");
    }
    if keys.share.is_some() && keys.fault != Some(FaultName::Drop) {
        return stray("share", "\"fault\":\"drop\"");
    }
    if keys.delay_s.is_some() && keys.fault != Some(FaultName::Delay) {
        return stray("delay_s", "\"fault\":\"delay\"");
    }
    if keys.device.is_some() && keys.set.is_none() && keys.fault.is_none() {
        return stray("device", "\"set\" and \"fault\"");
    }
    if let Some(values) = keys.set {
        return Ok(Request::Set { device: keys.device, values });
    }
    if let Some(get) = keys.get {
        return Ok(Request::Get(get));
    }
    if let Some(value) = keys.rate_deg_per_s {
        if value.abs() > RATE_MAX_DEG_PER_S {
            let (key, expected) = ("rate_deg_per_s", "at most 1000 either way");
            return Err(RequestError::Number { key, value, expected });
        }
        return Ok(Request::Turn(value));
    }
    let Some(name) = keys.fault else { return Ok(Request::List) };
    let share = keys.share.unwrap_or(SHARE_USUAL);
    if !(share > 0.0 && share <= 1.0) {
        let expected = "more than 0 and at most 1";
        return Err(RequestError::Number { key: "share", value: share, expected });
    }
    let delay_s = keys.delay_s.unwrap_or(DELAY_USUAL_S);
    if !(delay_s > 0.0 && delay_s <= DELAY_MAX_S) {
        let expected = "more than 0 and at most 10";
        return Err(RequestError::Number { key: "delay_s", value: delay_s, expected });
    }
    if let Some(value) = keys.for_s.filter(|seconds| *seconds <= 0.0) {
        return Err(RequestError::Number { key: "for_s", value, expected: "more than 0" });
    }
    let fault = match name {
        FaultName::Silent => Fault::Link(LinkFault::Silent),
        FaultName::Stuck => Fault::Link(LinkFault::Stuck),
        FaultName::Drop => Fault::Link(LinkFault::Drop { share }),
        FaultName::Delay => Fault::Link(LinkFault::Delay { by: Span::from_secs_f64(delay_s) }),
        FaultName::EmergencyStop => Fault::EmergencyStop,
        FaultName::DriveFault => Fault::DriveFault,
        FaultName::None => Fault::None,
    };
    let duration = keys.for_s.map(Span::from_secs_f64);
    Ok(Request::Fault { device: keys.device, fault, duration })
}

#[cfg(test)]
mod tests {
    use super::{Request, answer, read};
    use proptest::prelude::*;
    use serde_json::{Value, json};

    #[test]
    fn requests_and_what_is_wrong_with_some() {
        let lines = [
            r#"{"id":1,"set":{"bias_deg_per_h":30}}"#,
            r#"{"id":"a","device":"base","set":{"leakage_deg_per_m":0.1,"wheels.0.toe_deg":1}}"#,
            r#"{"get":"truth"}"#,
            r#"{"get":"counters"}"#,
            r#"{"rate_deg_per_s":-10}"#,
            r#"{"fault":"drop","share":0.5,"for_s":2}"#,
            r#"{"fault":"delay","delay_s":0.5}"#,
            r#"{"fault":"emergency_stop","device":"base"}"#,
            r#"{"fault":"none"}"#,
            r#"{"list":true}"#,
            "",
            "[1]",
            r#"{"id":7}"#,
            r#"{"id":7,"get":"truth","list":true}"#,
            r#"{"id":7,"sett":{}}"#,
            r#"{"id":7,"get":"pose"}"#,
            r#"{"id":7,"fault":"smoke"}"#,
            r#"{"id":7,"device":"laser","set":{}}"#,
            r#"{"id":7,"set":{"bias_deg_per_h":"much"}}"#,
            r#"{"id":7,"get":"truth","for_s":1}"#,
            r#"{"id":7,"fault":"stuck","share":0.1}"#,
            r#"{"id":7,"device":"gyro","list":true}"#,
            r#"{"id":7,"fault":"drop","share":0}"#,
            r#"{"id":7,"fault":"delay","delay_s":11}"#,
            r#"{"id":7,"fault":"stuck","delay_s":1}"#,
            r#"{"id":7,"fault":"silent","for_s":-1}"#,
            r#"{"id":7,"rate_deg_per_s":1e4}"#,
            r#"{"id":7,"rate_deg_per_s":1e999}"#,
        ];
        let mut table = String::new();
        for line in lines {
            let (id, request) = read(line.as_bytes());
            let said = match request {
                Ok(request) => format!("{id} {request:?}"),
                Err(error) => answer(id, Err(error)),
            };
            table += &format!("{line}\n    {said}\n");
        }
        insta::assert_snapshot!(table);
    }

    #[test]
    fn an_answer_is_one_line() {
        let told = answer(json!("a\nb"), Ok::<_, String>(json!({ "x": 1 })));
        assert!(!told.contains('\n'), "{told}");
        let read: Value = serde_json::from_str(&told).unwrap();
        assert_eq!(read, json!({ "id": "a\nb", "ok": { "x": 1 } }));
    }

    proptest! {
        #[test]
        fn any_bytes_are_answered(line in prop::collection::vec(any::<u8>(), 0..200)) {
            let (id, request) = read(&line);
            if let Err(error) = request {
                let told = answer(id, Err(error));
                prop_assert!(serde_json::from_str::<Value>(&told).is_ok());
            }
        }

        #[test]
        fn a_set_is_read_as_it_stands(value in -1e9..1e9f64) {
            let line = json!({ "set": { "bias_deg_per_h": value } }).to_string();
            let (_, request) = read(line.as_bytes());
            let Ok(Request::Set { device: None, values }) = request else {
                return Err(TestCaseError::fail(format!("{request:?}")));
            };
            // To a unit in the last place: that is how exactly the JSON reader reads.
            let found = values.get("bias_deg_per_h").copied().unwrap_or(f64::NAN);
            prop_assert_eq!(values.len(), 1);
            prop_assert!((found - value).abs() <= f64::EPSILON * value.abs(), "{} {}", found, value);
        }
    }
}
