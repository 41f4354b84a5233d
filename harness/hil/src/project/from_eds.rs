//! A project for a CANopen device with a given EDS: every object is what the EDS says, and a plan starts the device and
//! receives its PDOs.

use super::from_dbc::{of, unique};
use super::written::{number, text};
use super::{FromDbc, ProjectFile, Template, with_schemas};
use described::{Description, Dictionary, Entry, FileError, Layout, Sender, dbc_text};
use plan::{Name, unit_of};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Node identifier if neither the user nor a DCF says one. Assumption: the first one is as good as any.
const NODE_ID: u8 = 1;

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
    let sync =
        if has("SYNC") { "    { send = { message = \"SYNC\", every_s = 0.02 } },\n" } else { "" };
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
         steps = [\n    {{ wait = {{ duration_s = 0.5 }}, label = \"booting\" }},\n{asks}\
         \x20   {{ send = {{ message = \"NMT\", set = {{ command = 1 }} }} }},\n{sync}\
         \x20   {{ wait = {{ duration_s = 6 }}, label = \"talking\" }},\n]\n"
    );
    let mut names = BTreeSet::new();
    let mut measure = |name: &str, doc: &str, quantity: &str, unit: &str, band: [f64; 2]| {
        let _ = write!(
            toml,
            "\n[[measurement]]\nname = \"{}\"\ndoc = {}\nquantity = \"{quantity}\"\nunit = {}\n\
             check = {{ all_within = [{}, {}] }}\n",
            unique("its", name, &mut names),
            text(doc),
            text(unit),
            number(band[0]),
            number(band[1])
        );
    };
    measure(
        "state",
        "A state of NMT, from the boot-up message on",
        "signal.nmt_state",
        "1",
        [0.0, 127.0],
    );
    if let Some(kind) = kind.filter(|_| !asks.is_empty()) {
        measure("device_type", "The device type, 1000h", "sdo.device_type", "1", [kind, kind]);
    }
    for message in of(layout, Sender::Device) {
        let pdo = message.name.strip_prefix("TPDO").and_then(|number| number.parse().ok());
        let is_sent = |pdo: u16| dictionary.is_some_and(|known| known.sends_pdo(pdo));
        if !pdo.is_some_and(is_sent) {
            continue;
        }
        for signal in &message.signals {
            let of = format!("{}.{}", message.name, signal.name);
            let doc = format!("{of} in the limits that the EDS gives");
            let band = [signal.minimum, signal.maximum];
            measure(&of, &doc, &format!("signal.{of}"), &unit_of(signal), band);
        }
    }
    toml
}
