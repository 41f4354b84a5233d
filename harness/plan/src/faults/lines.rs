//! What a rig has for faults to strike.

use super::Target;
use described::{Description, Medium};

/// What carries a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineKind {
    /// Bytes.
    Serial,
    /// Frames.
    Can,
}

impl From<Medium> for LineKind {
    fn from(medium: Medium) -> Self {
        match medium {
            Medium::Can => Self::Can,
            Medium::Serial(_) => Self::Serial,
        }
    }
}

/// What the paper's gyro rides on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ride {
    /// A table, on a serial line.
    Table,
    /// A base, on this line.
    Base(LineKind),
}

/// The lines of a rig, and who is at them, as faults strike them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Lines {
    /// The paper's robot or table; none where there is none.
    pub robot: Option<Ride>,
    /// Nodes and lines by their names.
    pub nodes: Vec<(Target, LineKind)>,
}

impl Lines {
    /// A gyro on a table.
    pub const TABLE: Self = Self::of_robot(Ride::Table);
    /// A gyro on a base that is on a serial line.
    pub const SERIAL_BASE: Self = Self::of_robot(Ride::Base(LineKind::Serial));
    /// A gyro on a base that is on CAN.
    pub const CAN_BASE: Self = Self::of_robot(Ride::Base(LineKind::Can));

    /// The paper's robot or table alone.
    pub const fn of_robot(ride: Ride) -> Self {
        Self { robot: Some(ride), nodes: Vec::new() }
    }

    /// The only device of a plan.
    pub fn of_device(device: &Description) -> Self {
        let kind = device.layout().medium().into();
        Self { robot: None, nodes: vec![(Target::Device, kind)] }
    }

    /// The line of a node, or of that name.
    pub(crate) fn of(&self, target: Target) -> Option<LineKind> {
        self.nodes.iter().find(|(known, _)| *known == target).map(|(_, kind)| *kind)
    }

    /// All that a fault of these targets could strike here: those, and nodes where a device is among them.
    pub fn targets(&self, of: &[Target]) -> Vec<Target> {
        let nodes = self.nodes.iter().map(|(target, _)| *target);
        let nodes = nodes.filter(|target| of.contains(&Target::Device) && !of.contains(target));
        of.iter().copied().chain(nodes).collect()
    }
}
