//! What is checked of a rig while it is built.

use super::{Builder, Cause};
use crate::command::{CommandError, fill};
use crate::library::LibraryError;
use crate::quantities;
use crate::rig::{NodeTable, RigFile, RigLine, RigNode, UnderTest};
use crate::speakers::{DEVICE, Speaker};
use described::{Layout, Medium, hint};
use std::collections::BTreeMap;
use wire::can::{Hex, Id};

impl<E: Cause> Builder<'_, E> {
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

    /// Checks that a device file and its line state the same counters and checksums.
    pub(super) fn check_agrees(
        &self,
        layout: &Layout,
        (node, number, key): (&NodeTable, usize, &'static str),
        line: usize,
    ) -> Result<(), LibraryError> {
        let own = line.checked_sub(self.rig.robot_lines());
        let of_line = own.and_then(|own| Some((self.line(line)?, self.protected.get(&own)?)));
        let Some((line, of_line)) = of_line else { return Ok(()) };
        let Some((message, what)) = layout.contradicts(of_line) else { return Ok(()) };
        let text = format!(
            "the file of `{}` and line `{}` state different {what}s of `{message}`",
            node.name, line.name
        );
        let help = format!("state it alike in both, or leave `message.{message}` out at the line");
        Err(self.mistake(("node", number, key), text, Some(help)))
    }

    /// Checks that no other tester on a bus has the messages of this one: the plan would send them as that one alone. A serial
    /// line has no room for two.
    pub(super) fn check_alone(
        &self,
        file: &RigFile,
        number: usize,
        line: usize,
        layout: &Layout,
    ) -> Result<(), LibraryError> {
        if self.line(line).is_some_and(|line| line.medium != Medium::Can) {
            return Ok(());
        }
        let mut testers = file.nodes[..number].iter().filter(|one| one.tester == Some(true));
        let is_alike = |other: &&NodeTable| {
            self.rig.speakers.iter().any(|known| {
                (known.node.as_str(), known.line) == (other.name.as_str(), line)
                    && known.layout.messages() == layout.messages()
            })
        };
        let Some(other) = testers.find(is_alike) else { return Ok(()) };
        let text = format!(
            "`{}` and `{}` are testers of the same messages",
            other.name, file.nodes[number].name
        );
        let help = "one tester sends those of all other nodes; of several, `dbc_node` says whose"
            .to_owned();
        Err(self.mistake(("node", number, "tester"), text, Some(help)))
    }

    /// Notes messages that two emulated nodes send with one identifier on one bus: who hears it takes both for one, and
    /// on a real bus they disturb each other.
    pub(super) fn note_shared_identifiers(&mut self) {
        let rig = &self.rig;
        let sent = |speaker: &'_ Speaker| -> Vec<(Id, String)> {
            let messages = speaker.layout.messages().iter();
            let sent = messages.filter(|message| message.sender == speaker.sender);
            sent.filter_map(|message| Some((message.can_id()?, message.name.to_string()))).collect()
        };
        let emulated = rig.speakers.iter().filter(|one| rig.described(&one.node).is_some());
        let emulated: Vec<_> = emulated.map(|one| (one, sent(one))).collect();
        let mut notes = Vec::new();
        for (place, (second, theirs)) in emulated.iter().enumerate() {
            let before = emulated[..place].iter().filter(|(first, _)| first.line == second.line);
            for (first, ours) in before {
                let shared =
                    theirs.iter().find(|(id, _)| ours.iter().any(|(other, _)| id == other));
                notes.extend(shared.map(|(id, message)| {
                    format!(
                        "{} and {} both send the identifier {} (`{message}`) on {}",
                        first.node,
                        second.node,
                        Hex(*id),
                        rig.line_name(second.line)
                    )
                }));
            }
        }
        self.rig.notes.extend(notes);
    }

    /// Checks that the command of a program names lines of the rig.
    pub(super) fn check_ports(&self, node: &NodeTable, number: usize) -> Result<(), LibraryError> {
        let Some(UnderTest::Command(words)) = &node.under_test else { return Ok(()) };
        let lines = 0..self.rig.robot_lines() + self.rig.lines.len();
        let names = lines.map(|line| self.rig.line_name(line).to_owned());
        let ports: BTreeMap<String, String> = names.map(|name| (name, String::new())).collect();
        let refuse = |text, help| Err(self.mistake(("node", number, "under_test"), text, help));
        match fill(words, &ports) {
            Ok(_) => Ok(()),
            Err(CommandError::UnknownPort { name, word, .. }) => {
                let known: Vec<&str> = ports.keys().map(String::as_str).collect();
                let text = format!("no line `{name}` for `{word}` of `{}`", node.name);
                let help =
                    format!("{}; a brace itself is written twice", hint::proposal(&name, &known));
                refuse(text, Some(help))
            }
            Err(error) => refuse(error.to_string(), None),
        }
    }

    /// Checks that a node has a name of its own, without another meaning in plans.
    pub(super) fn check_name(&self, file: &RigFile, number: usize) -> Result<(), LibraryError> {
        let name = file.nodes[number].name.as_str();
        let refuse = |message: String, help: Option<&str>| {
            Err(self.mistake(("node", number, "name"), message, help.map(str::to_owned)))
        };
        if file.nodes[..number].iter().any(|known| known.name.as_str() == name) {
            return refuse(format!("two nodes are called `{name}`"), None);
        }
        if file.lines.iter().any(|line| line.name.as_str() == name) {
            let help = "a fault with this target could mean either";
            return refuse(format!("a line is called `{name}` too"), Some(help));
        }
        let of_robot = self.rig.robot.is_some() && ["robot", "controller"].contains(&name);
        let is_family = quantities::families().contains(name);
        if of_robot || is_family || [DEVICE, "host", "plan"].contains(&name) {
            return refuse(
                format!("`{name}` has a meaning of its own in plans"),
                Some("call the node otherwise"),
            );
        }
        Ok(())
    }

    /// Checks who shares a serial line: two nodes, or several devices and one host (RS-485). Bytes name no sender, so that
    /// only the two ends of a line can be replayed, or under test beside each other.
    pub(super) fn check_ends(
        &self,
        (file, number): (&RigFile, usize),
        lines: &[usize],
        built: &[(usize, RigNode)],
    ) -> Result<(), LibraryError> {
        for line in lines {
            let Some(found) = self.line(*line) else { continue };
            let others = built.iter().filter(|(_, node)| node.lines.contains(line));
            let mut ends: Vec<&NodeTable> = others.map(|(other, _)| &file.nodes[*other]).collect();
            ends.push(&file.nodes[number]);
            if found.medium == Medium::Can || ends.len() < 3 {
                continue;
            }
            let is_host = |node: &&&NodeTable| node.description().is_none();
            let (what, help) = if ends.iter().filter(is_host).count() > 1 {
                let help = "a serial line joins two nodes, or several devices that files describe and one host";
                ("a second host", help)
            } else if ends.iter().any(|node| node.replay.is_some()) {
                ("a log", "bytes in a log name no sender: a log plays one of two ends")
            } else if ends.iter().filter(|node| node.under_test.is_some()).count() > 1 {
                let help =
                    "bytes at a port name no sender: of more than two ends one is under test";
                ("a second node under test", help)
            } else {
                continue;
            };
            let message =
                format!("{what} on the serial line `{}` of {} ends", found.name, ends.len());
            return Err(self.mistake(("node", number, "at"), message, Some(help.to_owned())));
        }
        Ok(())
    }
}
