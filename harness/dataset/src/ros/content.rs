//! What a bag contains, whatever its format.

use super::super::error::DatasetError;
use super::decode::Encoding;
use super::input::Fault;
use std::fmt;
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
pub(super) enum Place {
    Byte {
        at: u64,
        /// The chunk that it is in.
        chunk: Option<u64>,
    },
    /// Identifier of a message in a database.
    Message(i64),
    /// After this one, or at the beginning.
    After(Option<i64>),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Byte { at, chunk: None } => write!(f, "byte {at}"),
            Self::Byte { at, chunk: Some(chunk) } => {
                write!(f, "byte {at} of the chunk at byte {chunk}")
            }
            Self::Message(id) => write!(f, "message {id}"),
            Self::After(Some(id)) => write!(f, "after message {id}"),
            Self::After(None) => write!(f, "before the first message"),
        }
    }
}

/// What ends the reading of a bag early.
#[derive(Debug)]
pub(super) enum Stop {
    Fault(Place, Fault),
    /// By the visitor.
    Told(DatasetError),
}

/// Receives the content of a bag.
pub(super) trait Visitor {
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
    ) -> Result<(), DatasetError>;
}
