//! Objects of CANopen devices that a plan reads and writes.

use super::Subject;
use crate::speakers::{canopen_devices, whose};
use crate::step::Sdo;
use crate::validate::{Fault, Place, Segment};
use described::hint::proposal;

impl Subject<'_> {
    /// Checks that the plan can read or write this object; returns its unit if the rig is loaded.
    pub(in super::super) fn sdo(&self, sdo: &Sdo, at: &Place<'_>) -> Result<Option<String>, Fault> {
        if sdo.write.is_some() && sdo.read.is_some() {
            let message = "`read` beside `write`".to_owned();
            return Err(at.fault(&[Segment::Key("read")], message, None));
        }
        let Some(rig) = self.rig else { return Ok(None) };
        let devices: Vec<_> = canopen_devices(&rig.speakers).collect();
        let found = devices.iter().find(|(_, device, _)| device.node == sdo.node());
        let found =
            found.and_then(|(_, device, request)| Some((device.layout.dictionary()?, request)));
        let Some((dictionary, request)) = found else {
            let known: Vec<&str> =
                devices.iter().map(|(_, device, _)| device.node.as_str()).collect();
            let message = format!("no EDS says which objects {} has", whose(sdo.node()));
            return Err(at.fault(&[Segment::Key("node")], message, Some(proposal("", &known))));
        };
        self.message(request, at, &[Segment::Key("node")])?;
        let entry = match dictionary.find(sdo.index, sdo.sub) {
            Ok(entry) => entry,
            // Whether the device says so is what the step asks.
            Err(_) if sdo.abort.is_some() && sdo.write.is_none() => return Ok(None),
            Err(why) => {
                let message = format!("{:04X}sub{:X}: {why}", sdo.index, sdo.sub);
                return Err(at.fault(&[Segment::Key("index")], message, None));
            }
        };
        if let Some(value) = sdo.write.filter(|value| entry.bytes(*value).is_none()) {
            let message = format!("`{}` cannot be {value}", entry.name());
            return Err(at.fault(&[Segment::Key("write")], message, None));
        }
        if sdo.read.is_some() && entry.value(&[0; 8]).is_none() {
            let message = format!("`{}` is not a number", entry.name());
            return Err(at.fault(&[Segment::Key("read")], message, None));
        }
        Ok(sdo.unit(&rig.speakers))
    }
}
