//! The possible targets of faults on a rig.

use super::{Reach, Share, Target};
use crate::speakers::DEVICE;
use described::{Description, Layout, Medium, Sender};

/// The medium of a line.
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

/// The carrier of the paper's gyro.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ride {
    /// A table, on a serial line.
    Table,
    /// A base, on this line.
    Base(LineKind),
}

/// The lines of a rig and the nodes on them, as targets of faults.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Lines {
    /// The paper's robot or table, if any.
    pub robot: Option<Ride>,
    /// Whether a controller or a program is under test, so that its computer can have faults.
    pub host: bool,
    /// Nodes and lines by their names.
    pub nodes: Vec<(Target, LineKind)>,
    /// Which of them are lines: what strikes one of these strikes all that is sent on it.
    pub shared: Vec<Target>,
    /// The nodes whose supply can fail.
    pub powered: Vec<Target>,
    /// The messages that the nodes send.
    pub said: Vec<Said>,
}

/// A message that a node sends, as a target of faults.
#[derive(Debug, Clone, PartialEq)]
pub struct Said {
    /// The node.
    pub node: String,
    /// The message.
    pub message: String,
    /// Its line.
    pub line: LineKind,
    /// Its signals.
    pub signals: Vec<String>,
    /// The range of each, in its unit.
    pub ranges: Vec<(f64, f64)>,
    /// Whether it has a counter.
    pub counter: bool,
    /// Whether it has a checksum.
    pub checksum: bool,
    /// Why no fault can act on it alone, if none can.
    pub never_alone: Option<&'static str>,
}

impl Lines {
    /// A gyro on a table.
    pub const TABLE: Self = Self::of_robot(Ride::Table);
    /// A gyro on a base with a serial line.
    pub const SERIAL_BASE: Self = Self::of_robot(Ride::Base(LineKind::Serial));
    /// A gyro on a base with a CAN bus.
    pub const CAN_BASE: Self = Self::of_robot(Ride::Base(LineKind::Can));

    /// The paper's robot or table alone.
    pub const fn of_robot(ride: Ride) -> Self {
        Self {
            robot: Some(ride),
            host: true,
            nodes: Vec::new(),
            shared: Vec::new(),
            powered: Vec::new(),
            said: Vec::new(),
        }
    }

    /// The only device of a plan.
    pub fn of_device(device: &Description) -> Self {
        let layout = device.layout();
        let kind = layout.medium().into();
        let said = Said::all(DEVICE, layout, Sender::Device, kind).collect();
        let powered = vec![Target::Device];
        Self { nodes: vec![(Target::Device, kind)], powered, said, ..Self::default() }
    }

    /// The medium of a node's line, or of the line with that name.
    pub(crate) fn of(&self, target: Target) -> Option<LineKind> {
        self.nodes.iter().find(|(known, _)| *known == target).map(|(_, kind)| *kind)
    }

    /// All targets on this rig for a fault with this reach.
    pub fn targets(&self, reach: Reach) -> Vec<Target> {
        if let Reach::Message(share) = reach {
            return self.said.iter().flat_map(|said| said.targets(share)).collect();
        }
        let of = reach.targets();
        let nodes = self.nodes.iter().map(|(target, _)| *target);
        let nodes = nodes.filter(|target| of.contains(&Target::Device) && !of.contains(target));
        let nodes = nodes.filter(|target| reach != Reach::Powered || self.powered.contains(target));
        of.iter().copied().chain(nodes).collect()
    }

    /// The range of the signal that is this target, in its unit; `None` for another target.
    pub fn range(&self, target: Target) -> Option<(f64, f64)> {
        let part = target.part()?;
        let (said, true) = self.said(target.node(), part).ok()? else { return None };
        let name = part.rsplit('.').next()?;
        said.ranges.get(said.signals.iter().position(|known| known == name)?).copied()
    }

    /// The message of a node that `part` names, and whether `part` names a signal of it.
    ///
    /// # Errors
    /// The names that exist instead.
    pub(super) fn said(&self, node: &str, part: &str) -> Result<(&Said, bool), Vec<String>> {
        let of_node = || self.said.iter().filter(|said| said.node == node);
        if let Some(whole) = of_node().find(|said| said.message == part) {
            return Ok((whole, false));
        }
        let has = |said: &&Said| match part.split_once('.') {
            Some((message, signal)) => said.message == message && said.has(signal),
            None => said.has(part),
        };
        let mut found: Vec<&Said> = Vec::new();
        for said in of_node().filter(has) {
            // One message may go on several lines.
            if found.iter().all(|known| known.message != said.message) {
                found.push(said);
            }
        }
        match found.as_slice() {
            [one] => Ok((one, true)),
            [_, ..] => {
                let name = |said: &&Said| format!("{node}.{}.{part}", said.message);
                Err(found.iter().map(name).collect())
            }
            [] => Err(of_node()
                .flat_map(|said| std::iter::once(&said.message).chain(&said.signals))
                .map(|name| format!("{node}.{name}"))
                .collect()),
        }
    }
}

impl Said {
    /// The messages of one sender in a layout.
    pub fn all(
        node: &str,
        layout: &Layout,
        sender: Sender,
        line: LineKind,
    ) -> impl Iterator<Item = Self> {
        let sent = layout.messages().iter().filter(move |message| message.sender == sender);
        sent.map(move |message| Self {
            node: node.to_owned(),
            message: message.name.clone(),
            line,
            signals: message.signals.iter().map(|signal| signal.name.clone()).collect(),
            ranges: message.signals.iter().map(|one| (one.minimum, one.maximum)).collect(),
            counter: message.has_counter(),
            checksum: message.has_checksum(),
            never_alone: match (message.is_in_parts(), message.is_told_by_request()) {
                (true, _) => Some("goes in parts"),
                (_, true) => Some("looks like another answer"),
                _ => None,
            },
        })
    }

    fn has(&self, signal: &str) -> bool {
        self.signals.iter().any(|known| known == signal)
    }

    fn targets(&self, share: Share) -> Vec<Target> {
        if self.never_alone.is_some() {
            return Vec::new();
        }
        let whole = format!("{}.{}", self.node, self.message);
        let names = match share {
            Share::Signal => {
                self.signals.iter().map(|signal| format!("{whole}.{signal}")).collect()
            }
            _ => vec![whole],
        };
        names.iter().filter_map(|name| Target::named(name)).collect()
    }
}
