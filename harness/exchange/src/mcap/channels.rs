//! The file: channels are created with their first message.

use super::schema::Schema;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, McapResult, WriteOptions, Writer};
use serde::Serialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use wire::time::Timestamp;

/// Bytes of a chunk before compression. Larger than usual: rows of one kind compress well, and 16 hours give few enough
/// chunks for an index that a reader holds in memory.
const CHUNK_BYTES: u64 = 4 * 1024 * 1024;

/// An MCAP file being written.
pub(super) struct Channels<W: Write + Seek> {
    writer: Writer<W>,
    open: BTreeMap<String, Channel>,
}

#[derive(Debug)]
struct Channel {
    id: u16,
    messages: u64,
}

/// Time in the file: nanoseconds since the start of the run, never negative.
fn nanos(at: Timestamp) -> u64 {
    u64::try_from(at.as_nanos()).unwrap_or(0)
}

impl<W: Write + Seek> Channels<W> {
    pub(super) fn new(out: W) -> McapResult<Self> {
        let options = WriteOptions::new()
            .library(concat!("hil ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            // Compressed in this thread, so that the result does not depend on the number of cores.
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES));
        Ok(Self { writer: options.create(out)?, open: BTreeMap::new() })
    }

    /// Writes a message of a topic; calls `schema` only for the first one.
    pub(super) fn send(
        &mut self,
        topic: &str,
        at: Timestamp,
        schema: impl FnOnce() -> Schema,
        message: &impl Serialize,
    ) -> McapResult<()> {
        if !self.open.contains_key(topic) {
            let schema = schema();
            let text = schema.text.to_string();
            let schema = self.writer.add_schema(&schema.name, "jsonschema", text.as_bytes())?;
            let id = self.writer.add_channel(schema, topic, "json", &BTreeMap::new())?;
            self.open.insert(topic.to_owned(), Channel { id, messages: 0 });
        }
        let Some(channel) = self.open.get_mut(topic) else { return Ok(()) };
        let data = serde_json::to_vec(message).map_err(std::io::Error::from)?;
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.messages as u32,
            log_time: nanos(at),
            publish_time: nanos(at),
        };
        channel.messages += 1;
        self.writer.write_to_known_channel(&header, &data)
    }

    pub(super) fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> McapResult<()> {
        self.writer.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: Cow::Borrowed(data),
        })
    }

    pub(super) fn metadata(
        &mut self,
        name: &str,
        facts: BTreeMap<String, String>,
    ) -> McapResult<()> {
        self.writer.write_metadata(&Metadata { name: name.to_owned(), metadata: facts })
    }

    /// Ends the file. Returns the topics with their numbers of messages.
    pub(super) fn finish(mut self) -> McapResult<(W, Vec<(String, u64)>)> {
        self.writer.finish()?;
        let topics = self.open.into_iter().map(|(topic, channel)| (topic, channel.messages));
        let topics = topics.collect();
        Ok((self.writer.into_inner(), topics))
    }
}
