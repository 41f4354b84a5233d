//! Bags of ROS 2 in MCAP.
//!
//! Source: the MCAP specification (mcap.dev/spec), its registry for the profile `ros2`.

use super::content::{Chunk, Connection, Head, Record};
use super::decode::Encoding;
use super::input::{Fault, Input};
use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::rc::Rc;

/// The first and the last bytes.
pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// The kind of a record.
mod op {
    pub(super) const FOOTER: u8 = 0x02;
    pub(super) const SCHEMA: u8 = 0x03;
    pub(super) const CHANNEL: u8 = 0x04;
    pub(super) const MESSAGE: u8 = 0x05;
    pub(super) const CHUNK: u8 = 0x06;
    pub(super) const DATA_END: u8 = 0x0f;
}

/// The message types that were read, by number.
#[derive(Debug, Clone, Default)]
pub(super) struct Schemas(BTreeMap<u16, Schema>);

#[derive(Debug, Clone)]
struct Schema {
    name: String,
    encoding: String,
    text: Rc<str>,
}

/// Reads a record up to its content.
pub(super) fn record<R: Read + Seek>(
    input: &mut Input<R>,
    schemas: &mut Schemas,
) -> Result<Record, Fault> {
    let [op] = input.bytes()?;
    let length = input.u64()?;
    let end = input.at().saturating_add(length);
    let head = match op {
        op::SCHEMA => {
            let id = input.u16()?;
            let (name, encoding) = (input.text()?, input.text()?);
            schemas.0.insert(id, Schema { name, encoding, text: input.text()?.into() });
            Head::Other
        }
        op::CHANNEL => {
            let (id, schema) = (input.u16()?, input.u16()?);
            let (topic, encoding) = (input.text()?, input.text()?);
            let connection = connection(topic, &encoding, schemas.0.get(&schema));
            Head::Connection { id: id.into(), connection }
        }
        op::MESSAGE => {
            let (channel, _sequence) = (input.u16()?, input.u32()?);
            let (time, _published) = (input.u64()?, input.u64()?);
            Head::Message { connection: channel.into(), time }
        }
        op::CHUNK => {
            let (_first, _last) = (input.u64()?, input.u64()?);
            let (size, crc) = (input.u64()?, input.u32()?);
            let compression = input.text()?;
            let packed = input.u64()?;
            let crc = Some(crc).filter(|crc| *crc != 0);
            let chunk = Chunk { compression, size, crc };
            check(input, end, packed)?;
            return Ok(Record { head: Head::Chunk(chunk), content: packed, end });
        }
        op::DATA_END => Head::DataEnd,
        op::FOOTER => Head::End,
        _ => Head::Other,
    };
    check(input, end, 0)?;
    Ok(Record { head, content: end - input.at(), end })
}

/// Checks that so many bytes more are in the record.
fn check<R: Read + Seek>(input: &Input<R>, end: u64, more: u64) -> Result<(), Fault> {
    if input.at().saturating_add(more) > end {
        return Err(Fault::Bad("the record is shorter than its fields".to_owned()));
    }
    Ok(())
}

fn connection(topic: String, encoding: &str, schema: Option<&Schema>) -> Connection {
    let Some(Schema { name, encoding: language, text }) = schema else {
        let encoding = Err("its channel has no schema".to_owned());
        return Connection { topic, name: String::new(), definition: "".into(), encoding };
    };
    let encoding = match (encoding, language.as_str()) {
        ("cdr", "ros2msg") => Ok(Encoding::Cdr),
        ("ros1", "ros1msg") => Ok(Encoding::Ros1),
        ("cdr" | "ros1", language) => {
            Err(format!("its definition is in {language}, expected ros2msg"))
        }
        (encoding, _) => Err(format!("its messages are in {encoding}, expected cdr")),
    };
    Connection { topic, name: name.clone(), definition: Rc::clone(text), encoding }
}

/// Whether the bag ends as it should.
pub(super) fn is_finished<R: Read + Seek>(input: &mut Input<R>) -> Result<bool, Fault> {
    let length = MAGIC.len() as u64;
    input.seek(input.end().saturating_sub(length).max(length.min(input.end())))?;
    Ok(input.block(input.end() - input.at())? == MAGIC)
}
