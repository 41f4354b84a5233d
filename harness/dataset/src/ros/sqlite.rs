//! Bags of ROS 2 in SQLite, as releases up to Humble record them by default.
//!
//! Source: ros2/rosbag2, `rosbag2_storage_sqlite3` (the tables) and `rosbag2_compression_zstd` (compressed messages).

use super::content::{Connection, Place, Stop, Visitor};
use super::decode::Encoding;
use super::input::{BLOCK_BYTES_MAX, Fault, Input};
use super::standard;
use percent_encoding::{NON_ALPHANUMERIC, percent_encode};
use rusqlite::{ErrorCode, OpenFlags};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Read, Seek};
use std::path::Path;
use std::rc::Rc;

pub(super) const MAGIC: &[u8] = b"SQLite format 3\0";

/// The first bytes of a compressed message. A message in CDR begins with 0.
const ZSTD: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];

/// Files in which SQLite keeps what is not yet in the database.
const PENDING: [&str; 2] = ["-wal", "-journal"];

#[derive(Debug)]
pub(super) struct Database {
    sqlite: rusqlite::Connection,
    has_definitions: bool,
    is_cut: bool,
    /// A file with changes that are not read.
    pending: Option<String>,
}

impl Database {
    pub(super) fn open<R: Read + Seek>(path: &Path, input: &mut Input<R>) -> Result<Self, Fault> {
        let is_cut = is_cut(input)?;
        // Otherwise SQLite may write beside a file that it only reads.
        let name = percent_encode(path.as_os_str().as_encoded_bytes(), NON_ALPHANUMERIC);
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI;
        let sqlite =
            rusqlite::Connection::open_with_flags(format!("file:{name}?immutable=1"), flags);
        let sqlite = sqlite.map_err(|error| fault(&error, is_cut))?;
        let pending = PENDING.iter().find_map(|end| {
            let mut beside = path.as_os_str().to_owned();
            beside.push(end);
            let has_content = std::fs::metadata(&beside).is_ok_and(|found| found.len() > 0);
            let name = Path::new(&beside).file_name()?.to_string_lossy().into_owned();
            has_content.then_some(name)
        });
        let mut database = Self { sqlite, has_definitions: false, is_cut, pending };
        database.check_tables().map_err(|error| fault(&error, is_cut))??;
        Ok(database)
    }

    pub(super) const fn is_finished(&self) -> bool {
        !self.is_cut && self.pending.is_none()
    }

    /// What is missing of a bag of which all content can be read.
    pub(super) fn unread(&self) -> Option<String> {
        let name = self.pending.as_ref()?;
        Some(format!(
            "{name} has changes that are not read: open the bag once with sqlite3 to apply them"
        ))
    }

    fn check_tables(&mut self) -> rusqlite::Result<Result<(), Fault>> {
        // A file without its end has fewer pages than its header says, which SQLite otherwise refuses.
        self.sqlite.pragma_update(None, "writable_schema", self.is_cut)?;
        self.sqlite.pragma_update(None, "trusted_schema", false)?;
        // A view or a virtual table has no page of its own, and may never end.
        let query = "SELECT name FROM sqlite_schema WHERE type = 'table' AND rootpage > 0";
        let mut statement = self.sqlite.prepare(query)?;
        let names: Vec<String> =
            statement.query_map([], |row| row.get(0))?.collect::<Result<_, _>>()?;
        let has = |name: &str| names.iter().any(|one| one == name);
        self.has_definitions = has("message_definitions");
        let missing = ["topics", "messages"].into_iter().find(|name| !has(name));
        Ok(missing.map_or(Ok(()), |name| {
            Err(Fault::Bad(format!("the database has no table {name}, as a bag of ROS 2 has")))
        }))
    }

    pub(super) fn visit(&self, visitor: &mut impl Visitor) -> Result<(), Stop> {
        let mut last = None;
        let fail = |place, error| Stop::Fault(place, fault(&error, self.is_cut));
        for (id, connection) in
            self.connections().map_err(|error| fail(Place::After(None), error))?
        {
            visitor.connection(id, connection, true);
        }
        let query = "SELECT rowid, topic_id, timestamp, data FROM messages ORDER BY rowid";
        let mut statement =
            self.sqlite.prepare(query).map_err(|error| fail(Place::After(None), error))?;
        let mut rows = statement.query([]).map_err(|error| fail(Place::After(None), error))?;
        while visitor.wants_chunk()
            && let Some(row) = rows.next().map_err(|error| fail(Place::After(last), error))?
        {
            let id: i64 = row.get(0).map_err(|error| fail(Place::After(last), error))?;
            // Pages behind the end of a file are zeros.
            let place = if self.is_cut { Place::After(last) } else { Place::Message(id) };
            let damaged = |error| fail(place, error);
            let topic: u32 = row.get(1).map_err(damaged)?;
            if visitor.wants_messages_of(topic) {
                let time: i64 = row.get(2).map_err(damaged)?;
                let data = row.get_ref(3).map_err(damaged)?.as_blob_or_null();
                let data = data.map_err(|error| damaged(error.into()))?.unwrap_or_default();
                let data = plain(data).map_err(|fault| Stop::Fault(Place::Message(id), fault))?;
                let told = visitor.message(Place::Message(id), topic, time.cast_unsigned(), &data);
                told.map_err(Stop::Told)?;
            }
            last = Some(id);
        }
        Ok(())
    }

    fn connections(&self) -> rusqlite::Result<Vec<(u32, Connection)>> {
        let mut definitions = BTreeMap::<String, (String, Rc<str>)>::new();
        if self.has_definitions {
            let mut statement = self.sqlite.prepare(
                "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions",
            )?;
            let mut rows = statement.query([])?;
            while let Some(row) = rows.next()? {
                definitions.insert(row.get(0)?, (row.get(1)?, row.get(2)?));
            }
        }
        let mut statement =
            self.sqlite.prepare("SELECT id, name, type, serialization_format FROM topics")?;
        let connection = |row: &rusqlite::Row<'_>| {
            let (name, format): (String, String) = (row.get(2)?, row.get(3)?);
            let (definition, encoding) = match definitions.get(&name) {
                _ if format != "cdr" => {
                    (None, Err(format!("its messages are in {format}, expected cdr")))
                }
                Some((language, text)) if language == "ros2msg" => {
                    (Some(Rc::clone(text)), Ok(Encoding::Cdr))
                }
                found => match (standard::definition(&name), found) {
                    (Some(text), _) => (Some(text), Ok(Encoding::Cdr)),
                    (None, Some((language, text))) if !text.is_empty() => {
                        (None, Err(format!("its definition is in {language}, expected ros2msg")))
                    }
                    (None, _) => (None, Err(standard::unknown(&name))),
                },
            };
            let definition = definition.unwrap_or_default();
            Ok((row.get(0)?, Connection { topic: row.get(1)?, name, definition, encoding }))
        };
        statement.query_map([], connection)?.collect()
    }
}

/// Whether the file has fewer pages than its header says.
fn is_cut<R: Read + Seek>(input: &mut Input<R>) -> Result<bool, Fault> {
    input.seek(MAGIC.len() as u64)?;
    let page = match input.bytes().map(u16::from_be_bytes)? {
        1 => 65_536,
        bytes => u64::from(bytes),
    };
    input.seek(28)?;
    let pages = u64::from(input.bytes().map(u32::from_be_bytes)?);
    Ok(input.end() < page * pages)
}

fn fault(error: &rusqlite::Error, is_cut: bool) -> Fault {
    match error.sqlite_error_code() {
        Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase) | None if is_cut => Fault::Cut,
        Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase) => {
            Fault::Bad("the database is damaged".to_owned())
        }
        Some(_) => Fault::Unreadable(io::Error::other(error.to_string())),
        None => Fault::Bad(error.to_string()),
    }
}

/// A message after decompression, if it is compressed.
fn plain(data: &[u8]) -> Result<Cow<'_, [u8]>, Fault> {
    if !data.starts_with(ZSTD) {
        return Ok(Cow::Borrowed(data));
    }
    let bad = |error: io::Error| Fault::Bad(format!("it cannot be decompressed: {error}"));
    let mut message = Vec::new();
    let decoder = zstd::stream::read::Decoder::with_buffer(data).map_err(bad)?;
    decoder.take(BLOCK_BYTES_MAX + 1).read_to_end(&mut message).map_err(bad)?;
    if message.len() as u64 > BLOCK_BYTES_MAX {
        return Err(Fault::Bad(format!("it has more than {BLOCK_BYTES_MAX} bytes")));
    }
    Ok(Cow::Owned(message))
}
