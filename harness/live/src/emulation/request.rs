//! Requests to emulated devices, a JSON line each. `docs/emulators.md` has every key.

use plan::faults::{FaultKind, Toward};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::fmt;
use wire::time::Span;

/// Longest request line: room for dozens of parameters.
pub const LINE_BYTES_MAX: usize = 16 * 1_024;
/// Largest turn rate of a lone gyro, deg/s. Assumption: beyond the range of all gyros.
pub const RATE_MAX_DEG_PER_S: f64 = 1_000.0;

#[derive(Debug, Clone, PartialEq)]
pub enum Request {
    /// Set parameters of a device by name: all or none of them.
    Set {
        /// The device; required if there are several.
        device: Option<String>,
        values: BTreeMap<String, f64>,
    },
    /// Query something, of this device if it concerns one.
    Get(Option<String>, Get),
    /// Turn a gyro without a carrier, counter-clockwise positive, in deg/s.
    Turn(f64),
    Power {
        /// The device; required if there are several.
        device: Option<String>,
        on: bool,
    },
    Fault {
        /// The device or line; required if there are several devices.
        device: Option<String>,
        fault: Fault,
    },
    NoFault,
    List,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Get {
    Truth,
    Counters,
    /// States, signals and parameters of a described device; all parameters if the list is empty.
    Values(Vec<String>),
}

/// A fault, as in a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    pub kind: FaultKind,
    pub toward: Toward,
    /// Duration; until ended by a request if absent.
    pub duration: Option<Span>,
}

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RequestError {
    /// Not a JSON object, or an unknown key, or a value of the wrong type.
    #[error("failed to read the request: {0}")]
    Malformed(String),
    /// None or several of the keys that select the request.
    #[error(
        "failed to tell what to do: give exactly one of set, get, rate_deg_per_s, power, fault, no_fault, list"
    )]
    NotOne,
    /// A key that belongs to another request.
    #[error("failed to read the request: \"{key}\" goes with {with} only")]
    Stray {
        key: &'static str,
        /// The request to which it belongs.
        with: &'static str,
    },
    /// A number out of its domain.
    #[error("failed to read the request: \"{key}\" is {value}, expected {expected}")]
    Number { key: &'static str, value: f64, expected: &'static str },
    #[error("failed to choose a device: add \"device\", one of {there}")]
    WhichDevice { there: String },
    #[error("failed to find the {device}: emulated here: {there}")]
    NoDevice { device: String, there: String },
    #[error("{0}")]
    Refused(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    #[serde(rename = "id")]
    _id: Option<Value>,
    device: Option<String>,
    set: Option<BTreeMap<String, f64>>,
    get: Option<Value>,
    rate_deg_per_s: Option<f64>,
    power: Option<bool>,
    fault: Option<Value>,
    toward: Option<Toward>,
    duration_s: Option<f64>,
    no_fault: Option<IgnoredAny>,
    list: Option<bool>,
}

/// Reads a line: the `id` for its answer, `null` if it cannot be read, and the request.
pub fn read(line: &[u8]) -> (Value, Result<Request, RequestError>) {
    let (id, keys) = keys(line);
    let request = keys.and_then(|keys| {
        let read = serde_json::from_value(Value::Object(keys));
        understand(read.map_err(|error| RequestError::Malformed(error.to_string()))?)
    });
    (id, request)
}

/// The `id` of a line, and all of its keys.
fn keys(line: &[u8]) -> (Value, Result<Map<String, Value>, RequestError>) {
    let malformed = |error: String| (Value::Null, Err(RequestError::Malformed(error)));
    if line.len() > LINE_BYTES_MAX {
        return malformed(format!("it is longer than {LINE_BYTES_MAX} bytes"));
    }
    match serde_json::from_slice(line) {
        Ok(Value::Object(keys)) => (keys.get("id").cloned().unwrap_or_default(), Ok(keys)),
        // A list would be taken for the values of all keys in order.
        Ok(_) => malformed("expected an object, such as {\"get\":\"truth\"}".to_owned()),
        Err(error) => malformed(error.to_string()),
    }
}

/// The answer to a request as a line, without line ending.
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
        keys.power.is_some(),
        keys.fault.is_some(),
        keys.no_fault.is_some(),
        keys.list.is_some(),
    ];
    if said.into_iter().filter(|said| *said).count() != 1 {
        return Err(RequestError::NotOne);
    }
    let stray = |key, with| Err(RequestError::Stray { key, with });
    if keys.duration_s.is_some() && keys.fault.is_none() {
        return stray("duration_s", "\"fault\"");
    }
    if keys.toward.is_some() && keys.fault.is_none() {
        return stray("toward", "\"fault\"");
    }
    let of_all = keys.rate_deg_per_s.is_some() || keys.no_fault.is_some() || keys.list.is_some();
    if keys.device.is_some() && of_all {
        return stray("device", "\"set\", \"get\", \"power\" and \"fault\"");
    }
    let device = keys.device;
    if let Some(values) = keys.set {
        return Ok(Request::Set { device, values });
    }
    if let Some(get) = keys.get {
        return Ok(Request::Get(device, what_to_tell(get)?));
    }
    if let Some(on) = keys.power {
        return Ok(Request::Power { device, on });
    }
    if let Some(value) = keys.rate_deg_per_s {
        if value.abs() > RATE_MAX_DEG_PER_S {
            let (key, expected) = ("rate_deg_per_s", "at most 1000 either way");
            return Err(RequestError::Number { key, value, expected });
        }
        return Ok(Request::Turn(value));
    }
    let Some(fault) = keys.fault else {
        return Ok(if keys.no_fault.is_some() { Request::NoFault } else { Request::List });
    };
    let kind = match fault {
        Value::String(name) => FaultKind::named(&name)
            .map_err(|unknown| RequestError::Malformed(format!("{unknown}; {}", unknown.help)))?,
        table => serde_json::from_value(table)
            .map_err(|error| RequestError::Malformed(error.to_string()))?,
    };
    if let Some(value) = keys.duration_s.filter(|seconds| *seconds <= 0.0) {
        return Err(RequestError::Number { key: "duration_s", value, expected: "more than 0" });
    }
    let duration = keys.duration_s.map(Span::from_secs_f64);
    let fault = Fault { kind, toward: keys.toward.unwrap_or_default(), duration };
    Ok(Request::Fault { device, fault })
}

fn what_to_tell(get: Value) -> Result<Get, RequestError> {
    match get.as_str() {
        Some("truth") => Ok(Get::Truth),
        Some("counters") => Ok(Get::Counters),
        _ => serde_json::from_value(get).map(Get::Values).map_err(|_| {
            let expected = "expected \"truth\", \"counters\" or a list of names";
            RequestError::Malformed(format!("\"get\": {expected}"))
        }),
    }
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
            r#"{"fault":"drop","duration_s":2}"#,
            r#"{"fault":{"delay":{"by_s":0.5}},"toward":"host","device":"can0"}"#,
            r#"{"fault":"emergency_stop","device":"base"}"#,
            r#"{"no_fault":{}}"#,
            r#"{"power":false,"device":"oven"}"#,
            r#"{"get":["temperature"]}"#,
            r#"{"list":true}"#,
            "",
            "[1]",
            r#"{"id":7}"#,
            r#"{"id":7,"get":"truth","list":true}"#,
            r#"{"id":7,"sett":{}}"#,
            r#"{"id":7,"get":"pose"}"#,
            r#"{"id":7,"fault":"smoke"}"#,
            r#"{"id":7,"device":1,"set":{}}"#,
            r#"{"id":7,"set":{"bias_deg_per_h":"much"}}"#,
            r#"{"id":7,"get":"truth","duration_s":1}"#,
            r#"{"id":7,"fault":{"drop":{"share":0.1}}}"#,
            r#"{"id":7,"device":"gyro","list":true}"#,
            r#"{"id":7,"list":true,"toward":"host"}"#,
            r#"{"id":7,"fault":"drop","duration_s":-1}"#,
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
            // To a unit in the last place, which is the precision of the JSON reader.
            let found = values.get("bias_deg_per_h").copied().unwrap_or(f64::NAN);
            prop_assert_eq!(values.len(), 1);
            prop_assert!((found - value).abs() <= f64::EPSILON * value.abs(), "{} {}", found, value);
        }
    }
}
