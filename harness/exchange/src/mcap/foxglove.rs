//! Messages that Foxglove knows by name, with the fields that it publishes as required
//! (<https://docs.foxglove.dev/docs/sdk/schemas>, JSON; sources: `foxglove/foxglove-sdk`, `schemas/jsonschema`).
//!
//! The two optional fields of 2026, `message_id` and `lineage`, are left out: there is no content for them.

use super::schema::Schema;
use serde::Serialize;
use serde_json::{Value, json};
use wire::time::Timestamp;
use wire::units::{Angle, Pose};

/// Frame of the plan's coordinates.
pub const BENCH: &str = "bench";
/// Frame of the base as estimated by the controller.
pub const BASE: &str = "base";
/// True frame of the base, from an emulator.
pub const TRUE_BASE: &str = "base_true";
/// Frame of the base as estimated at the start of the lap.
pub const LAP_START: &str = "lap_start";

const NANOS: i64 = 1_000_000_000;

/// `time`: seconds and nanoseconds since the epoch, which is the start of the run.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Time {
    sec: i64,
    nsec: i64,
}

impl From<Timestamp> for Time {
    fn from(at: Timestamp) -> Self {
        let nanos = at.as_nanos().max(0);
        Self { sec: nanos / NANOS, nsec: nanos % NANOS }
    }
}

#[derive(Debug, Clone, Copy, Serialize)]
struct Vector3 {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Debug, Clone, Copy, Serialize)]
struct Quaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

/// `foxglove.Pose`: position in m, and a rotation about z, which points up.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Pose3 {
    position: Vector3,
    orientation: Quaternion,
}

impl From<Pose> for Pose3 {
    fn from(pose: Pose) -> Self {
        let half = Angle::from_rad(pose.heading.rad() / 2.0);
        Self {
            position: Vector3 { x: pose.x.m(), y: pose.y.m(), z: 0.0 },
            orientation: Quaternion { x: 0.0, y: 0.0, z: half.sin(), w: half.cos() },
        }
    }
}

/// `foxglove.PoseInFrame`.
#[derive(Debug, Clone, Serialize)]
pub struct PoseInFrame {
    pub timestamp: Time,
    pub frame_id: &'static str,
    pub pose: Pose3,
}

/// `foxglove.PosesInFrame`.
#[derive(Debug, Clone, Serialize)]
pub struct PosesInFrame {
    pub timestamp: Time,
    pub frame_id: &'static str,
    pub poses: Vec<Pose3>,
}

/// `foxglove.FrameTransform`.
#[derive(Debug, Clone, Serialize)]
pub struct FrameTransform {
    timestamp: Time,
    parent_frame_id: &'static str,
    child_frame_id: &'static str,
    translation: Vector3,
    rotation: Quaternion,
}

impl FrameTransform {
    /// A transform from the bench's frame to the frame `child`, which is at `pose`.
    pub fn of(child: &'static str, at: Timestamp, pose: Pose) -> Self {
        let Pose3 { position, orientation } = pose.into();
        Self {
            timestamp: at.into(),
            parent_frame_id: BENCH,
            child_frame_id: child,
            translation: position,
            rotation: orientation,
        }
    }
}

/// `foxglove.Log`.
#[derive(Debug, Clone, Serialize)]
pub struct Log<'a> {
    pub timestamp: Time,
    pub level: LogLevel,
    pub message: &'a str,
    pub name: &'a str,
    /// Source file: always empty.
    pub file: &'a str,
    /// Source line: always zero.
    pub line: u32,
}

/// The used part of `foxglove.LogLevel`, written as its number.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(into = "u8")]
pub enum LogLevel {
    Info,
    Warning,
    Error,
}

impl From<LogLevel> for u8 {
    fn from(level: LogLevel) -> Self {
        match level {
            LogLevel::Info => 2,
            LogLevel::Warning => 3,
            LogLevel::Error => 4,
        }
    }
}

fn time(description: &str) -> Value {
    json!({
        "type": "object",
        "title": "time",
        "properties": {
            "sec": { "type": "integer", "minimum": 0 },
            "nsec": { "type": "integer", "minimum": 0, "maximum": 999_999_999 },
        },
        "description": description,
    })
}

fn numbers(title: &str, description: &str, names: &[&str]) -> Value {
    let number = |name: &&str| ((*name).to_owned(), json!({ "type": "number" }));
    let properties: serde_json::Map<String, Value> = names.iter().map(number).collect();
    json!({
        "title": title,
        "description": description,
        "type": "object",
        "properties": properties,
        "required": names,
    })
}

fn vector3(description: &str) -> Value {
    numbers("foxglove.Vector3", description, &["x", "y", "z"])
}

fn quaternion(description: &str) -> Value {
    numbers("foxglove.Quaternion", description, &["x", "y", "z", "w"])
}

fn pose(description: &str) -> Value {
    json!({
        "title": "foxglove.Pose",
        "description": description,
        "type": "object",
        "properties": {
            "position": vector3("position, m"),
            "orientation": quaternion("orientation"),
        },
        "required": ["position", "orientation"],
    })
}

fn text(description: &str) -> Value {
    json!({ "type": "string", "description": description })
}

fn schema(name: &str, description: &str, properties: &Value) -> Schema {
    // A map loses the published order of the fields; all of them are required.
    let required: Vec<&String> =
        properties.as_object().into_iter().flatten().map(|(key, _)| key).collect();
    let text = json!({
        "title": name,
        "description": description,
        "type": "object",
        "properties": properties,
        "required": required,
    });
    Schema { name: name.to_owned(), text }
}

/// Schema of [`PoseInFrame`].
pub fn pose_in_frame() -> Schema {
    let properties = json!({
        "timestamp": time("bench time of the pose"),
        "frame_id": text("frame of the pose"),
        "pose": pose("the pose"),
    });
    schema("foxglove.PoseInFrame", "A pose at a time", &properties)
}

/// Schema of [`PosesInFrame`].
pub fn poses_in_frame() -> Schema {
    let properties = json!({
        "timestamp": time("bench time of the last pose"),
        "frame_id": text("frame of the poses"),
        "poses": { "type": "array", "items": pose("a pose"), "description": "the poses in order" },
    });
    schema("foxglove.PosesInFrame", "A path", &properties)
}

/// Schema of [`FrameTransform`].
pub fn frame_transform() -> Schema {
    let properties = json!({
        "timestamp": time("bench time of the transform"),
        "parent_frame_id": text("name of the parent frame"),
        "child_frame_id": text("name of the child frame"),
        "translation": vector3("origin of the child in the parent, m"),
        "rotation": quaternion("orientation of the child in the parent"),
    });
    schema("foxglove.FrameTransform", "Where a frame is", &properties)
}

/// Schema of [`Log`].
pub fn log() -> Schema {
    let levels = ["UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL"];
    let level = |(number, title): (usize, &&str)| json!({ "title": title, "const": number });
    let properties = json!({
        "timestamp": time("bench time of the message"),
        "level": {
            "title": "foxglove.LogLevel",
            "description": "how loud",
            "oneOf": levels.iter().enumerate().map(level).collect::<Vec<_>>(),
        },
        "message": text("what a person reads"),
        "name": text("whose it is"),
        "file": text("empty"),
        "line": { "type": "integer", "minimum": 0, "description": "zero" },
    });
    schema("foxglove.Log", "A line of a log", &properties)
}
