//! The tables and their columns.

use super::cell::Kind::{Bool, Float, Integer, Text};
use super::cell::{Column, Kind};
use super::survey::Survey;
use plan::quantities::find_tag;
use std::collections::BTreeSet;

const fn column(name: &'static str, kind: Kind, unit: &'static str, doc: &'static str) -> Column {
    Column::new(name, kind, unit, doc)
}

const TIME: Column = column("time_s", Float, "s", "bench time since the run began");
const DEVICE: Column = column("device", Text, "", "whose it is");
const LINE: Column =
    column("line", Text, "", "the line that it was sent on; missing for lines of the robot");

static STATES: [Column; 20] = [
    TIME,
    column("activity", Text, "", "what the controller is doing"),
    column("moving", Bool, "", "the base is not known to be at rest"),
    column("x_m", Float, "m", "dead-reckoned position, x"),
    column("y_m", Float, "m", "dead-reckoned position, y"),
    column("heading_deg", Float, "deg", "heading by the heading source"),
    column("gyro_heading_deg", Float, "deg", "heading by the corrected gyro, not wrapped"),
    column("odometry_heading_deg", Float, "deg", "heading by the base's odometry, not wrapped"),
    column("displacement_m", Float, "m", "path length by the base"),
    column("heading_error_deg", Float, "deg", "reference minus heading, on a straight line"),
    column(
        "raw_rate_deg_per_s",
        Float,
        "deg/s",
        "mean of the gyro's raw readings since the row before",
    ),
    column("bias_deg_per_h", Float, "deg/h", "bias in force"),
    column("temperature_celsius", Float, "degC", "temperature that the gyro told"),
    column("samples", Integer, "", "gyro samples used since start"),
    column("samples_lost", Integer, "", "gyro samples known to be lost since start"),
    column("clock_ratio", Float, "", "gyro samples per host second over nominal"),
    column("health", Text, "", "starting, ok, degraded or fault"),
    column(
        "heading_uncertainty_deg",
        Float,
        "deg",
        "standard uncertainty by the estimator, if it states one",
    ),
    column("x_uncertainty_m", Float, "m", "the same of x_m"),
    column("y_uncertainty_m", Float, "m", "the same of y_m"),
];

static TRUTH: [Column; 6] = [
    TIME,
    column("x_m", Float, "m", "true position, x"),
    column("y_m", Float, "m", "true position, y"),
    column("heading_deg", Float, "deg", "true heading"),
    column("bias_deg_per_h", Float, "deg/h", "true bias of the gyro"),
    column("coil_celsius", Float, "degC", "true temperature of the gyro's coil"),
];

static HEALTH: [Column; 3] = [
    TIME,
    column("level", Text, "", "starting, ok, degraded or fault"),
    column("causes", Text, "", "names of the causes that are set, with a space between"),
];

static OBSERVATIONS: [Column; 5] = [
    TIME,
    column("quantity", Text, "", "what was observed"),
    column("value", Float, "", "its value, in the unit of the row"),
    column("uncertainty", Float, "", "its standard uncertainty, in the unit of the row"),
    column("unit", Text, "", "unit of value and uncertainty"),
];

static EVENTS: [Column; 7] = [
    TIME,
    DEVICE,
    column("event", Text, "", "step_began, done, fault_began, note, ..."),
    column(
        "subject",
        Text,
        "",
        "what it is about: a place in the plan, a command, a reason, a fault",
    ),
    column("id", Integer, "", "which mission, or which fault of the schedule"),
    column("text", Text, "", "the event in words"),
    column("details_json", Text, "", "what else is known, as JSON"),
];

static MEASUREMENTS: [Column; 11] = [
    TIME,
    column("name", Text, "", "name in the plan"),
    column("value", Float, "", "the figure that was judged, in the unit of the row"),
    column("uncertainty", Float, "", "its standard uncertainty"),
    column("unit", Text, "", "unit of value, uncertainty, lower, upper and margin"),
    column("lower", Float, "", "lower end of the band; missing where there is none"),
    column("upper", Float, "", "upper end of the band; missing where there is none"),
    column("margin", Float, "", "distance to the nearer end of the band, negative outside it"),
    column("verdict", Text, "", "pass, marginal, fail, unset or not_judged"),
    column("paper", Text, "", "what the paper gives, with its place"),
    column("statistic", Text, "", "what the figure is"),
];

static FRAMES: [Column; 9] = [
    TIME,
    column("device", Text, "", "who put it on the bus"),
    column("id", Integer, "", "identifier"),
    column("extended", Bool, "", "the identifier has 29 bits"),
    column("remote", Bool, "", "a remote request"),
    column("fd", Bool, "", "a CAN FD frame"),
    column("dlc", Integer, "", "data length code: data bytes of a classic data frame"),
    column("data_hex", Text, "", "data bytes, two hexadecimal digits each"),
    LINE,
];

static PACKETS: [Column; 5] = [
    TIME,
    column("device", Text, "", "who put it on its line"),
    column("bytes", Integer, "", "how many bytes came together"),
    column("data_hex", Text, "", "the bytes, two hexadecimal digits each"),
    LINE,
];

static SIGNALS: [Column; 7] = [
    TIME,
    column("device", Text, "", "who sent the message"),
    column("message", Text, "", "name of the message in its layout"),
    column("signal", Text, "", "name of the signal"),
    column("value", Float, "", "its value, in the unit of the row"),
    column("unit", Text, "", "unit of the value"),
    LINE,
];

/// Name of a table, name of its schema, what it holds, and its columns.
type Form = (&'static str, &'static str, &'static str, &'static [Column]);

wire::tabled! {
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Table {
        States = ("states", "hil.State", "one row a state that the controller told", &STATES),
        Truth =
            ("truth", "hil.Truth", "one row a time when an emulator told what is really so", &TRUTH),
        Health = ("health", "hil.Health", "one row a change of the controller's health", &HEALTH),
        Observations = (
            "observations",
            "hil.Observation",
            "one row an observation; its tags are columns",
            &OBSERVATIONS,
        ),
        Events = (
            "events",
            "hil.Event",
            "one row an event: steps, missions and their ends, faults, notes, replies",
            &EVENTS,
        ),
        Measurements = (
            "measurements",
            "hil.Measurement",
            "one row a measurement that the plan declares, with its verdict",
            &MEASUREMENTS,
        ),
        /// Only for a run with `--record full`, as the two below.
        Frames = ("frames", "hil.Frame", "one row a CAN frame", &FRAMES),
        Packets = ("packets", "hil.Packet", "one row a packet of a serial line", &PACKETS),
        Signals =
            ("signals", "hil.Signal", "one row a signal of a message that was understood", &SIGNALS),
    }
    fn form() -> Form
}

impl Table {
    /// Its name, which is also that of its file.
    pub fn name(self) -> &'static str {
        self.form().0
    }

    pub(crate) fn schema_name(self) -> &'static str {
        self.form().1
    }

    pub fn doc(self) -> &'static str {
        self.form().2
    }

    /// Columns that do not depend on the run. Observations have the columns of their tags after these.
    pub fn fixed_columns(self) -> &'static [Column] {
        self.form().3
    }

    pub fn columns(self, survey: &Survey) -> Vec<Column> {
        let fixed = self.fixed_columns();
        match self {
            Self::Observations => tagged(fixed.to_vec(), &survey.tags()),
            _ => fixed.to_vec(),
        }
    }
}

/// `columns`, followed by one per tag. A tag whose name is taken gets the prefix `tag_`, repeated until it is unique.
pub fn tagged(mut columns: Vec<Column>, tags: &[&str]) -> Vec<Column> {
    // Readers of CSV and SQL engines ignore case in names.
    let mut taken: BTreeSet<String> =
        columns.iter().map(|column| column.name.to_lowercase()).collect();
    for tag in tags {
        let (unit, doc) =
            find_tag(tag).map_or(("", "tag of the observation"), |known| (known.unit, known.doc));
        let mut column = Column::measured(tag, unit, format!("{doc} ({tag})"));
        while !taken.insert(column.name.to_lowercase()) {
            column.name = format!("tag_{}", column.name).into();
        }
        columns.push(column);
    }
    columns
}
