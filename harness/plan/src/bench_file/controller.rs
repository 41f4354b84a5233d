//! The device under test of a bench.

use super::attach::AttachPlace;
use super::command;
use super::role::Yes;
use schemars::JsonSchema;
use serde::Deserialize;

/// The kind of device under test.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(try_from = "Controller")]
pub enum ControllerSection {
    /// `in_process = true`: the built-in controller, in the process of the harness.
    InProcess,
    /// `command = [...]`: a program that the harness starts; `{gyro}` and `{base}` stand for the ports.
    Command(Vec<String>),
    /// `attach = "unix:/path.sock"`: a controller that is already running or started by hand, and takes its missions at
    /// this place.
    Attach(AttachPlace),
}

/// The device under test: one of `in_process`, `command` and `attach`.
#[derive(Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a device under test: `in_process = true`, `command = [...]` or `attach = \"...\"`"
)]
#[schemars(extend("minProperties" = 1, "maxProperties" = 1))]
pub(super) struct Controller {
    /// The controller that the harness brings along.
    #[schemars(extend("const" = true), with = "Option<bool>")]
    in_process: Option<Yes>,
    /// A program that the harness starts; `{gyro}` and `{base}` stand for the ports.
    #[serde(default, deserialize_with = "command::given_words")]
    #[schemars(length(min = 1))]
    command: Option<Vec<String>>,
    /// Where one that runs already takes its missions: `unix:PATH`, `tcp:HOST:PORT` or a serial port.
    #[schemars(with = "Option<String>")]
    attach: Option<AttachPlace>,
}

impl TryFrom<Controller> for ControllerSection {
    type Error = String;

    fn try_from(written: Controller) -> Result<Self, String> {
        let Controller { in_process, command, attach } = written;
        let found = match (in_process, command, attach) {
            (Some(Yes), None, None) => return Ok(Self::InProcess),
            (None, Some(words), None) => return Ok(Self::Command(words)),
            (None, None, Some(place)) => return Ok(Self::Attach(place)),
            (None, None, None) => "no device under test",
            _ => "several devices under test",
        };
        Err(format!(
            "{found}, expected `in_process = true`, `command = [...]` or `attach = \"...\"`"
        ))
    }
}
