//! The header of a record file: magic, format version, and a block that describes the record.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | [`MAGIC`] |
//! | 2 | format version, little-endian |
//! | 4 | length of the block, little-endian, at most [`HEADER_BYTES_MAX`] |
//! | … | the block: [`Header`] as JSON, terminated by a line feed |
//! | 4 | checksum of all of the above, since format 3 |
//!
//! [`blocks`](super::blocks) describes the rest of the file.
//!
//! `head -2` shows which run a record is of; programs can read that without this crate.

use super::blocks::Check;
use super::{Bench, Device, Observation};
use plan::library::Pack;
use plan::quantities::{self, OPEN_TAG};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use wire::can::BitRates;

/// The first bytes of every record file. The first byte is not text, so that no tool takes the file for text; the last
/// reveals a conversion of line ends.
pub const MAGIC: [u8; 8] = *b"\x89hilrec\n";

/// The version that this crate writes. Version 3 added checksums.
pub const FORMAT_VERSION: u16 = 3;

/// The oldest version that this crate reads. Version 2 added the uncertainty of an estimator's states and more health
/// causes.
pub const OLDEST_FORMAT_VERSION: u16 = 2;

/// The longest block; the layouts of several vehicles fit.
pub const HEADER_BYTES_MAX: usize = 16 * 1024 * 1024;

/// Longer texts of [`Header::files`] are left out; texts up to this length fit into the block even when escaped.
pub const FILES_BYTES_MAX: usize = HEADER_BYTES_MAX / 4;

/// Description of the record in its own file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Header {
    /// Version of the harness that wrote it.
    pub harness: String,
    /// Name of the plan.
    pub plan: String,
    /// Seed of the run.
    pub seed: u64,
    /// Where and when it ran; absent in virtual time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bench: Option<Bench>,
    /// The meaning of the observations in the record.
    #[serde(default)]
    pub quantities: Vec<Quantity>,
    /// The nodes of a rig on their lines, in the order of [`Device::Node`]; empty if the plan names its only device. A
    /// node on several lines has one entry per line.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<Node>,
    /// The serial lines of the bench as in its device file; empty if not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<Line>,
    /// The CAN buses of a rig; empty if the plan names its only device, whose bus has the default bit rate.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub buses: Vec<Bus>,
    /// Steps with a label, and those that act on a device, by their place in the plan. Empty in older records.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub steps: BTreeMap<String, StepNote>,
    /// The texts of the plan and of the files that it names: the rig with its layouts, calibrations and models. Empty
    /// if the plan was made in code, if its files are longer than [`FILES_BYTES_MAX`], and in older records.
    #[serde(default, skip_serializing_if = "is_empty")]
    pub files: Arc<Pack>,
}

fn is_empty(files: &Arc<Pack>) -> bool {
    files.0.is_empty()
}

/// What a report needs of a step, apart from its title.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct StepNote {
    /// Its label.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Whether it sends, sets or switches something.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub acts: bool,
}

/// A node on a line of a rig.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Node {
    /// Name of the node.
    pub name: String,
    /// The name of the line.
    pub line: String,
    /// On a serial line: whether it sends what the device there receives.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub host: bool,
    /// Whether the harness sent for it: a tester, or a node that is emulated or replayed.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub played: bool,
}

/// A serial line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Line {
    /// The device at its end.
    pub device: Device,
    /// Bits per second on the line.
    pub baud: u32,
    /// Bits on the line for one byte, start and stop bits included.
    pub bits_per_byte: u32,
}

/// A CAN bus.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bus {
    /// The name of the line.
    pub line: String,
    /// Bits per second.
    pub bit_rate: u32,
    /// Bits per second of the data of CAN FD frames; `None` on a classic bus.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data_bit_rate: Option<u32>,
}

impl Bus {
    /// Nominal and data bit rate.
    pub const fn rates(&self) -> BitRates {
        BitRates { nominal: self.bit_rate, data: self.data_bit_rate }
    }
}

/// A quantity that the plan observes, with all that a report needs without the plan.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Quantity {
    /// Name, as in observations.
    pub name: String,
    /// Unit of its values; empty without a unit.
    pub unit: String,
    /// Short description.
    pub title: String,
    /// Bands for single values.
    #[serde(default)]
    pub bands: Vec<Band>,
    /// Measurements that use it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub judged_by: Vec<String>,
}

impl Quantity {
    /// Whether none of its bands judges this observation, because it is of something that might still end in time.
    pub fn is_undecided(&self, observation: &Observation) -> bool {
        observation.tags.get(OPEN_TAG).is_some_and(|&open| {
            let undecided = |band: &Band| {
                let is_of_step = !band.tags.is_empty();
                quantities::is_undecided(open, observation.value, band.upper, is_of_step)
            };
            self.bands.iter().all(undecided)
        })
    }
}

/// A band for single values of a quantity, in its unit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Band {
    /// The measurement that declares the band.
    pub measurement: String,
    /// Lower end, inclusive; `None` if there is no limit.
    pub lower: Option<f64>,
    /// Upper end, inclusive; `None` if there is no limit.
    pub upper: Option<f64>,
    /// The value in the paper, with its place there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper: Option<String>,
    /// The band applies to observations with these tags; empty: to all.
    #[serde(default)]
    pub tags: BTreeMap<String, f64>,
}

/// The name of who sends the frames that a fault makes.
const STRANGER: &str = "stranger";

impl Header {
    /// What is noted of a step, by its place in a record, which also names the round.
    pub fn step(&self, path: &str) -> Option<&StepNote> {
        self.steps.get(path.split(" (").next().unwrap_or(path))
    }

    /// The name of the device or node.
    pub fn name_of(&self, device: Device) -> &str {
        match device {
            Device::Node(_) => self.node(device).map_or(STRANGER, |node| &node.name),
            device => device.name(),
        }
    }

    /// Index of the bus that a node of a rig, or a [stranger](Device::stranger), sends on; 0 for all other devices.
    pub fn bus_of(&self, device: Device) -> usize {
        let line = self.line_of(device);
        self.buses.iter().position(|bus| Some(&*bus.line) == line).unwrap_or_default()
    }

    /// The line that a node of a rig, or a [stranger](Device::stranger), sends on.
    pub fn line_of(&self, device: Device) -> Option<&str> {
        let of_stranger = || self.strangers().zip(&self.buses).find(|(who, _)| *who == device);
        let node = self.node(device).map(|node| &*node.line);
        node.or_else(|| of_stranger().map(|(_, bus)| &*bus.line))
    }

    /// Who sends the frames that faults make, on each bus of a rig.
    pub fn strangers(&self) -> impl Iterator<Item = Device> {
        (0..self.buses.len()).map(Device::stranger)
    }

    /// The entry of a node of a rig, which also names its line.
    pub fn node(&self, device: Device) -> Option<&Node> {
        let Device::Node(place) = device else { return None };
        self.nodes.get(usize::from(place))
    }

    /// Magic, version, block and their checksum.
    pub(super) fn bytes(&self) -> io::Result<Vec<u8>> {
        let mut block = serde_json::to_vec(self)?;
        block.push(b'\n');
        let length = u32::try_from(block.len()).ok().filter(|_| block.len() <= HEADER_BYTES_MAX);
        let Some(length) = length else {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                format!("the header takes {} bytes; {HEADER_BYTES_MAX} are allowed", block.len()),
            ));
        };
        let mut bytes = MAGIC.to_vec();
        bytes.extend(FORMAT_VERSION.to_le_bytes());
        bytes.extend(length.to_le_bytes());
        bytes.extend(block);
        let check = Check::default().of(&bytes);
        bytes.extend(check.bytes());
        Ok(bytes)
    }
}
