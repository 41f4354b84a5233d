//! Bags of ROS 1, format 2.0.
//!
//! Source: wiki.ros.org/Bags/Format/2.0.

use super::content::{Chunk, Connection, Head, Record};
use super::decode::Encoding;
use super::input::{Fault, Input};
use std::collections::BTreeMap;
use std::io::{Cursor, Read, Seek};

pub(super) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

/// The kind of a record (`op`).
mod op {
    pub(super) const MESSAGE: u8 = 0x02;
    pub(super) const BAG: u8 = 0x03;
    pub(super) const CHUNK: u8 = 0x05;
    pub(super) const CONNECTION: u8 = 0x07;
}

/// Named values of a record or of a connection.
struct Header(BTreeMap<Vec<u8>, Vec<u8>>);

impl Header {
    fn parse(bytes: Vec<u8>) -> Result<Self, Fault> {
        let mut input = Input::new(Cursor::new(bytes)).map_err(Fault::Unreadable)?;
        let mut fields = BTreeMap::new();
        let bad = || Fault::Bad("the header has no fields NAME=VALUE".to_owned());
        while input.at() < input.end() {
            let length = input.u32().map_err(|_| bad())?;
            let field = input.block(length.into()).map_err(|_| bad())?;
            let at = field.iter().position(|byte| *byte == b'=').ok_or_else(bad)?;
            fields.insert(field[..at].to_vec(), field[at + 1..].to_vec());
        }
        Ok(Self(fields))
    }

    fn value(&self, name: &str) -> Result<&[u8], Fault> {
        let missing = || Fault::Bad(format!("the header has no {name}"));
        self.0.get(name.as_bytes()).map(Vec::as_slice).ok_or_else(missing)
    }

    fn array<const N: usize>(&self, name: &str) -> Result<[u8; N], Fault> {
        let value = self.value(name)?;
        let bad = |_| Fault::Bad(format!("{name} has {} bytes, expected {N}", value.len()));
        value.try_into().map_err(bad)
    }

    fn text(&self, name: &str) -> Result<String, Fault> {
        Ok(String::from_utf8_lossy(self.value(name)?).into_owned())
    }
}

/// Reads a record up to its content.
pub(super) fn record<R: Read + Seek>(input: &mut Input<R>) -> Result<Record, Fault> {
    let length = input.u32()?;
    let header = Header::parse(input.block(length.into())?)?;
    let content = u64::from(input.u32()?);
    let end = input.at() + content;
    let u32 = |name| header.array(name).map(u32::from_le_bytes);
    let [op] = header.array("op")?;
    let head = match op {
        op::MESSAGE => {
            let [seconds, nanoseconds] = {
                let [a, b, c, d, e, f, g, h] = header.array("time")?;
                [[a, b, c, d], [e, f, g, h]].map(|bytes| u64::from(u32::from_le_bytes(bytes)))
            };
            Head::Message { connection: u32("conn")?, time: seconds * 1_000_000_000 + nanoseconds }
        }
        op::CHUNK => {
            let (compression, size) = (header.text("compression")?, u32("size")?.into());
            Head::Chunk(Chunk { compression, size, crc: None })
        }
        op::CONNECTION => {
            let (id, topic) = (u32("conn")?, header.text("topic")?);
            let given = Header::parse(input.block(content)?)?;
            let definition = given.text("message_definition")?.into();
            let (name, encoding) = (given.text("type")?, Ok(Encoding::Ros1));
            Head::Connection { id, connection: Connection { topic, name, definition, encoding } }
        }
        _ => Head::Other,
    };
    Ok(Record { head, content, end })
}

/// Number of connections in the index, and whether the bag is finished: the first record, the header of the bag, then says
/// where the index is.
pub(super) fn opened<R: Read + Seek>(input: &mut Input<R>) -> Result<(u32, bool), Fault> {
    input.seek(MAGIC.len() as u64)?;
    let length = match input.u32() {
        Err(Fault::Cut) => return Ok((0, false)),
        length => length?,
    };
    let header = match input.block(length.into()) {
        Err(Fault::Cut) => return Ok((0, false)),
        header => Header::parse(header?)?,
    };
    let [op] = header.array("op")?;
    let index = u64::from_le_bytes(header.array("index_pos")?);
    if op != op::BAG {
        return Err(Fault::Bad("expected the header of the bag as the first record".to_owned()));
    }
    let connections = u32::from_le_bytes(header.array("conn_count")?);
    Ok((connections, index != 0 && index <= input.end()))
}
