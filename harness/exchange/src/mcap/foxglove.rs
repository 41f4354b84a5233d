//! The messages that Foxglove knows by name, with the fields that it publishes as required
//! (<https://docs.foxglove.dev/docs/sdk/schemas>, JSON; sources: `foxglove/foxglove-sdk`, `schemas/jsonschema`).
//!
//! The two optional fields of 2026, `message_id` and `lineage`, are left out: there is nothing to say in them.

use super::schema::Schema;
use serde::Serialize;
use serde_json::{Value, json};
use wire::time::Timestamp;
use wire::units::{Angle, Pose};

/// Where the plan's coordinates are from.
pub const BENCH: &str = "bench";
/// The base, where the controller believes it to be.
pub const BASE: &str = "base";
/// The base, where an emulator knows it to be.
pub const TRUE_BASE: &str = "base_true";
/// Where the controller believed the base to be when the lap began.
pub const LAP_START: &str = "lap_start";

const NANOS: i64 = 1_000_000_000;

/// `time`: seconds and nanoseconds since the epoch, which is the begin of the run.
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

/// `foxglove.Pose`: m, and a rotation about z, which is up.
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
    /// When.
    pub timestamp: Time,
    /// In which frame.
    pub frame_id: &'static str,
    /// Where.
    pub pose: Pose3,
}

/// `foxglove.PosesInFrame`.
#[derive(Debug, Clone, Serialize)]
pub struct PosesInFrame {
    /// When.
    pub timestamp: Time,
    /// In which frame.
    pub frame_id: &'static str,
    /// Where, one after another.
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
    /// The frame `child` is there, in the bench's frame.
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
    /// When.
    pub timestamp: Time,
    /// How loud.
    pub level: LogLevel,
    /// What a person reads.
    pub message: &'a str,
    /// Whose it is.
    pub name: &'a str,
    /// Not of a file: empty.
    pub file: &'a str,
    /// Not of a file: zero.
    pub line: u32,
}

/// `foxglove.LogLevel`, as far as it is used; written as its number.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(into = "u8")]
pub enum LogLevel {
    /// All is well.
    Info,
    /// Worth a look.
    Warning,
    /// It failed.
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
    // The published order of the fields is lost in a map; every one of them is required.
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

/// Of [`PoseInFrame`].
pub fn pose_in_frame() -> Schema {
    let properties = json!({
        "timestamp": time("bench time of the pose"),
        "frame_id": text("frame of the pose"),
        "pose": pose("the pose"),
    });
    schema("foxglove.PoseInFrame", "A pose at a time", &properties)
}

/// Of [`PosesInFrame`].
pub fn poses_in_frame() -> Schema {
    let properties = json!({
        "timestamp": time("bench time of the last pose"),
        "frame_id": text("frame of the poses"),
        "poses": { "type": "array", "items": pose("a pose"), "description": "the poses in order" },
    });
    schema("foxglove.PosesInFrame", "A path", &properties)
}

/// Of [`FrameTransform`].
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

/// Of [`Log`].
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
