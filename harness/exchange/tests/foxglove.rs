//! Reads the file back with the library of Foxglove's makers, and checks each message against its schema.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use controller::mission::Report;
use exchange::Exported;
use exchange::mcap::export;
use exchange::tables::{Ears, survey};
use harness::operator::Answers;
use harness::run::{self, Prepared, run_to_folder};
use jsonschema::Validator;
use mcap::{MessageStream, Summary};
use plan::made::Made;
use proptest::prelude::*;
use record::header::Header;
use record::outcome::samples::summary;
use record::run_folder::RunFolder;
use record::samples::{any_record, one_of_each};
use record::sink::{Level, RecordSink};
use record::{Record, RecordKind};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The messages of each topic, checked against their schemas and for ascending times.
fn read(bytes: &[u8]) -> BTreeMap<String, Vec<Value>> {
    let mut topics: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    let mut validators: BTreeMap<String, Validator> = BTreeMap::new();
    let mut last = 0;
    for message in MessageStream::new(bytes).unwrap() {
        let message = message.unwrap();
        let (channel, data) = (&message.channel, serde_json::from_slice(&message.data).unwrap());
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!((&*channel.message_encoding, &*schema.encoding), ("json", "jsonschema"));
        let validator = validators.entry(channel.topic.clone()).or_insert_with(|| {
            let schema: Value = serde_json::from_slice(&schema.data).unwrap();
            assert!(!schema.to_string().contains("$ref"));
            jsonschema::validator_for(&schema).unwrap()
        });
        if let Err(error) = validator.validate(&data) {
            panic!("{} {}: {error}", channel.topic, data);
        }
        assert!(message.log_time >= last, "{}: {} after {last}", channel.topic, message.log_time);
        last = message.log_time;
        topics.entry(channel.topic.clone()).or_default().push(data);
    }
    topics
}

fn folder(path: &Path, records: &[Record]) -> RunFolder {
    let folder = RunFolder::create(path).unwrap();
    let mut sink = folder.record_sink(&Header::default(), Level::Full).unwrap();
    records.iter().cloned().for_each(|record| sink.record(record));
    sink.finish();
    folder
}

#[test]
fn each_kind_of_record_has_its_messages() {
    let dir = tempfile::tempdir().unwrap();
    let run = folder(&dir.path().join("run"), &one_of_each());
    run.write_summary(&summary()).unwrap();
    let file = dir.path().join("run.mcap");
    let exported = export(&run, survey(&run).unwrap(), &file, Ears::of_base()).unwrap();
    let bytes = fs::read(&file).unwrap();
    let topics = read(&bytes);
    let counts: Vec<_> =
        topics.iter().map(|(topic, messages)| (topic.clone(), messages.len() as u64)).collect();
    assert_eq!(counts, exported.written);
    let shown = topics.iter().flat_map(|(topic, messages)| {
        messages.iter().map(move |message| format!("{topic} {message}"))
    });
    insta::assert_snapshot!(shown.collect::<Vec<_>>().join("\n"));
}

#[test]
#[cfg(unix)]
fn a_link_is_not_followed_out_of_the_run() {
    let dir = tempfile::tempdir().unwrap();
    let run = folder(&dir.path().join("run"), &one_of_each());
    let name = "key.toml".to_owned();
    let theirs = dir.path().join("theirs.toml");
    fs::write(&theirs, "secret = 1").unwrap();
    std::os::unix::fs::symlink(&theirs, run.file(&name)).unwrap();
    run.write_summary(&record::outcome::Summary { artifacts: vec![name], ..summary() }).unwrap();
    let file = dir.path().join("run.mcap");
    export(&run, survey(&run).unwrap(), &file, Ears::of_base()).unwrap();
    let index = Summary::read(&fs::read(&file).unwrap()).unwrap().unwrap();
    let attached: Vec<_> = index.attachment_indexes.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(attached, ["summary.json"]);
}

const SIDE: &str = r#"
name = "side"
title = "A side and back, on a serial line"
devices = "paper-serial"
steps = [
    { place = { x_m = 1, y_m = 2, heading_deg = 90 } },
    { bias_test = { duration_s = 5 } },
    { lap = { direction = "ccw", side_m = 1, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
]

[[measurement]]
name = "return_heading"
doc = "Heading after the lap"
quantity = "lap.return_heading"
unit = "deg"
check = { all_within = [-20, 20] }
"#;

fn driven(dir: &Path, name: &str) -> (RunFolder, Vec<u8>, Exported) {
    let plan = dir.join("side.toml");
    fs::write(&plan, SIDE).unwrap();
    let prepared = Prepared::load(plan.to_str().unwrap(), &Made::default()).unwrap();
    let out = dir.join(name);
    let options =
        run::Options { seed: 3, out: &out, level: Level::Full, answers: Answers::default() };
    // The machine's time differs between runs.
    let wall_s = name.len() as f64;
    run_to_folder(&prepared, &options, &mut |_| true, &|| wall_s).unwrap();
    let folder = RunFolder::open(&out).unwrap();
    let file = dir.join(format!("{name}.mcap"));
    let exported = export(&folder, survey(&folder).unwrap(), &file, Ears::of_base()).unwrap();
    (folder, fs::read(&file).unwrap(), exported)
}

#[test]
fn a_run_of_a_seed_is_one_file_and_holds_its_record() {
    let dir = tempfile::tempdir().unwrap();
    let (run, bytes, exported) = driven(dir.path(), "first");
    assert_eq!(bytes, driven(dir.path(), "another").1, "byte for byte");
    assert!(exported.survey.cut.is_none());
    let topics = read(&bytes);
    let messages = |topic: &str| topics.get(topic).map_or(0, Vec::len);

    let records: Vec<Record> = run.records().unwrap().map(Result::unwrap).collect();
    let recorded =
        |is: fn(&RecordKind) -> bool| records.iter().filter(|record| is(&record.kind)).count();
    let states = recorded(|kind| matches!(kind, RecordKind::Report(Report::State(_))));
    let truths = recorded(|kind| matches!(kind, RecordKind::Truth { .. }));
    assert!(states > 0 && truths > 0);
    assert_eq!([messages("/controller/state"), messages("/base/pose")], [states, states]);
    assert_eq!([messages("/base/truth"), messages("/base/true_pose")], [truths, truths]);
    let packets = recorded(|kind| matches!(kind, RecordKind::Bytes(_)));
    assert_eq!(messages("/serial/packets"), packets);
    let observed: usize = topics
        .iter()
        .filter(|(topic, _)| topic.starts_with("/observations/"))
        .map(|(_, all)| all.len())
        .sum();
    assert_eq!(observed, recorded(|kind| matches!(kind, RecordKind::Observation(_))));

    // Messages of the base on its serial line, decoded between the two ends.
    let motion = &topics["/messages/MOTION"];
    assert!(motion.iter().any(|message| message["MOVING"] == 1.0), "{} motions", motion.len());
    assert!(messages("/messages/SET_VELOCITY") > 100);

    // One lap: both paths are 4 m long and closed; the measured return is close to the start of the lap.
    for topic in ["/base/path", "/base/true_path"] {
        let [path] = &topics[topic][..] else { panic!("{topic}: {} paths", messages(topic)) };
        let poses = path["poses"].as_array().unwrap();
        let place = |pose: &Value| ["x", "y"].map(|name| pose["position"][name].as_f64().unwrap());
        let steps = poses.windows(2).map(|pair| {
            let ([a, b], [c, d]) = (place(&pair[0]), place(&pair[1]));
            (a - c).hypot(b - d)
        });
        let length: f64 = steps.sum();
        assert!((length - 4.0).abs() < 0.1, "{topic}: {length} m");
        let [x, y] = place(&poses[0]);
        assert!((x - 1.0).abs() < 0.01 && (y - 2.0).abs() < 0.01, "{x} {y}");
    }
    assert_eq!(messages("/absolute/lap_return"), 1);
    let start =
        topics["/tf"].iter().find(|message| message["child_frame_id"] == "lap_start").unwrap();
    assert!((start["translation"]["y"].as_f64().unwrap() - 2.0).abs() < 0.01, "{start}");
    let verdict = &topics["/plan/measurements"][0];
    assert_eq!((&verdict["name"], &verdict["verdict"]), (&"return_heading".into(), &"pass".into()));

    let index = Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(index.attachment_indexes.len(), 1);
    assert_eq!(
        index.stats.unwrap().message_count,
        exported.written.iter().map(|(_, n)| n).sum::<u64>()
    );
}

#[test]
fn names_from_outside_break_nothing() {
    let text = "a\"b\\{}\n\u{0}\u{1b}[2J, é";
    let mut records = one_of_each();
    for record in &mut records {
        match &mut record.kind {
            RecordKind::Note(note) => *note = text.to_owned(),
            RecordKind::StepBegan { path, title } => {
                (*path, *title) = (text.to_owned(), text.to_owned())
            }
            RecordKind::Observation(observation) => {
                observation.quantity = text.to_owned();
                observation.tags.insert(text.to_owned(), f64::NAN);
            }
            RecordKind::Fault(fault) => fault.name = text.to_owned(),
            _ => {}
        }
    }
    let dir = tempfile::tempdir().unwrap();
    let run = folder(&dir.path().join("run"), &records);
    let file = dir.path().join("run.mcap");
    export(&run, survey(&run).unwrap(), &file, Ears::deaf()).unwrap();
    let topics = read(&fs::read(&file).unwrap());
    assert_eq!(topics["/plan/notes"][0]["text"], text);
    assert_eq!(topics["/plan/steps"][0]["subject"], text);
    let plain =
        |topic: &String| topic.chars().all(|c| c.is_ascii_alphanumeric() || "/_".contains(c));
    assert!(topics.keys().all(plain), "{:?}", topics.keys());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn any_record_becomes_messages_of_their_schemas(mut records in prop::collection::vec(any_record(), 1..30)) {
        records.sort_by_key(|record| record.at);
        let dir = tempfile::tempdir().unwrap();
        let run = folder(&dir.path().join("run"), &records);
        let file = dir.path().join("run.mcap");
        let exported = export(&run, survey(&run).unwrap(), &file, Ears::of_base()).unwrap();
        let topics = read(&fs::read(&file).unwrap());
        prop_assert_eq!(topics.len(), exported.written.len());
    }
}
