//! The content of a bag, in the order of the file. Records of a chunk are like those outside.

use super::content::{Head, Place, Stop, Visitor};
use super::input::{Fault, Input};
use super::sqlite::{self, Database};
use super::{mcap, packed, ros1};
use std::io::{Cursor, Read, Seek};
use std::path::Path;

/// How records follow each other in a file.
#[derive(Debug, Clone)]
enum Format {
    Ros1 {
        /// Number of connections in the index.
        connections: u32,
    },
    Mcap(mcap::Schemas),
}

/// An open bag.
#[derive(Debug)]
pub(super) enum Container<R> {
    Records(Records<R>),
    Database(Database),
}

#[derive(Debug)]
pub(super) struct Records<R> {
    input: Input<R>,
    format: Format,
    /// Where the first one begins.
    begin: u64,
}

impl<R: Read + Seek> Container<R> {
    /// Recognises the format and whether the recorder finished the bag.
    pub(super) fn open(path: &Path, mut input: Input<R>) -> Result<(Self, bool), Fault> {
        let mut starts_with = |magic: &[u8]| {
            let is_long_enough = input.end() >= magic.len() as u64;
            input.seek(0)?;
            Ok(is_long_enough && input.block(magic.len() as u64)? == magic)
        };
        let (format, is_finished, magic) = if starts_with(ros1::MAGIC)? {
            let (connections, is_finished) = ros1::opened(&mut input)?;
            (Format::Ros1 { connections }, is_finished, ros1::MAGIC)
        } else if starts_with(mcap::MAGIC)? {
            let is_finished = mcap::is_finished(&mut input)?;
            (Format::Mcap(mcap::Schemas::default()), is_finished, mcap::MAGIC)
        } else if starts_with(sqlite::MAGIC)? {
            let database = Database::open(path, &mut input)?;
            let is_finished = database.is_finished();
            return Ok((Self::Database(database), is_finished));
        } else {
            let known = "expected a bag of ROS 1 (`#ROSBAG V2.0`), MCAP or SQLite";
            return Err(Fault::Bad(known.to_owned()));
        };
        let begin = magic.len() as u64;
        Ok((Self::Records(Records { input, format, begin }), is_finished))
    }

    /// Number of connections that the index has at least.
    pub(super) const fn indexed_min(&self) -> u32 {
        match self {
            Self::Records(Records { format: Format::Ros1 { connections }, .. }) => *connections,
            Self::Records(_) | Self::Database(_) => 0,
        }
    }

    /// What is missing of a bag that was read to its end.
    pub(super) fn unread(&self) -> Option<String> {
        match self {
            Self::Records(_) => None,
            Self::Database(database) => database.unread(),
        }
    }

    /// Tells a visitor what a bag contains.
    pub(super) fn visit(&mut self, visitor: &mut impl Visitor) -> Result<(), Stop> {
        match self {
            Self::Database(database) => database.visit(visitor),
            Self::Records(Records { input, format, begin }) => {
                let place = Place::Byte { at: *begin, chunk: None };
                input.seek(*begin).map_err(|fault| Stop::Fault(place, fault))?;
                walk(input, &mut format.clone(), None, visitor)
            }
        }
    }
}

fn walk<R: Read + Seek, V: Visitor>(
    input: &mut Input<R>,
    format: &mut Format,
    chunk: Option<u64>,
    visitor: &mut V,
) -> Result<(), Stop> {
    // In ROS 1, connections outside of chunks are the index.
    let mut in_index = matches!(format, Format::Ros1 { .. }) && chunk.is_none();
    while input.at() < input.end() {
        let at = input.at();
        let place = Place::Byte { at, chunk };
        let fault = |fault| Stop::Fault(place, fault);
        let record = match format {
            Format::Ros1 { .. } => ros1::record(input),
            Format::Mcap(schemas) => mcap::record(input, schemas),
        };
        let record = record.map_err(fault)?;
        match record.head {
            Head::Connection { id, connection } => visitor.connection(id, connection, in_index),
            Head::Message { connection, time } if visitor.wants_messages_of(connection) => {
                let data = input.block(record.content).map_err(fault)?;
                visitor.message(place, connection, time, &data).map_err(Stop::Told)?;
            }
            Head::Chunk(head) if chunk.is_none() && visitor.wants_chunk() => {
                let there = record.content.min(input.end() - input.at());
                let packed = input.block(there).map_err(fault)?;
                let (bytes, damage) = packed::unpacked(&head, packed).map_err(fault)?;
                let mut inner = Input::new(Cursor::new(bytes))
                    .map_err(|error| fault(Fault::Unreadable(error)))?;
                let ended = walk(&mut inner, format, Some(at), visitor);
                if there < record.content {
                    return ended.and(Err(fault(Fault::Cut))).map_err(|stop| match stop {
                        Stop::Fault(..) => fault(Fault::Cut),
                        told => told,
                    });
                }
                match (damage, ended) {
                    (Some(damage), Ok(()) | Err(Stop::Fault(..))) => {
                        return Err(fault(Fault::Bad(damage)));
                    }
                    (_, Err(Stop::Fault(place, Fault::Cut))) => {
                        let why = "the chunk ends within a record".to_owned();
                        return Err(Stop::Fault(place, Fault::Bad(why)));
                    }
                    (_, ended) => ended?,
                }
            }
            Head::DataEnd => in_index = true,
            Head::End => return Ok(()),
            Head::Message { .. } | Head::Chunk(_) | Head::Other => {}
        }
        input.seek(record.end).map_err(fault)?;
    }
    Ok(())
}
