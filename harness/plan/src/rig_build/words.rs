//! The messages of a node that no file describes.

use super::{Builder, Cause};
use crate::library::LibraryError;
use crate::rig::{LineTable, NodeTable, RigFile};
use described::hint;
use described::{IsoTp, Layout, Message, Sender};

impl<E: Cause> Builder<'_, E> {
    /// The messages of a line with the counters and checksums from its `number`-th table.
    pub(super) fn protected(
        &self,
        layout: Layout,
        number: usize,
        line: &LineTable,
    ) -> Result<Layout, LibraryError> {
        let at = (self.source.origin.as_str(), self.source.text.as_str(), number);
        layout.protected(at, &line.messages).map_err(|error| {
            let help = error.advice().map(str::to_owned);
            self.source.mistake(error.range(), error.message().to_owned(), help)
        })
    }

    /// The messages of a node that no file describes: according to its DBC, or as the other end of a described device.
    pub(super) fn words(
        &self,
        file: &RigFile,
        number: usize,
        line: usize,
    ) -> Result<Option<(Layout, Sender)>, E> {
        let node = &file.nodes[number];
        let own = line.checked_sub(self.rig.robot_lines());
        let Some((own, dbcs)) = own.and_then(|own| Some((own, self.dbcs.get(&own)?))) else {
            let others = self.rig.speakers.iter().filter(|known| known.line == line);
            let devices = others.filter(|known| known.sender == Sender::Device);
            let devices: Vec<_> = devices.map(|one| (one.node.as_str(), &one.layout)).collect();
            return match devices[..] {
                [] => Ok(None),
                [(_, layout)] => Ok(Some((layout.clone(), Sender::Host))),
                _ => match Layout::of_host(&devices) {
                    Ok(layout) => Ok(Some((layout, Sender::Host))),
                    Err(text) => {
                        let help = "each device on the line hears messages of its own".to_owned();
                        Err(self.mistake(("node", number, "at"), text, Some(help)).into())
                    }
                },
            };
        };
        let wanted = node.dbc_node.as_deref().unwrap_or(node.name.as_str());
        let nodes = dbcs.iter().flat_map(|dbc| dbc.nodes());
        let nodes: Vec<&str> = nodes.map(|node| node.name.as_str()).collect();
        // The node may occur in several files.
        let is_it = |of: &str| of.eq_ignore_ascii_case(wanted);
        let is_known = nodes.iter().any(|known| is_it(known));
        let of_node = is_known.then(|| Layout::from_dbcs(dbcs, &is_it)).transpose();
        let of_node = of_node.map_err(Box::new)?;
        // Many a DBC has a node for the tester, which sends nothing there.
        let speaks = |layout: &Layout| {
            let own = |message: &Message| message.sender == Sender::Device;
            node.tester.is_none() || node.dbc_node.is_some() || layout.messages().iter().any(own)
        };
        match (of_node.filter(speaks), node.tester) {
            (Some(layout), _) => {
                let layout = self.protected(layout, own, &file.lines[own])?;
                Ok(Some((layout, Sender::Device)))
            }
            (None, Some(_)) if node.dbc_node.is_none() => {
                // All messages that no other node of the rig sends.
                let taken: Vec<String> = file
                    .nodes
                    .iter()
                    .filter(|other| other.name != node.name)
                    .map(|other| other.dbc_node.clone().unwrap_or_else(|| other.name.to_string()))
                    .collect();
                let is_ours = |of: &str| !taken.iter().any(|taken| taken.eq_ignore_ascii_case(of));
                let layout = Layout::from_dbcs(dbcs, &is_ours).map_err(Box::new)?;
                Ok(Some((self.protected(layout, own, &file.lines[own])?, Sender::Device)))
            }
            (None, _) => {
                let origins: Vec<&str> = dbcs.iter().map(|dbc| dbc.file()).collect();
                let message = format!("no node `{wanted}` in {}", origins.join(" and "));
                let help =
                    format!("{}; `dbc_node` says which it is", hint::proposal(wanted, &nodes));
                let key = if node.dbc_node.is_some() { "dbc_node" } else { "name" };
                Err(self.mistake(("node", number, key), message, Some(help)).into())
            }
        }
    }

    /// The channel for diagnostic requests that the rig file states of a node under test.
    pub(super) fn isotp(
        &self,
        node: &NodeTable,
        number: usize,
    ) -> Result<Option<IsoTp>, LibraryError> {
        let Some(table) = &node.isotp else { return Ok(None) };
        let refuse = |message: String| self.mistake(("node", number, "isotp"), message, None);
        if node.under_test.is_none() {
            return Err(refuse(format!(
                "`isotp` belongs to a node under test, and `{}` is not one",
                node.name
            )));
        }
        if let Some(description) = &node.described_by {
            return Err(refuse(format!(
                "`{description}`, which describes `{}`, has it",
                node.name
            )));
        }
        IsoTp::new(table).map(Some).map_err(|(key, message)| refuse(format!("`{key}`: {message}")))
    }

    /// What the tester with this `number` says by the DBC of its `line`, with its requests to the servers there.
    pub(super) fn asking(
        &self,
        layout: Layout,
        number: usize,
        line: usize,
    ) -> Result<Layout, LibraryError> {
        let others = self.rig.speakers.iter().filter(|known| known.line == line);
        let servers = others.filter(|known| known.sender == Sender::Device);
        let servers: Vec<_> = servers.map(|one| (one.node.as_str(), &one.layout)).collect();
        layout.asking(&servers).map_err(|text| {
            let help = "each server on the line has identifiers of its own".to_owned();
            self.mistake(("node", number, "at"), text, Some(help))
        })
    }

    /// The messages of a node with the frames of its channel for diagnostic requests.
    pub(super) fn with_channel(
        &self,
        node: &NodeTable,
        number: usize,
        words: Option<(Layout, Sender)>,
    ) -> Result<Option<(Layout, Sender)>, LibraryError> {
        let Some(isotp) = self.isotp(node, number)? else { return Ok(words) };
        match words.unwrap_or((Layout::empty(), Sender::Device)) {
            (layout, Sender::Device) => {
                let layout = layout.without_frames_of(&isotp).with_isotp(&isotp);
                let layout = layout.map_err(|(_, message)| {
                    self.mistake(("node", number, "isotp"), message, None)
                })?;
                Ok(Some((layout, Sender::Device)))
            }
            // It is the other end of a device, whose channel has these names.
            other => Ok(Some(other)),
        }
    }
}
