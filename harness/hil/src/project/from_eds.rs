//! A project for a CANopen device with a given EDS: every object is what the EDS says, and a plan starts the device and
//! receives its PDOs.

use super::from_dbc::{least_of, of, unique};
use super::written::{number, text};
use super::{FromDbc, ProjectFile, Template, with_schemas};
use described::{Description, Dictionary, Entry, FileError, Layout, Sender, dbc_text};
use plan::{Name, unit_of};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Node identifier if neither the user nor a DCF says one. Assumption: the first one is as good as any.
const NODE_ID: u8 = 1;

/// How long the plan listens before and after it starts the device, and the period of its SYNC, s.
const BOOTING_S: f64 = 0.5;
const TALKING_S: f64 = 6.0;
const SYNC_S: f64 = 0.02;

/// Share of the expected messages that must arrive.
const HEARD_SHARE: f64 = 0.9;

/// Generates a project for the device of this EDS or DCF; `file` names it in messages.
///
/// # Errors
///
/// When the file cannot be read, or the node identifier is invalid.
pub fn from_eds(
    name: &Name,
    file: &str,
    bytes: &[u8],
    node_id: Option<u8>,
) -> Result<FromDbc, Box<FileError>> {
    let eds = dbc_text(bytes);
    let read = |node: &str| {
        let head = format!("name = \"{name}\"\neds = {}\n{node}", text(file));
        Description::parse("the device", &head, &mut |_| Ok(eds.to_string()))
    };
    let said = |id: u8| format!("node_id = {id}\n");
    // A DCF says its own.
    let node = node_id.map_or_else(String::new, said);
    let (node, known) = match read(&node) {
        Err(_) if node_id.is_none() => (said(NODE_ID), read(&said(NODE_ID))),
        known => (node, known),
    };
    let known = known.map_err(Box::new)?;
    let layout = known.layout();
    let dictionary = layout.dictionary().map(AsRef::as_ref);
    let of_template = Template::Can.named(name).into_iter();
    let benches = of_template.filter(|file| file.path.starts_with("benches"));
    let readme = include_str!("from_eds.md").replace("mydevice", name.as_str());
    let made = [
        ProjectFile { path: format!("devices/{name}.eds").into(), bytes: bytes.to_owned() },
        ProjectFile::of_text(format!("devices/{name}.toml"), device(name, &node, dictionary)),
        ProjectFile::of_text("talks.toml", plan(name, layout, dictionary)),
        ProjectFile::of_text("README.md", readme),
    ];
    let files = with_schemas(made.into_iter().chain(benches).collect());
    Ok(FromDbc { files, notes: layout.notes().to_vec() })
}

fn device(name: &Name, node: &str, dictionary: Option<&Dictionary>) -> String {
    let mut toml = format!(
        "# Emulates the device. `hil emulate device devices/{name}.toml` puts it on a port.\n\
         name = \"{name}\"\ntitle = \"The device of {name}.eds\"\neds = \"{name}.eds\"\n{node}\n"
    );
    let objects = || dictionary.into_iter().flat_map(Dictionary::objects);
    let written: Vec<&str> = objects().filter(|one| one.is_writable()).map(Entry::name).collect();
    if !written.is_empty() {
        let _ = writeln!(toml, "# Masters write these objects. Expressions can use their names:");
        let lines = written.iter().map(|name| format!("# {name}\n"));
        toml.extend(lines);
    }
    for object in objects().filter(|object| !object.is_writable()) {
        let _ = write!(
            toml,
            "\n# {}\n[object.{}]\nexpression = \"{}\"\n",
            object.title().replace(|c: char| c.is_control(), " "),
            object.name(),
            number(object.start())
        );
    }
    toml
}

fn plan(name: &Name, layout: &Layout, dictionary: Option<&Dictionary>) -> String {
    let has = |name: &str| layout.find(name).is_some();
    let has_sync = has("SYNC");
    let sync = match has_sync {
        true => format!("    {{ send = {{ message = \"SYNC\", every_s = {SYNC_S} }} }},\n"),
        false => String::new(),
    };
    let kind = dictionary.and_then(|known| known.find(0x1000, 0).ok()).map(Entry::start);
    let asks = if kind.is_some() && has("SDO_request") {
        "    { sdo = { index = 0x1000, read = \"device_type\" } },\n"
    } else {
        ""
    };
    let mut toml = format!(
        "# Does the device boot, answer, and send its PDOs? `hil run talks.toml`\n\
         name = \"talks\"\n\
         title = \"{name} boots, answers, and sends its PDOs with values that the EDS allows\"\n\
         device = \"{name}\"\n\n\
         steps = [\n    {{ wait = {{ duration_s = {BOOTING_S} }}, label = \"booting\" }},\n{asks}\
         \x20   {{ send = {{ message = \"NMT\", set = {{ command = 1 }} }} }},\n{sync}\
         \x20   {{ wait = {{ duration_s = {TALKING_S} }}, label = \"talking\" }},\n]\n"
    );
    let mut names = BTreeSet::new();
    // How many values there are at least: a device that goes silent must not pass.
    let mut measure = |(name, doc): (&str, &str), quantity: &str, unit: &str, band, least: u32| {
        let [lower, upper]: [f64; 2] = band;
        let _ = write!(
            toml,
            "\n[[measurement]]\nname = \"{}\"\ndoc = {}\nquantity = \"{quantity}\"\nunit = {}\n\
             check = {{ all_within = [{}, {}] }}\nobservations_min = {least}\n",
            unique("its", name, &mut names),
            text(doc),
            text(unit),
            number(lower),
            number(upper)
        );
    };
    let heartbeat_s = dictionary.and_then(|known| known.find(0x1017, 0).ok());
    let heartbeat_s = heartbeat_s.map(|entry| entry.start() / 1e3).filter(|period| *period > 0.0);
    measure(
        ("state", "A state of NMT, from the boot-up message on"),
        "signal.nmt_state",
        "1",
        [0.0, 127.0],
        heartbeat_s.map_or(1, |period_s| least_of(HEARD_SHARE * (BOOTING_S + TALKING_S), period_s)),
    );
    if let Some(kind) = kind.filter(|_| !asks.is_empty()) {
        let what = ("device_type", "The device type, 1000h");
        measure(what, "sdo.device_type", "1", [kind, kind], 1);
    }
    for message in of(layout, Sender::Device) {
        let pdo = message.name.strip_prefix("TPDO").and_then(|number| number.parse().ok());
        let is_sent = |pdo: u16| dictionary.is_some_and(|known| known.sends_pdo(pdo));
        let Some(pdo) = pdo.filter(|pdo| is_sent(*pdo)) else { continue };
        let period_s = dictionary.and_then(|known| period_s(known, pdo, has_sync));
        let least = period_s.map_or(1, |period_s| least_of(HEARD_SHARE * TALKING_S, period_s));
        for signal in &message.signals {
            let of = format!("{}.{}", message.name, signal.name);
            let doc = format!("{of} in the limits that the EDS gives");
            let band = [signal.minimum, signal.maximum];
            measure((&of, &doc), &format!("signal.{of}"), &unit_of(signal), band, least);
        }
    }
    toml
}

/// The time between two of a PDO, as its parameters say; `None` if it is sent at events alone.
fn period_s(dictionary: &Dictionary, pdo: u16, has_sync: bool) -> Option<f64> {
    let setting = |sub| dictionary.find(0x17FF + pdo, sub).ok().map(Entry::start);
    match setting(2) {
        Some(syncs @ 1.0..=240.0) => has_sync.then_some(syncs * SYNC_S),
        _ => setting(5).filter(|period_ms| *period_ms > 0.0).map(|period_ms| period_ms / 1e3),
    }
}
