//! Bags in SQLite: what is read without definitions, and defects of databases.

use super::ros::{ALONE, FIELDS, Topic, cdr_message, definition, imu, package, table, values};
use super::{FieldText, Package};
use rusqlite::{Connection, params};
use std::fs;

/// Small pages, so that a few messages are on several.
const TABLES: &str = "PRAGMA page_size = 512; \
    CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT); \
    CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);";

const DEFINITIONS: &str = "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, \
    encoding TEXT, encoded_message_definition TEXT);";

/// The bytes of a database that `fill` makes.
fn database(fill: impl FnOnce(&Connection) -> rusqlite::Result<()>) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.db3");
    let sqlite = Connection::open(&path).unwrap();
    // It need not outlast a power cut.
    sqlite.pragma_update(None, "synchronous", "off").unwrap();
    fill(&sqlite).unwrap();
    drop(sqlite);
    fs::read(path).unwrap()
}

pub(super) fn bag(topics: &[Topic], with_definitions: bool) -> Vec<u8> {
    database(|sqlite| {
        sqlite.execute_batch(TABLES)?;
        if with_definitions {
            sqlite.execute_batch(DEFINITIONS)?;
        }
        let mut messages = Vec::new();
        for (topic, id) in topics.iter().zip(1..) {
            let name = format!("p/msg/Sample{id}");
            let topics = "INSERT INTO topics VALUES (?, ?, ?, 'cdr')";
            sqlite.execute(topics, params![id, topic.name, name])?;
            if with_definitions {
                let text = definition(topic.root, "builtin_interfaces/Time stamp\nstring frame_id");
                let text = text.replace("p/Sample", &name);
                let definitions = "INSERT INTO message_definitions VALUES (NULL, ?, 'ros2msg', ?)";
                sqlite.execute(definitions, params![name, text])?;
            }
            for (time, values) in &topic.messages {
                messages.push((*time, id, cdr_message(topic, *time, values)));
            }
        }
        messages.sort();
        for (time, id, data) in messages {
            let one = "INSERT INTO messages VALUES (NULL, ?, ?, ?)";
            sqlite.execute(one, params![id, time.cast_signed(), data])?;
        }
        Ok(())
    })
}

fn changed(bytes: &[u8], sql: &str) -> Vec<u8> {
    database(|sqlite| {
        fs::write(sqlite.path().unwrap(), bytes).unwrap();
        sqlite.execute_batch(sql)
    })
}

fn told(fields: &[FieldText<'_>], bytes: &[u8]) -> String {
    let error = package("data.db3", fields, bytes).read().expect_err("a mistake").to_string();
    error.rsplit_once("data.db3: ").map_or(error.clone(), |(_, told)| told.to_owned())
}

#[test]
fn common_messages_need_no_definition() {
    let rate = |n: u64| (n * 250_000_000, vec![n as f64 * 0.5]);
    let twist = Topic {
        name: "/table",
        root: "float64 x\nfloat64 y\nfloat64 z\n",
        messages: (0..3).map(|n| (rate(n).0, vec![0.0, 0.0, rate(n).1[0]])).collect(),
    };
    let bytes = changed(
        &bag(&[twist], false),
        "UPDATE topics SET type = 'geometry_msgs/msg/Vector3'; INSERT INTO topics VALUES (9, '/own', 'my_msgs/msg/Own', 'cdr')",
    );
    let fields = [
        ("time", "time", "s", ""),
        ("/table/z", "gyro_rate", "rad/s", ""),
        ("y", "reference_rate", "rad/s", ""),
    ];
    let set = package("data.db3", &fields, &bytes).read().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(values(&set, "time"), [0.0, 0.25, 0.5]);
    assert_eq!(values(&set, "/table/z"), [0.0, 0.5, 1.0]);
    let own = [fields[0], ("/own/z", "gyro_rate", "rad/s", ""), fields[2]];
    assert_eq!(
        told(&own, &bytes),
        "topic /own: the bag has no definition of my_msgs/msg/Own, and hil knows only those of std_msgs, geometry_msgs, \
         sensor_msgs, nav_msgs and tf2_msgs; `ros2 bag convert` to MCAP adds it"
    );
}

#[test]
fn what_is_wrong_with_a_database_is_said() {
    let whole = bag(&[imu(), table()], true);
    let changed = |sql| told(&ALONE, &changed(&whole, sql));
    assert_eq!(
        changed("DROP TABLE messages; CREATE VIEW messages AS SELECT 1"),
        "the database has no table messages, as a bag of ROS 2 has"
    );
    assert_eq!(
        changed("UPDATE messages SET data = x'00010000' WHERE id = 5"),
        "message 5, topic /imu: expected 108 bytes at byte 0 of a message of 0"
    );
    assert_eq!(
        changed("UPDATE messages SET data = x'28b52ffd00' WHERE id = 5"),
        "message 5: it cannot be decompressed: incomplete frame"
    );
    assert_eq!(
        changed("UPDATE message_definitions SET encoding = 'ros2idl'"),
        "topic /imu: its definition is in ros2idl, expected ros2msg"
    );
    assert_eq!(
        changed("UPDATE topics SET serialization_format = 'cbor'"),
        "topic /imu: its messages are in cbor, expected cdr"
    );
    let mut damaged = whole.clone();
    let data = damaged.windows(2).rposition(|pair| pair == b"up").unwrap();
    // The page's kind.
    damaged[data / 512 * 512] = 99;
    assert!(
        told(&ALONE, &damaged).ends_with(": the database is damaged"),
        "{}",
        told(&ALONE, &damaged)
    );
}

#[test]
fn nothing_is_written_beside_a_database() {
    let bytes = changed(&bag(&[imu(), table()], true), "PRAGMA journal_mode = WAL");
    let package = package("data.db3", FIELDS, &bytes);
    let listed = |package: &Package| fs::read_dir(package.path()).unwrap().count();
    let before = listed(&package);
    assert_eq!((package.read().unwrap().rows(), listed(&package)), (3, before));
    package.put("data.db3-wal", b"anything");
    let told = package.read().unwrap().notices.join("\n");
    assert!(
        told.contains("data.db3 was not finished by its writer: it has 3 messages of /imu"),
        "{told}"
    );
    assert!(told.contains("data.db3-wal has changes that are not read"), "{told}");
}

#[test]
fn a_bag_that_is_compressed_as_a_whole_is_refused_by_name() {
    let told = package("data.db3.zstd", &ALONE, b"").read().unwrap_err().to_string();
    assert!(
        told.ends_with("a bag that is compressed as a whole is not read: `zstd -d` unpacks it"),
        "{told}"
    );
}
