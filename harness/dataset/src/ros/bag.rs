//! The records of a bag, in the order of the file. Records of a chunk are like those outside.

use super::decode::Encoding;
use super::input::{Fault, Input};
use super::{mcap, packed, ros1};
use std::fmt;
use std::io::{Cursor, Read, Seek};
use std::rc::Rc;

/// What publishes messages of one type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Connection {
    pub topic: String,
    /// Name of the message type.
    pub name: String,
    pub definition: Rc<str>,
    /// The encoding of its messages, or why they are not read.
    pub encoding: Result<Encoding, String>,
}

/// A record, read up to its content.
#[derive(Debug)]
pub(super) struct Record {
    pub head: Head,
    /// Bytes of the content, which follows.
    pub content: u64,
    /// Where the next record begins.
    pub end: u64,
}

#[derive(Debug)]
pub(super) enum Head {
    Connection {
        id: u32,
        connection: Connection,
    },
    /// `time` is that of the recording, in nanoseconds.
    Message {
        connection: u32,
        time: u64,
    },
    Chunk(Chunk),
    /// What follows is an index.
    DataEnd,
    End,
    Other,
}

/// Records that are stored together, compressed or not.
#[derive(Debug)]
pub(super) struct Chunk {
    pub compression: String,
    /// Bytes after decompression.
    pub size: u64,
    /// CRC-32 of these, if known.
    pub crc: Option<u32>,
}

/// Place of a record.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    at: u64,
    /// The chunk that it is in.
    chunk: Option<u64>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "byte {}", self.at)?;
        self.chunk.map_or(Ok(()), |chunk| write!(f, " of the chunk at byte {chunk}"))
    }
}

/// What ends the reading of a bag early.
#[derive(Debug)]
pub(super) enum Stop<E> {
    Fault(Place, Fault),
    /// By the visitor.
    Told(E),
}

/// Receives the content of a bag.
pub(super) trait Visitor {
    type Error;

    /// A connection, which may come several times.
    fn connection(&mut self, id: u32, connection: Connection, in_index: bool) {
        let _ = (id, connection, in_index);
    }

    /// Whether to look into the next chunk.
    fn wants_chunk(&self) -> bool {
        true
    }

    fn wants_messages_of(&self, connection: u32) -> bool;

    fn message(
        &mut self,
        place: Place,
        connection: u32,
        time: u64,
        data: &[u8],
    ) -> Result<(), Self::Error>;
}

/// The container of a bag.
#[derive(Debug, Clone)]
pub(super) enum Format {
    Ros1 {
        /// Number of connections in the index.
        connections: u32,
    },
    Mcap(mcap::Schemas),
}

impl Format {
    /// Recognises the format and whether the recorder finished the bag.
    pub(super) fn of<R: Read + Seek>(input: &mut Input<R>) -> Result<(Self, bool), Fault> {
        let mut starts_with = |magic: &[u8]| {
            let is_long_enough = input.end() >= magic.len() as u64;
            input.seek(0)?;
            Ok(is_long_enough && input.block(magic.len() as u64)? == magic)
        };
        if starts_with(ros1::MAGIC)? {
            let (connections, is_finished) = ros1::opened(input)?;
            Ok((Self::Ros1 { connections }, is_finished))
        } else if starts_with(mcap::MAGIC)? {
            Ok((Self::Mcap(mcap::Schemas::default()), mcap::is_finished(input)?))
        } else {
            Err(Fault::Bad("expected a bag of ROS 1 (`#ROSBAG V2.0`) or MCAP".to_owned()))
        }
    }

    const fn magic_bytes(&self) -> usize {
        match self {
            Self::Ros1 { .. } => ros1::MAGIC.len(),
            Self::Mcap(_) => mcap::MAGIC.len(),
        }
    }
}

/// Tells a visitor what a bag contains.
pub(super) fn visit<R: Read + Seek, V: Visitor>(
    input: &mut Input<R>,
    format: &Format,
    visitor: &mut V,
) -> Result<(), Stop<V::Error>> {
    let begin = format.magic_bytes() as u64;
    let place = Place { at: begin, chunk: None };
    input.seek(begin).map_err(|fault| Stop::Fault(place, fault))?;
    walk(input, &mut format.clone(), None, visitor)
}

fn walk<R: Read + Seek, V: Visitor>(
    input: &mut Input<R>,
    format: &mut Format,
    chunk: Option<u64>,
    visitor: &mut V,
) -> Result<(), Stop<V::Error>> {
    // In ROS 1, connections outside of chunks are the index.
    let mut in_index = matches!(format, Format::Ros1 { .. }) && chunk.is_none();
    while input.at() < input.end() {
        let place = Place { at: input.at(), chunk };
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
                let ended = walk(&mut inner, format, Some(place.at), visitor);
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
