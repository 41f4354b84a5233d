//! Reads or writes an object of a CANopen device.

use super::{Known, Needs, Op, StepKind};
use crate::name::Name;
use crate::number;
use crate::quantities::SDO_PREFIX;
use crate::speakers::{DEVICE, Speaker, canopen_devices};
use crate::validate::{Checked, Place, Survey};
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;

/// An object of a CANopen device is written or read by SDO:
/// `sdo = { node = "drive", index = 0x6060, sub = 0, write = 1 }`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sdo {
    /// The node. Absent in a plan with a single device.
    #[serde(default)]
    pub node: Option<Name>,
    /// Index of the object.
    pub index: u16,
    /// Sub-index.
    #[serde(default)]
    pub sub: u8,
    /// The value to write, in the unit of the object.
    #[serde(default, deserialize_with = "number::finite_option")]
    pub write: Option<f64>,
    /// A name for the value that is read; observed as `sdo.<name>`, in the unit of the object.
    #[serde(default)]
    pub read: Option<Name>,
    /// The code with which the device has to abort the transfer: anything else is a failure.
    #[serde(default)]
    pub abort: Option<u32>,
}

impl Sdo {
    /// The node.
    pub fn node(&self) -> &str {
        self.node.as_ref().map_or(DEVICE, Name::as_str)
    }

    /// The quantity that it reads.
    pub fn quantity(&self) -> Option<String> {
        self.read.as_ref().map(|name| format!("{SDO_PREFIX}{name}"))
    }

    /// The unit of the object; `None` if no CANopen device has it.
    pub fn unit(&self, speakers: &[Speaker]) -> Option<String> {
        let (_, device, _) =
            canopen_devices(speakers).find(|(_, device, _)| device.node == self.node())?;
        let entry = device.layout.dictionary()?.find(self.index, self.sub).ok()?;
        Some(if entry.unit().is_empty() { "1" } else { entry.unit() }.to_owned())
    }
}

impl StepKind for Sdo {
    fn example() -> &'static str {
        "{ sdo = { node = \"drive\", index = 0x6060, sub = 0, write = 1 } }"
    }

    fn needs() -> Needs {
        Needs::Tester
    }

    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { index, sub, .. } = self;
        match (&self.write, &self.read) {
            (Some(value), _) => write!(f, "write {value} to {index:04X}sub{sub:X}")?,
            (None, Some(name)) => write!(f, "read {name} from {index:04X}sub{sub:X}")?,
            (None, None) => write!(f, "read {index:04X}sub{sub:X}")?,
        }
        self.node.as_ref().map_or(Ok(()), |node| write!(f, " of {node}"))
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Sdo(self.clone())])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place<'_>) -> Checked {
        let unit = survey.subject.sdo(self, at)?;
        if let Some(name) = &self.read {
            survey.reads("sdo", name, unit, at)?;
        }
        Ok(())
    }
}
