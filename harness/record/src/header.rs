//! The beginning of a record file: magic, format version, and a block that describes the record.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | [`MAGIC`] |
//! | 2 | format version, little-endian |
//! | 4 | length of the block, little-endian, at most [`HEADER_BYTES_MAX`] |
//! | … | the block: [`Header`] as JSON, ended by a line feed |
//! | 4 | check of all that, since format 3 |
//!
//! What follows: [`blocks`](super::blocks).
//!
//! `head -2` shows a person whose record it is; a program need not know this crate to read that.

use super::Device;
use super::blocks::Check;
use plan::library::Pack;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use wire::can::BitRates;

/// The first bytes of every record file. The first is no text, so that nothing takes it for text;
/// the last is changed by whatever mangles line ends.
pub const MAGIC: [u8; 8] = *b"\x89hilrec\n";

/// The version that this crate writes. The third has checksums.
pub const FORMAT_VERSION: u16 = 3;

/// The oldest version that this crate reads. The second has how sure an estimator is in its states, and more causes of a health.
pub const OLDEST_FORMAT_VERSION: u16 = 2;

/// The longest block: the layouts of several vehicles fit.
pub const HEADER_BYTES_MAX: usize = 16 * 1024 * 1024;

/// Longer texts of [`Header::files`] are left out: escaped, they still fit into the block.
pub const FILES_BYTES_MAX: usize = HEADER_BYTES_MAX / 4;

/// What a record file says about itself.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Header {
    /// Version of the harness that wrote it.
    pub harness: String,
    /// Name of the plan.
    pub plan: String,
    /// The seed.
    pub seed: u64,
    /// What the observations in it mean.
    #[serde(default)]
    pub quantities: Vec<Quantity>,
    /// The nodes of a rig on their lines, in the order of [`Device::Node`]; none where the plan names its only device. A node
    /// on several lines stands here once for each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<Node>,
    /// The serial lines of the bench as its device file has them; none where nobody said so.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<Line>,
    /// The CAN buses of a rig; none where the plan names its only device, whose bus has the usual rate.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub buses: Vec<Bus>,
    /// The plan and what it names, as they were read: the rig with its layouts, calibrations and models. Empty where the plan
    /// was made in code, where its files are longer than [`FILES_BYTES_MAX`], and in records of before.
    #[serde(default, skip_serializing_if = "is_empty")]
    pub files: Arc<Pack>,
}

fn is_empty(files: &Arc<Pack>) -> bool {
    files.0.is_empty()
}

/// A node on a line of a rig.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Node {
    /// Its name.
    pub name: String,
    /// The name of the line.
    pub line: String,
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
    /// Its rates.
    pub const fn rates(&self) -> BitRates {
        BitRates { nominal: self.bit_rate, data: self.data_bit_rate }
    }
}

/// A quantity that the plan observes, as a report needs it: without the plan at hand.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Quantity {
    /// Name, as in an observation.
    pub name: String,
    /// Unit of its values; empty where it has none.
    pub unit: String,
    /// What it is, in a few words.
    pub title: String,
    /// Where single values are meant to lie.
    #[serde(default)]
    pub bands: Vec<Band>,
    /// Measurements that rest on it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub judged_by: Vec<String>,
}

/// Where single values of a quantity are meant to lie, in its unit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Band {
    /// The measurement that says so.
    pub measurement: String,
    /// Lower end, included; none where there is no limit.
    pub lower: Option<f64>,
    /// Upper end, included; none where there is no limit.
    pub upper: Option<f64>,
    /// What the paper gives, with its place.
    pub paper: Option<String>,
    /// The observations that are meant: those with these tags. Empty: all.
    #[serde(default)]
    pub tags: BTreeMap<String, f64>,
}

impl Header {
    /// Whose event it is, by name.
    pub fn name_of(&self, device: Device) -> &str {
        match device {
            Device::Node(_) => self.node(device).map_or("node", |node| &node.name),
            device => device.name(),
        }
    }

    /// The bus that a device of a rig sends on, by its place; that of others is the first.
    pub fn bus_of(&self, device: Device) -> usize {
        let line = self.node(device).map(|node| &node.line);
        self.buses.iter().position(|bus| Some(&bus.line) == line).unwrap_or_default()
    }

    /// The node of a rig, and the line that it spoke on.
    pub fn node(&self, device: Device) -> Option<&Node> {
        let Device::Node(place) = device else { return None };
        self.nodes.get(usize::from(place))
    }

    /// Magic, version, block and the check of them.
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
