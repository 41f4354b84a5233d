//! What is checked of a rig while it is built.

use super::Builder;
use crate::library::LibraryError;
use crate::quantities;
use crate::rig::{RigFile, RigLine, RigNode};
use crate::speakers::DEVICE;
use described::{Layout, Medium};

impl Builder<'_> {
    /// Checks that a classic bus has no CAN FD messages.
    pub(super) fn check_carries(
        &self,
        line: &RigLine,
        layout: &Layout,
        at: (&'static str, usize, &'static str),
    ) -> Result<(), LibraryError> {
        match layout.fd_message() {
            Some(message) if line.medium == Medium::Can && line.data_bit_rate.is_none() => {
                let text = format!(
                    "`{}` is a CAN FD message, and line `{}` is a classic bus",
                    message.name, line.name
                );
                let help = "give the line a `data_bit_rate`, such as 2_000_000".to_owned();
                Err(self.mistake(at, text, Some(help)))
            }
            _ => Ok(()),
        }
    }

    /// Checks that a node has a name of its own, without another meaning in plans.
    pub(super) fn check_name(&self, file: &RigFile, number: usize) -> Result<(), LibraryError> {
        let name = file.nodes[number].name.as_str();
        let refuse = |message: String, help: Option<&str>| {
            let help = help.map(str::to_owned);
            Err(self.mistake(("node", number, "name"), message, help))
        };
        if file.nodes[..number].iter().any(|known| known.name.as_str() == name) {
            return refuse(format!("two nodes are called `{name}`"), None);
        }
        let of_robot = self.rig.robot.is_some() && ["robot", "controller"].contains(&name);
        let kinds = [DEVICE, "signal", "period", "operator", "sdo", "uds", "host", "plan"];
        let prefix = quantities::NAMES.iter().any(|known| known.split('.').next() == Some(name));
        if of_robot || prefix || kinds.contains(&name) {
            return refuse(
                format!("`{name}` has a meaning of its own in plans"),
                Some("call the node otherwise"),
            );
        }
        Ok(())
    }

    /// Checks that a serial line has two ends.
    pub(super) fn check_ends(
        &self,
        number: usize,
        lines: &[usize],
        built: &[(usize, RigNode)],
    ) -> Result<(), LibraryError> {
        for line in lines {
            let Some(found) = self.line(*line) else { continue };
            let ends = built.iter().filter(|(_, node)| node.lines.contains(line)).count();
            if found.medium != Medium::Can && ends == 2 {
                let message = format!("a third end on the serial line `{}`", found.name);
                let help = "a serial line joins two: give the node a line of its own".to_owned();
                return Err(self.mistake(("node", number, "at"), message, Some(help)));
            }
        }
        Ok(())
    }
}
