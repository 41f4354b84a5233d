//! A record as one line for a person: `hil show RUN`.
//!
//! Each record takes exactly one line. Control characters are escaped, so that no text of a device can move the cursor
//! of a terminal.

use super::header::Header;
use super::{Device, Observation, Record, RecordKind};
use controller::health::{Causes, Health};
use controller::mission::{Report, State};
use serde::Serialize;
use std::fmt::{self, Write as _};
use wire::can::{CanFrame, Id};
use wire::time::Timestamp;
use wire::units::Pose;

/// Width of a device's name. The width of an instant fits a hundred hours.
const DEVICE_WIDTH: usize = 10;
const SECONDS_WIDTH: usize = 16;

/// A record as a line without line end, and the header of its record: it names the source, and the line of traffic if the
/// rig has several.
#[derive(Debug, Clone, Copy)]
pub struct Line<'a>(pub &'a Record, pub &'a Header);

impl Device {
    /// Name in plans and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Controller => "controller",
            Self::Gyro => "gyro",
            Self::Base => "base",
            Self::Table => "table",
            Self::Absolute => "absolute",
            Self::Device => "device",
            // The header tells which node.
            Self::Node(_) => "node",
        }
    }
}

/// The start of a line: the time, and the name of the source.
#[derive(Debug, Clone, Copy)]
pub struct Head<'a>(pub Timestamp, pub &'a str);

impl fmt::Display for Head<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = Seconds(self.0.as_nanos()).to_string();
        write!(f, "{seconds:>SECONDS_WIDTH$} {:<DEVICE_WIDTH$} ", self.1)
    }
}

impl fmt::Display for Line<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Record { at, device, kind }, header) = *self;
        Head(*at, header.name_of(*device)).fmt(f)?;
        match kind {
            RecordKind::Bytes(bytes) => {
                write!(f, "bytes")?;
                bytes.iter().try_for_each(|byte| write!(f, " {byte:02x}"))?;
                write_line(f, header, *device)
            }
            RecordKind::Frame(frame) => {
                write_frame(f, frame)?;
                write_line(f, header, *device)
            }
            RecordKind::StepBegan { path, title } => {
                write!(f, "begin {}: {}", OneLine(path), OneLine(title))
            }
            RecordKind::StepEnded { path } => write!(f, "end {}", OneLine(path)),
            RecordKind::Command(command) => write_json(f, "command", command),
            RecordKind::Report(Report::State(state)) => write_state(f, state),
            RecordKind::Report(Report::Health(health)) => write_health(f, health),
            RecordKind::Report(report) => write_json(f, "report", report),
            RecordKind::Observation(observation) => write_observation(f, observation),
            RecordKind::Truth { pose, bias_rad_per_s, coil_celsius } => {
                write!(f, "truth {}, ", Readable(*pose))?;
                let bias = wire::units::AngularRate::from_rad_per_s(*bias_rad_per_s).deg_per_h();
                write!(f, "bias {bias:.3} deg/h, coil {coil_celsius:.2} degC")
            }
            RecordKind::Note(text) => write!(f, "note {}", OneLine(text)),
            RecordKind::Reply(reply) => write!(f, "reply {reply}"),
            RecordKind::Fault(fault) => write!(f, "{fault}"),
        }
    }
}

/// A text in which characters that start another line or control a terminal are escaped.
#[derive(Debug, Clone, Copy)]
pub struct OneLine<'a>(pub &'a str);

impl fmt::Display for OneLine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|character| match character {
            // These are more readable unescaped.
            '"' | '\'' | '\\' => f.write_char(character),
            other => write!(f, "{}", other.escape_debug()),
        })
    }
}

/// Seconds with all nine decimals: two records differ here if and only if their times differ.
struct Seconds(i64);

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const NANOS: u64 = 1_000_000_000;
        let sign = if self.0 < 0 { "-" } else { "" };
        let nanos = self.0.unsigned_abs();
        write!(f, "{sign}{}.{:09}", nanos / NANOS, nanos % NANOS)
    }
}

/// A pose in metres and degrees.
struct Readable(Pose);

impl fmt::Display for Readable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Pose { x, y, heading } = self.0;
        write!(f, "at {:.4} {:.4} m, heading {:.3} deg", x.m(), y.m(), heading.deg())
    }
}

/// A single frame, for a message.
pub struct ShownFrame(pub CanFrame);

impl fmt::Display for ShownFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_frame(f, &self.0)
    }
}

/// Where traffic was, if the rig has several lines.
fn write_line(f: &mut fmt::Formatter<'_>, header: &Header, device: Device) -> fmt::Result {
    let mut lines = header.nodes.iter().map(|node| &node.line);
    let first = lines.next();
    let is_any_other = lines.any(|line| Some(line) != first);
    match header.line_of(device).filter(|_| is_any_other) {
        Some(line) => write!(f, " on {line}"),
        None => Ok(()),
    }
}

/// In the format of `candump`: identifier, `#`, data; for CAN FD `##`, flags and data.
fn write_frame(f: &mut fmt::Formatter<'_>, frame: &CanFrame) -> fmt::Result {
    write_identifier(f, frame)?;
    if let Some(flags) = frame.fd_flags() {
        write!(f, "#{:X}", flags.bits())?;
    }
    if frame.is_remote() {
        return write!(f, "R");
    }
    frame.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
}

fn write_identifier(f: &mut fmt::Formatter<'_>, frame: &CanFrame) -> fmt::Result {
    match frame.id() {
        Id::Standard(id) => write!(f, "frame {:03X}#", id.as_raw()),
        Id::Extended(id) => write!(f, "frame {:08X}#", id.as_raw()),
    }
}

/// Commands and reports as in a line of the controller process.
fn write_json(f: &mut fmt::Formatter<'_>, word: &str, value: &impl Serialize) -> fmt::Result {
    match serde_json::to_string(value) {
        Ok(json) => write!(f, "{word} {json}"),
        Err(error) => write!(f, "{word} cannot be shown: {error}"),
    }
}

fn write_state(f: &mut fmt::Formatter<'_>, state: &State) -> fmt::Result {
    write!(f, "state {} {}", name_of(&state.activity), Readable(state.pose))?;
    write!(f, ", gyro {:.3} deg", state.gyro_heading.deg())?;
    write!(f, ", odometry {:.3} deg", state.odometry_heading.deg())?;
    write!(f, ", raw {:.4} deg/s", state.raw_rate.deg_per_s())?;
    write!(f, ", bias {:.3} deg/h", state.bias.deg_per_h())?;
    if let Some(temperature) = state.temperature {
        write!(f, ", {:.2} degC", temperature.celsius())?;
    }
    write!(f, ", {} samples", state.samples)?;
    if state.samples_lost > 0 {
        write!(f, " ({} lost)", state.samples_lost)?;
    }
    write!(f, ", {}", name_of(&state.health.level))?;
    if state.moving { write!(f, ", moving") } else { Ok(()) }
}

fn write_health(f: &mut fmt::Formatter<'_>, health: &Health) -> fmt::Result {
    write!(f, "health {}", name_of(&health.level))?;
    cause_names(&health.causes).iter().try_for_each(|cause| write!(f, " {cause}"))
}

/// The names of the causes that are set.
pub fn cause_names(causes: &Causes) -> Vec<String> {
    match serde_json::to_value(causes) {
        Ok(serde_json::Value::Object(all)) => {
            all.into_iter().filter(|(_, set)| set == true).map(|(name, _)| name).collect()
        }
        _ => Vec::new(),
    }
}

/// The name under which a unit variant is serialised.
pub fn name_of(value: &impl Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    }
}

fn write_observation(f: &mut fmt::Formatter<'_>, observation: &Observation) -> fmt::Result {
    let Observation { quantity, value, uncertainty, tags } = observation;
    write!(f, "observation {} {value}", OneLine(quantity))?;
    if *uncertainty != 0.0 {
        write!(f, " +- {uncertainty}")?;
    }
    tags.iter().try_for_each(|(tag, value)| write!(f, " {}={value}", OneLine(tag)))
}

#[cfg(test)]
mod tests {
    use super::{Header, Line};
    use crate::samples::one_of_each;
    use controller::health::{Causes, Health};

    #[test]
    fn the_documentation_has_each_cause_and_its_level() {
        const PAGE: &str = include_str!("../../../docs/robot-controllers.md");
        let told: Vec<(&str, &str)> = (PAGE.lines())
            .filter_map(|line| line.strip_prefix("| `")?.split_once("` | "))
            .filter_map(|(cause, rest)| Some((cause, rest.split_once(" | ")?.0)))
            .filter(|(_, level)| ["fault", "degraded"].contains(level))
            .collect();
        let serde_json::Value::Object(all) = serde_json::to_value(Causes::default()).unwrap()
        else {
            panic!("causes are an object");
        };
        let expected = all.keys().map(|cause| {
            let causes = serde_json::json!({ cause: true });
            let causes: Causes = serde_json::from_value(causes).unwrap();
            (cause.clone(), super::name_of(&Health::new(false, causes).level))
        });
        let mut expected: Vec<_> = expected.collect();
        let mut told: Vec<_> = told.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect();
        expected.sort();
        told.sort();
        assert_eq!(told, expected);
    }

    #[test]
    fn each_kind_has_its_line() {
        let lines: Vec<_> = one_of_each()
            .iter()
            .map(|record| Line(record, &Header::default()).to_string())
            .collect();
        insta::assert_snapshot!(lines.join("\n"));
    }

    #[test]
    fn a_record_is_one_line_whatever_it_holds() {
        use crate::{Device, Record, RecordKind};
        let kind = RecordKind::Note("two\nlines\u{1b}[2J".into());
        let record = Record { at: wire::time::Timestamp::ZERO, device: Device::Base, kind };
        let line = Line(&record, &Header::default()).to_string();
        assert!(line.ends_with(r"note two\nlines\u{1b}[2J"), "{line}");
        let said = r#"the controller said: {"state":"a\\b"}"#;
        let quoted = Record { kind: RecordKind::Note(said.into()), ..record };
        let line = Line(&quoted, &Header::default()).to_string();
        assert!(line.ends_with(said), "as it was said: {line}");
    }
}
