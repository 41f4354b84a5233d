//! What faults can strike on a rig.

use super::Rig;
use crate::faults::{LineKind, Lines, Said, Target, TargetName};
use crate::speakers::DEVICE;

impl Rig {
    /// The possible targets of faults.
    pub fn struck(&self) -> Lines {
        let mut nodes: Vec<(Target, LineKind)> = Vec::new();
        let target = |name: &str| match name == DEVICE {
            true => Some(Target::Device),
            false => TargetName::new(name).map(Target::Node),
        };
        let mut add = |name: &str, kind| {
            if let Some(target) =
                target(name).filter(|target| nodes.iter().all(|(known, _)| known != target))
            {
                nodes.push((target, kind));
            }
        };
        let kind = |line: &usize| {
            let of_robot = self.robot_lines();
            match line.checked_sub(of_robot).and_then(|line| self.lines.get(line)) {
                Some(line) => line.medium.into(),
                None => LineKind::Can,
            }
        };
        if self.is_short {
            let device = self.device().map(|device| device.layout().medium().into());
            device.into_iter().for_each(|kind| add(DEVICE, kind));
        } else {
            for node in &self.nodes {
                node.lines.first().into_iter().for_each(|line| add(&node.name, kind(line)));
            }
            for line in &self.lines {
                add(&line.name, line.medium.into());
            }
        }
        let said = self.speakers.iter().flat_map(|one| {
            Said::all(&one.node, &one.layout, one.sender, kind(&one.line)).collect::<Vec<_>>()
        });
        let host = self.robot.is_some() || self.under_test().next().is_some();
        let shared = self.lines.iter().filter(|_| !self.is_short).map(|line| line.name.as_str());
        let is_node = |name: &&str| self.nodes.iter().any(|node| node.name == *name);
        let shared = shared.filter(|name| !is_node(name)).filter_map(TargetName::new);
        let shared = shared.map(Target::Node).collect();
        let powered = self.powered_names().into_iter().filter_map(target);
        let powered = powered.filter(|target| nodes.iter().any(|(known, _)| known == target));
        let powered = powered.collect();
        Lines { robot: self.ride(), host, nodes, shared, powered, said: said.collect() }
    }
}
