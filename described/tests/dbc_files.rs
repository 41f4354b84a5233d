//! Real DBC files: those of the folder `HIL_TESTS_DBC_FILES`, compared with cantools over random numbers in every
//! signal. `HIL_TESTS_PYTHON` names a Python with cantools.

#![expect(clippy::unwrap_used, reason = "in a test what cannot go on may panic")]

use described::{Dbc, Decoder, Layout, dbc_text};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;
use wire::can::{CanFrame, ExtendedId, FdFlags, Id, StandardId};
use wire::device::Transmit;

/// Rounding of a double for a value with a factor and an offset.
const ROUNDING: f64 = 1e-12;

fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("HIL_TESTS_DBC_FILES").map(PathBuf::from);
    if folder.is_none() {
        skips::skip("no folder of DBC files", "HIL_TESTS_DBC_FILES names one");
    }
    folder
}

/// The layout of the file; `None` if it has no node and no message.
fn layout(path: &str) -> Option<Layout> {
    let bytes = std::fs::read(path).unwrap();
    let text = dbc_text(&bytes);
    let dbc = Dbc::parse(path, &text).unwrap_or_else(|error| panic!("{path}: {error}"));
    Some(dbc.layout(&dbc.nodes().first()?.name).unwrap())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn frame(message: &Value, data: &str) -> CanFrame {
    let byte = |at: usize| u8::from_str_radix(&data[at..at + 2], 16).unwrap();
    let data: Vec<u8> = (0..data.len()).step_by(2).map(byte).collect();
    let id = u32::try_from(message["id"].as_u64().unwrap()).unwrap();
    let id = match message["extended"].as_bool().unwrap() {
        true => Id::Extended(ExtendedId::new(id).unwrap()),
        false => Id::Standard(StandardId::new(u16::try_from(id).unwrap()).unwrap()),
    };
    match message["fd"].as_bool().unwrap() {
        true => CanFrame::fd(id, FdFlags::default(), &data).unwrap(),
        false => CanFrame::new(id, &data).unwrap(),
    }
}

/// Counts by kind of observation.
#[derive(Debug, Default)]
struct Counts(BTreeMap<&'static str, usize>);

impl Counts {
    fn add(&mut self, what: &'static str, count: usize) {
        *self.0.entry(what).or_default() += count;
    }

    fn of(&self, what: &str) -> usize {
        self.0.get(what).copied().unwrap_or_default()
    }
}

/// Compares the values of a frame with those of cantools; whatever the layout lacks must be in its notes.
fn decode(
    decoder: &mut Decoder,
    place: &str,
    frame: &CanFrame,
    theirs: &Value,
    counts: &mut Counts,
) -> Option<(usize, Vec<f64>)> {
    let layout = decoder.layout().clone();
    let decoded = decoder.frame(frame)?;
    let message = &layout.messages()[decoded.message];
    let theirs = theirs.as_object().unwrap();
    let mut values = vec![f64::NAN; message.signals.len()];
    let mut is_whole = true;
    for (name, value) in theirs {
        let place = format!("{place}.{name} of {}", hex(frame.data()));
        let Some(signal) = message.signals.iter().position(|signal| signal.name == *name) else {
            let path = format!("{}.{name}", message.name);
            assert!(layout.left_out(&path).is_some(), "{place} is missing without a note");
            counts.add("signals left out with a note", 1);
            is_whole = false;
            continue;
        };
        let theirs = value.as_f64().unwrap();
        let ours = decoded.values[signal].unwrap_or_else(|| panic!("{place} is not carried"));
        let is_same = (ours - theirs).abs() <= ROUNDING * theirs.abs().max(1.0);
        assert!(is_same, "{place}: {ours}, by cantools {theirs}");
        values[signal] = theirs;
        counts.add("values decoded", 1);
    }
    let carried = decoded.values.iter().flatten().count();
    assert!(
        carried <= theirs.len(),
        "{place}: {} carries more than by cantools",
        hex(frame.data())
    );
    is_whole.then_some((decoded.message, values))
}

/// Compares the frame with that of cantools; values out of range must be refused.
fn encode(
    layout: &Layout,
    (message, values): (usize, &[f64]),
    place: &str,
    theirs: &CanFrame,
    counts: &mut Counts,
) {
    let of = &layout.messages()[message];
    match layout.encode(message, values) {
        Ok(Transmit::Frame(ours)) => {
            assert_eq!(hex(ours.data()), hex(theirs.data()), "{place} with {values:?}");
            counts.add("frames encoded", 1);
        }
        Err(described::EncodeError::OutOfRange { .. }) => {
            let is_out = of
                .signals
                .iter()
                .zip(values)
                .any(|(signal, value)| *value < signal.minimum || *value > signal.maximum);
            assert!(is_out, "{place}: {values:?} is refused");
            counts.add("frames refused for a value out of its range", 1);
        }
        other => panic!("{place}: {other:?}"),
    }
}

#[test]
fn frames_of_any_dbc_are_those_of_cantools() {
    let Some(folder) = folder() else { return };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/interop/dbc_frames.py");
    let python = std::env::var_os("HIL_TESTS_PYTHON").unwrap_or_else(|| "python3".into());
    let mut counts = Counts::default();
    let said = Command::new(python).arg(script).arg(folder).output().unwrap();
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    for line in String::from_utf8(said.stdout).unwrap().lines() {
        let of_file: Value = serde_json::from_str(line).unwrap();
        let path = of_file["file"].as_str().unwrap();
        // Files that cantools cannot read are read too.
        let layout = layout(path);
        counts.add("files", 1);
        let Some(messages) = of_file["messages"].as_array() else { continue };
        counts.add("files that cantools reads", 1);
        let Some(layout) = layout else {
            assert!(messages.is_empty(), "{path}");
            continue;
        };
        let mut decoder = layout.decoder();
        for message in messages {
            let name = message["name"].as_str().unwrap();
            let Some(frames) = message["frames"].as_array() else {
                counts.add("messages that cantools cannot encode", 1);
                continue;
            };
            let place = format!("{path}: {name}");
            if layout.find(name).is_none() && layout.left_out(name).is_some() {
                counts.add("messages left out with a note", 1);
                continue;
            }
            counts.add("messages", 1);
            for one in frames {
                let theirs = frame(message, one[0].as_str().unwrap());
                decoder.reset();
                match decode(&mut decoder, &place, &theirs, &one[1], &mut counts) {
                    Some((index, values)) => {
                        encode(&layout, (index, &values), &place, &theirs, &mut counts)
                    }
                    None => counts.add("frames not whole", 1),
                }
            }
        }
    }
    println!("{counts:#?}");
    assert!(counts.of("files that cantools reads") > 0);
    assert!(counts.of("values decoded") > 10 * counts.of("signals left out with a note"));
}
