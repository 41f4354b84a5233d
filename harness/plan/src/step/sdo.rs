//! Reads or writes an object of a CANopen device.

use super::{Known, Op, StepKind};
use crate::Checked;
use crate::name::Name;
use crate::number;
use crate::quantities::SDO_PREFIX;
use crate::speakers::{DEVICE, Speaker, canopen_devices, whose};
use crate::subject::Subject;
use crate::survey::Survey;
use described::hint::proposal;
use described::{Mistake, Place};
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
    #[serde(default, with = "number::Finite")]
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

impl Sdo {
    /// Checks that the plan can read or write this object; returns its unit if the rig is loaded.
    fn unit_on(&self, subject: &Subject<'_>, at: &Place) -> Result<Option<String>, Mistake> {
        if self.write.is_some() && self.read.is_some() {
            return Err(at.key("read").mistake("`read` beside `write`"));
        }
        let Some(rig) = subject.rig else { return Ok(None) };
        let devices: Vec<_> = canopen_devices(&rig.speakers).collect();
        let found = devices.iter().find(|(_, device, _)| device.node == self.node());
        let found =
            found.and_then(|(_, device, request)| Some((device.layout.dictionary()?, request)));
        let Some((dictionary, request)) = found else {
            let known: Vec<&str> =
                devices.iter().map(|(_, device, _)| device.node.as_str()).collect();
            let message = format!("no EDS says which objects {} has", whose(self.node()));
            return Err(at.key("node").mistake(message).help(proposal("", &known)));
        };
        subject.message(request, &at.key("node"))?;
        let entry = match dictionary.find(self.index, self.sub) {
            Ok(entry) => entry,
            // Whether the device says so is what the step asks.
            Err(_) if self.abort.is_some() && self.write.is_none() => return Ok(None),
            Err(why) => {
                let message = format!("{:04X}sub{:X}: {why}", self.index, self.sub);
                return Err(at.key("index").mistake(message));
            }
        };
        if let Some(value) = self.write.filter(|value| entry.bytes(*value).is_none()) {
            return Err(at.key("write").mistake(format!("`{}` cannot be {value}", entry.name())));
        }
        if let Some((value, sent)) =
            self.write.and_then(|value| Some((value, entry.sent_instead_of(value)?)))
        {
            let message = format!("{} = {value}, and {sent} would be written", entry.name());
            return Err(at.key("write").mistake(message));
        }
        if self.read.is_some() && entry.length().is_none() {
            return Err(at.key("read").mistake(format!("`{}` is not a number", entry.name())));
        }
        Ok(self.unit(&rig.speakers))
    }
}

impl StepKind for Sdo {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { index, sub, .. } = self;
        match (&self.write, &self.read) {
            (Some(value), _) => write!(f, "write {value} to {index:04X}sub{sub:X}")?,
            (None, Some(name)) => write!(f, "read {name} from {index:04X}sub{sub:X}")?,
            (None, None) => write!(f, "read {index:04X}sub{sub:X}")?,
        }
        self.node.as_ref().map_or(Ok(()), |node| write!(f, " of {node}"))
    }

    fn judges(&self) -> bool {
        true
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Sdo(self.clone())])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        let unit = self.unit_on(&survey.subject, at)?;
        if let Some(name) = &self.read {
            survey.reads("sdo", name, unit, at)?;
        }
        Ok(())
    }
}
