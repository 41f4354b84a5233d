//! The topics of a bag.

use super::content::{Connection, Place, Visitor};
use super::decode::Encoding;
use super::definition::Definition;
use crate::DatasetError;
use std::collections::BTreeMap;

/// The most connections of a bag, and the most bytes of all their definitions.
const CONNECTIONS_MAX: usize = 4096;
const DEFINITION_BYTES_MAX: usize = 16 * 1024 * 1024;

/// A topic with messages of one type.
#[derive(Debug)]
pub(super) struct Topic {
    pub name: String,
    /// How to read its messages, or why they cannot be read.
    pub messages: Result<(Definition, Encoding), String>,
}

/// The topics of a bag, and what else has to be known before its messages are read.
#[derive(Debug, Default)]
pub(super) struct Topics {
    pub all: Vec<Topic>,
    /// Topics of connections.
    of_connections: BTreeMap<u32, usize>,
    connections: BTreeMap<u32, Connection>,
    /// The time of the first message, in nanoseconds.
    start: Option<u64>,
    /// Number of connections in the index.
    indexed: u32,
    in_all_chunks: bool,
}

impl Topics {
    /// For a bag without an index.
    pub(super) fn of_all_chunks() -> Self {
        Self { in_all_chunks: true, ..Self::default() }
    }

    /// Whether an index with at least so many connections was told. It then has all.
    pub(super) fn are_indexed(&self, count: u32) -> bool {
        self.indexed >= count.max(1)
    }

    /// Whether no connection was told.
    pub(super) fn is_empty(&self) -> bool {
        self.connections.is_empty()
    }

    /// Reads the definitions of all connections.
    pub(super) fn understand(&mut self) -> Result<(), String> {
        let connections = &self.connections;
        let bytes: usize = connections.values().map(|one| one.definition.len()).sum();
        if connections.len() > CONNECTIONS_MAX || bytes > DEFINITION_BYTES_MAX {
            return Err(format!(
                "it has {} connections with {bytes} bytes of definitions, expected at most {CONNECTIONS_MAX} with \
                 {DEFINITION_BYTES_MAX}",
                connections.len()
            ));
        }
        let mut first = BTreeMap::<&str, (usize, &Connection)>::new();
        for (id, connection) in connections {
            let Connection { topic, name, definition, encoding } = connection;
            if let Some((number, first)) = first.get(topic.as_str()) {
                self.of_connections.insert(*id, *number);
                if *first != connection {
                    let why = "its messages are of several types, expected one".to_owned();
                    self.all[*number].messages = Err(why);
                }
                continue;
            }
            let messages = encoding.clone().and_then(|encoding| {
                let is_ros_2 = encoding == Encoding::Cdr;
                Ok((Definition::parse(name, definition, is_ros_2)?, encoding))
            });
            let number = self.all.len();
            first.insert(topic, (number, connection));
            self.of_connections.insert(*id, number);
            self.all.push(Topic { name: topic.clone(), messages });
        }
        Ok(())
    }

    pub(super) fn named(&self, name: &str) -> Option<(usize, &Topic)> {
        self.all.iter().enumerate().find(|(_, topic)| topic.name == name)
    }

    /// Index of the topic of a connection.
    pub(super) fn of_connection(&self, connection: u32) -> Option<usize> {
        self.of_connections.get(&connection).copied()
    }

    /// Seconds since the first message, of a time in nanoseconds.
    pub(super) fn seconds(&self, time: u64) -> f64 {
        let since = time.wrapping_sub(self.start.unwrap_or_default()).cast_signed();
        since as f64 / 1e9
    }
}

impl Visitor for Topics {
    fn connection(&mut self, id: u32, connection: Connection, in_index: bool) {
        self.indexed = self.indexed.saturating_add(in_index.into());
        self.connections.entry(id).or_insert(connection);
    }

    fn wants_chunk(&self) -> bool {
        self.in_all_chunks || self.start.is_none()
    }

    fn wants_messages_of(&self, _: u32) -> bool {
        self.start.is_none()
    }

    fn message(&mut self, _: Place, _: u32, time: u64, _: &[u8]) -> Result<(), DatasetError> {
        self.start.get_or_insert(time);
        Ok(())
    }
}
