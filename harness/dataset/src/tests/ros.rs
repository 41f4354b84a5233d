//! Tables in ROS bags: the same rows as in CSV, other topics, and defects of bags.

use super::{FieldText, Package, descriptor};
use identification::dataset::{Dataset, Role};
use mcap::records::MessageHeader;
use proptest::prelude::{ProptestConfig, any, proptest};
use std::collections::BTreeMap;
use std::io::{Cursor, Write as _};
use std::sync::LazyLock;

const IMU: &str = "Header header\nVector3 angular_velocity\nfloat64[9] covariance\n";

pub(super) fn definition(root: &str, header: &str) -> String {
    let rule = "=".repeat(80);
    format!(
        "{root}{rule}\nMSG: std_msgs/Header\n{header}\n{rule}\nMSG: p/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    )
}

/// A topic, the fields of its messages, and these after their times in nanoseconds.
pub(super) struct Topic {
    pub name: &'static str,
    pub root: &'static str,
    pub messages: Vec<(u64, Vec<f64>)>,
}

/// Three readings of a gyro. Their times are in a second of their own.
pub(super) fn imu() -> Topic {
    let message = |n: u64| (7_000_000_000 + n * 250_000_000, vec![n as f64 * 0.5 + 0.125]);
    Topic { name: "/imu", root: IMU, messages: (0..3).map(message).collect() }
}

/// The content of a message as ROS 1 has it: sequence, stamp, frame, and the numbers.
fn ros1_message(topic: &Topic, time: u64, values: &[f64]) -> Vec<u8> {
    if topic.root != IMU {
        return values.iter().flat_map(|value| value.to_le_bytes()).collect();
    }
    let words = [3, (time / 1_000_000_000) as u32, (time % 1_000_000_000) as u32, 2];
    let mut data: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    data.extend(b"up");
    let numbers = [0.0, 0.0, values[0]].into_iter().chain((0..9).map(f64::from));
    data.extend(numbers.flat_map(f64::to_le_bytes));
    data
}

/// The same as ROS 2 has it, without sequence.
pub(super) fn cdr_message(topic: &Topic, time: u64, values: &[f64]) -> Vec<u8> {
    let plain = ros1_message(topic, time, values);
    if topic.root != IMU {
        return [&[0, 1, 0, 0][..], &plain].concat();
    }
    // Frame with its zero, and padding to a multiple of 8.
    [&[0, 1, 0, 0][..], &plain[4..12], &[3, 0, 0, 0], b"up\0\0", &plain[18..]].concat()
}

fn record(op: u8, fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let mut header = Vec::new();
    for (name, value) in fields.iter().chain(&[("op", &[op][..])]) {
        header.extend(((name.len() + 1 + value.len()) as u32).to_le_bytes());
        header.extend([name.as_bytes(), b"=", value].concat());
    }
    let length = |bytes: &[u8]| (bytes.len() as u32).to_le_bytes();
    [&length(&header)[..], &header, &length(data), data].concat()
}

fn ros1(topics: &[Topic], compression: &str) -> Vec<u8> {
    let (mut connections, mut messages) = (Vec::new(), Vec::new());
    for (topic, id) in topics.iter().zip(0_u32..) {
        let text = definition(topic.root, "uint32 seq\ntime stamp\nstring frame_id");
        let whole =
            record(0, &[("type", b"p/Sample"), ("message_definition", text.as_bytes())], b"");
        // The header of a connection is the data of its record.
        let length = u32::from_le_bytes(whole[..4].try_into().unwrap()) as usize;
        let fields = [("conn", &id.to_le_bytes()[..]), ("topic", topic.name.as_bytes())];
        connections.extend(record(7, &fields, &whole[4..4 + length]));
        for (time, values) in &topic.messages {
            let stamp = [(time / 1_000_000_000) as u32, (time % 1_000_000_000) as u32];
            let stamp = stamp.map(u32::to_le_bytes).concat();
            let fields = [("conn", &id.to_le_bytes()[..]), ("time", &stamp)];
            messages.push((*time, record(2, &fields, &ros1_message(topic, *time, values))));
        }
    }
    messages.sort();
    let messages = messages.into_iter().map(|(_, message)| message);
    let content = [connections.clone(), messages.collect::<Vec<_>>().concat()].concat();
    let packed = match compression {
        "bz2" => {
            let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
            encoder.write_all(&content).unwrap();
            encoder.finish().unwrap()
        }
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            encoder.write_all(&content).unwrap();
            encoder.finish().unwrap()
        }
        _ => content.clone(),
    };
    let size = (content.len() as u32).to_le_bytes();
    let chunk = record(5, &[("compression", compression.as_bytes()), ("size", &size)], &packed);
    let count = (topics.len() as u32).to_le_bytes();
    let head = |index: u64| {
        let fields = [("index_pos", &index.to_le_bytes()[..]), ("conn_count", &count)];
        record(3, &fields, &[b' '; 8])
    };
    let magic = b"#ROSBAG V2.0\n";
    let index = magic.len() + head(0).len() + chunk.len();
    [&magic[..], &head(index as u64), &chunk, &connections].concat()
}

fn mcap(topics: &[Topic], compression: Option<mcap::Compression>) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().compression(compression).profile("ros2");
    let mut writer = options.create(&mut file).unwrap();
    let mut messages = Vec::new();
    for topic in topics {
        let text = definition(topic.root, "builtin_interfaces/Time stamp\nstring frame_id");
        let schema = writer.add_schema("p/msg/Sample", "ros2msg", text.as_bytes()).unwrap();
        let channel = writer.add_channel(schema, topic.name, "cdr", &BTreeMap::new()).unwrap();
        for (time, values) in &topic.messages {
            messages.push((*time, channel, cdr_message(topic, *time, values)));
        }
    }
    messages.sort();
    for (time, channel_id, data) in messages {
        let header = MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

pub(super) const FIELDS: &[FieldText<'static>] = &[
    ("time", "time", "s", ""),
    ("angular_velocity.z", "gyro_rate", "rad/s", ""),
    ("header.stamp", "auxiliary", "s", ""),
    ("covariance[8]", "auxiliary", "1", ""),
    ("header.frame_id", "auxiliary", "1", r#", "type": "string""#),
    ("/table/rate", "reference_rate", "rad/s", ""),
];

/// Fields of one topic.
pub(super) const ALONE: [FieldText<'static>; 3] = [
    ("time", "time", "s", ""),
    ("/imu/angular_velocity.z", "gyro_rate", "rad/s", ""),
    ("angular_velocity.x", "reference_rate", "rad/s", ""),
];

/// A turntable at twice the rate, shifted, whose first value has no row.
pub(super) fn table() -> Topic {
    let message = |n: u64| (6_940_000_000 + n * 125_000_000, vec![-(n as f64)]);
    Topic { name: "/table", root: "float64 rate\n", messages: (0..5).map(message).collect() }
}

pub(super) fn package(name: &str, fields: &[FieldText<'_>], bytes: &[u8]) -> Package {
    let package = Package::new("series", fields, "");
    package.put("datapackage.json", descriptor("series", fields, &[name]).as_bytes());
    package.put(name, bytes);
    package
}

fn bags() -> Vec<(&'static str, Vec<u8>)> {
    let topics = [imu(), table()];
    let ros1 = |compression| ("data.bag", ros1(&topics, compression));
    let mcap = |compression| ("data.mcap", mcap(&topics, compression));
    let zstd = Some(mcap::Compression::Zstd);
    let db3 = ("data.db3", super::sqlite::bag(&topics, true));
    vec![ros1("none"), ros1("bz2"), ros1("lz4"), mcap(None), mcap(zstd), db3]
}

pub(super) fn values<'a>(set: &'a Dataset, name: &str) -> &'a [f64] {
    &set.named(name).unwrap().values
}

#[test]
fn fields_of_messages_are_columns() {
    for (name, bytes) in bags() {
        let set = package(name, FIELDS, &bytes).read().unwrap_or_else(|error| panic!("{error}"));
        // The bag begins with the table, 60 ms before the gyro.
        assert_eq!(values(&set, "time"), [0.06, 0.31, 0.56], "{name}");
        assert_eq!(values(&set, "angular_velocity.z"), [0.125, 0.625, 1.125]);
        assert_eq!(values(&set, "header.stamp"), [7.0, 7.25, 7.5]);
        assert_eq!(values(&set, "covariance[8]"), [8.0; 3]);
        assert_eq!(values(&set, "header.frame_id"), [0.0; 3]);
        // Their times are 0, 0.125, 0.25, 0.375 and 0.5 s.
        assert_eq!(set.column(Role::ReferenceRate).unwrap().values, [0.0, -2.0, -4.0]);
        let told = set.notices.join("\n");
        assert!(told.contains("/table/rate has times of its own: 3 of 5 values"), "{told}");
        assert!(!told.contains("not finished"), "{told}");
    }
}

fn message(package: &Package) -> String {
    let error = package.read().expect_err("a mistake").to_string();
    error.split_once("/data.").map_or(error.clone(), |(_, rest)| format!("data.{rest}"))
}

#[test]
fn a_bag_that_is_cut_short_is_read_as_far_as_it_goes() {
    for (number, (name, bytes)) in bags().into_iter().enumerate() {
        let (mut most, mut partial) = (0, 0);
        for length in (0..bytes.len()).step_by(11) {
            let Ok(set) = package(name, &ALONE, &bytes[..length]).read() else { continue };
            let told = set.notices.iter().any(|told| told.contains("was not finished"));
            assert!(!set.notices.iter().any(|told| told.contains("olumn")), "{:?}", set.notices);
            assert!(told, "{name}, {length} bytes: {:?}", set.notices);
            assert!(set.rows() >= most, "{name}, {length} bytes");
            most = set.rows();
            partial += usize::from(most == 2);
        }
        assert_eq!(most, 3, "{name}");
        // A compressed chunk of this size is one block, which is there or not.
        let is_plain = matches!(number, 0 | 3 | 5);
        assert!(!is_plain || partial > 0, "{name}");
    }
}

#[test]
fn what_is_wrong_with_a_bag_has_its_place() {
    let of = |name: &str, bytes: &[u8]| message(&package(name, &ALONE, bytes));
    assert_eq!(
        of("data.bag", b"#ROSBAG V1.2\n"),
        "data.bag: expected a bag of ROS 1 (`#ROSBAG V2.0`), MCAP or SQLite"
    );
    let other = Topic { root: "Other other\n", ..imu() };
    assert_eq!(
        of("data.bag", &ros1(&[other], "none")),
        "data.bag: topic /imu: its definition lacks p/Other"
    );
    let longer = Topic { root: "float64 rate\nfloat64 more\n", ..table() };
    let longer = ros1(&[Topic { name: "/imu", ..longer }], "none");
    let rates = [
        ALONE[0],
        ("/imu/rate", "gyro_rate", "rad/s", ""),
        ("more", "reference_rate", "rad/s", ""),
    ];
    let found = message(&package("data.bag", &rates, &longer));
    assert!(found.starts_with("data.bag: byte "), "{found}");
    assert!(
        found.contains(", topic /imu: expected 16 bytes at byte 0 of a message of 8"),
        "{found}"
    );
    let mut damaged = mcap(&[imu()], None);
    let at = damaged.windows(2).position(|pair| pair == b"up").unwrap();
    damaged[at + 30] ^= 1;
    let found = of("data.mcap", &damaged);
    assert!(found.ends_with(": the chunk has another checksum than it says"), "{found}");
    // A finished bag stays one, whatever is wrong in it before its index.
    let message = |n: u64| (n * 10_000_000, vec![n as f64 * 0.5]);
    let long = Topic { messages: (0..5_000).map(message).collect(), ..imu() };
    let mut damaged = ros1(&[long], "lz4");
    let at = damaged.len() / 2;
    damaged[at..at + 64].fill(0xff);
    let found = of("data.bag", &damaged);
    assert!(found.starts_with("data.bag: byte 78: the chunk "), "{found}");
    let cdr = |language: &str| {
        let mut writer = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
        let schema = writer.add_schema("p/msg/Sample", language, b"float64 rate").unwrap();
        writer.add_channel(schema, "/imu", "cdr", &BTreeMap::new()).unwrap();
        writer.finish().unwrap();
        writer.into_inner().into_inner()
    };
    assert_eq!(
        of("data.mcap", &cdr("ros2idl")),
        "data.mcap: topic /imu: its definition is in ros2idl, expected ros2msg"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn no_bytes_cause_a_panic(
        bag in 0..6_usize,
        flips in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 0..4),
        cut in proptest::option::of(any::<proptest::sample::Index>()),
    ) {
        static BAGS: LazyLock<Vec<(&str, Vec<u8>)>> = LazyLock::new(bags);
        let (name, mut bytes) = BAGS[bag].clone();
        for (at, byte) in flips {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        // Any result will do.
        drop(package(name, FIELDS, &bytes).read());
    }
}
