//! What a device of a test sends, and its port does not carry.

use crate::Rig;
use crate::node::{Part, Route};
use wire::device::{PortId, Transmit};

impl Rig {
    /// Ends a device of a test that sends what its port does not carry: on a bench it could not.
    pub(super) fn disowns(&mut self, node: usize, port: PortId, what: &Transmit) -> bool {
        let Some(how) = self.misplaced(node, port, what) else { return false };
        if let Part::Own(device) = &mut self.nodes[node].part {
            device.guest.disown(how);
        }
        true
    }

    /// What is wrong with sending this at that port of a node, to stand behind its name.
    fn misplaced(&self, node: usize, port: PortId, what: &Transmit) -> Option<String> {
        let Some(Route { line, .. }) = self.nodes[node].route(port) else {
            return Some(format!("sends at its port {}, which is on no line", port.0));
        };
        let (is_frame, name) = (matches!(what, Transmit::Frame(_)), &self.line_names[line]);
        match (is_frame, self.lines[line].is_can()) {
            (true, false) => Some(format!("sends a frame on the serial line {name}")),
            (false, true) => Some(format!("sends bytes on the bus {name}")),
            _ => None,
        }
    }
}
