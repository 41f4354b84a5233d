//! A project for one node of somebody's DBC: every signal that the node sends has a value, every message a period, and a
//! plan hears all of them. What they mean its user knows.

use super::{ProjectFile, Template, with_schemas};
use described::{Carried, DescriptionError, Layout, Message, Sender, Signal};
use plan::Name;
use plan::unit_of;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use wire::time::Span;

/// How often a message is sent that the DBC gives no period. Assumption: the usual one of status messages.
const PERIOD: Span = Span::from_millis(100);

/// The files of a project for `node` of the DBC with this `text`; `file` names it in messages.
///
/// # Errors
///
/// When the DBC cannot be read, has no such node, or has what is not supported.
pub fn from_dbc(
    name: &Name,
    file: &str,
    text: &str,
    node: &str,
) -> Result<Vec<ProjectFile>, Box<DescriptionError>> {
    let layout = Layout::from_dbc(file, text, node)?;
    let of_template = Template::Can.named(name);
    let benches = of_template.into_iter().filter(|file| file.path.starts_with("benches"));
    let made = [
        (format!("devices/{name}.dbc"), text.to_owned()),
        (format!("devices/{name}.toml"), description(name, node, &layout)),
        ("talks.toml".to_owned(), plan(name, &layout)),
        ("README.md".to_owned(), include_str!("from_dbc.md").replace("mydevice", name.as_str())),
    ];
    let made = made.map(|(path, text)| ProjectFile { path: path.into(), text });
    Ok(with_schemas(made.into_iter().chain(benches).collect()))
}

fn of(layout: &Layout, sender: Sender) -> impl Iterator<Item = &Message> {
    layout.messages().iter().filter(move |message| message.sender == sender)
}

/// The name of a signal, with its message's where several have it.
fn signal_name(layout: &Layout, message: &Message, signal: &Signal) -> String {
    match layout.signal(&signal.name) {
        Some(_) => signal.name.clone(),
        None => format!("{}.{}", message.name, signal.name),
    }
}

fn key(name: &str) -> String {
    if name.contains('.') { format!("\"{name}\"") } else { name.to_owned() }
}

fn description(name: &Name, node: &str, layout: &Layout) -> String {
    let mut text = format!(
        "# What {node} says, as an emulator. `hil emulate device devices/{name}.toml` talks like it.\n\
         name = \"{name}\"\n\
         title = \"{node}\"\n\
         dbc = \"{name}.dbc\"\n\
         node = \"{node}\"\n"
    );
    for message in of(layout, Sender::Device) {
        text += "\n";
        for signal in &message.signals {
            let at = key(&signal_name(layout, message, signal));
            let value = signal.start.clamp(signal.minimum, signal.maximum);
            let _ = writeln!(text, "[signal.{at}]");
            let _ = writeln!(text, "expression = \"{value}\"    # {}", range(signal));
        }
        let _ = writeln!(text, "[message.{}]", message.name);
        let period = message.period.unwrap_or(PERIOD).as_secs_f64();
        let said = if message.period.is_some() { "" } else { "    # assumed: the DBC has none" };
        let _ = writeln!(text, "period_s = {period}{said}");
    }
    for message in of(layout, Sender::Host) {
        let signals: Vec<&str> =
            message.signals.iter().map(|signal| signal.name.as_str()).collect();
        let _ = writeln!(text, "\n# It hears {}: {}.", message.name, signals.join(", "));
        let _ = writeln!(text, "# [message.{}]", message.name);
        let _ = writeln!(
            text,
            "# timeout_s = 1.0    # without it for so long, its signals are the initial ones again"
        );
    }
    text
}

fn range(signal: &Signal) -> String {
    format!("{} to {} {}", signal.minimum, signal.maximum, signal.unit).trim_end().to_owned()
}

fn plan(name: &Name, layout: &Layout) -> String {
    let mut text = format!(
        "# Does it send what it should, as often as it should? `hil run talks.toml`\n\
         name = \"talks\"\n\
         title = \"{name} sends its messages, and nothing out of range\"\n\
         device = \"{name}\"\n\n\
         steps = [\n"
    );
    for message in of(layout, Sender::Host) {
        let signals = message.signals.iter().filter(|signal| signal.carried == Carried::Always);
        let set = signals.map(|signal| {
            format!("{} = {}", signal.name, signal.start.clamp(signal.minimum, signal.maximum))
        });
        let every = message.period.unwrap_or(PERIOD).as_secs_f64();
        let _ = writeln!(
            text,
            "    {{ send = {{ message = \"{}\", set = {{ {} }}, every_s = {every} }} }},",
            message.name,
            set.collect::<Vec<_>>().join(", ")
        );
    }
    text += "    { wait = { duration_s = 10 }, label = \"talking\" },\n]\n";
    let mut names = BTreeSet::new();
    for message in of(layout, Sender::Device) {
        let period = message.period.unwrap_or(PERIOD).as_secs_f64();
        let _ = write!(
            text,
            "\n[[measurement]]\nname = \"{}\"\ndoc = \"Time between two of {}\"\nquantity = \"period.{}\"\n\
             unit = \"1\"\ncheck = {{ share_within = {{ share = 0.95, band = [{:.6}, {:.6}] }} }}\n",
            unique("period", &message.name, &mut names),
            message.name,
            message.name,
            0.8 * period,
            1.2 * period
        );
        for signal in &message.signals {
            let of = signal_name(layout, message, signal);
            let _ = write!(
                text,
                "\n[[measurement]]\nname = \"{}\"\ndoc = \"{of} within the range that the DBC gives\"\n\
                 quantity = \"signal.{of}\"\nunit = \"{}\"\ncheck = {{ all_within = [{}, {}] }}\n",
                unique("range", &of, &mut names),
                unit_of(signal),
                signal.minimum,
                signal.maximum
            );
        }
    }
    text
}

/// A name of a measurement, which no other has.
fn unique(kind: &str, of: &str, names: &mut BTreeSet<String>) -> String {
    const LENGTH_MAX: usize = 58;
    let lower = of.to_ascii_lowercase().replace('.', "_");
    let mut name = format!("{kind}_{lower}");
    name.truncate(LENGTH_MAX);
    let mut number = 1;
    let mut free = name.clone();
    while !names.insert(free.clone()) {
        number += 1;
        free = format!("{name}_{number}");
    }
    free
}
