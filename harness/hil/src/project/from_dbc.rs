//! A project for one node of a given DBC: every signal that the node sends has a value, every message a period, and a
//! plan receives all of them. The user knows what they mean.

use super::traffic::{LOAD_MAX, Waits, assumed_period, load, period};
use super::written::{key, number, text};
use super::{ProjectFile, Template, with_schemas};
use described::{Dbc, DbcNode, FileError, Layout, Message, NOBODY, Note, Sender, Signal, dbc_text};
use plan::{FILE_LEN_MAX, Name, QuantityName, STEPS_MAX, unit_of};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use wire::time::Span;

/// Largest text of a plan, in bytes, with room for what is added behind the measurements.
pub(super) const PLAN_LEN_MAX: usize = FILE_LEN_MAX - 4096;

/// Minimum listening time of the plan, and minimum rounds of each message.
const LISTENING_S_MIN: f64 = 10.0;
const ROUNDS: f64 = 3.0;

#[derive(Debug)]
pub struct FromDbc {
    pub files: Vec<ProjectFile>,
    /// Notes on those parts of the DBC that are changed.
    pub notes: Vec<Note>,
}

#[derive(Debug, thiserror::Error)]
pub enum FromDbcError {
    /// The DBC cannot be read, or has no such node.
    #[error(transparent)]
    Description(#[from] Box<FileError>),
    /// Several nodes send; the caller must choose the device.
    #[error("{file} has {} nodes that send messages", nodes.len())]
    Several { file: String, nodes: Vec<DbcNode> },
    /// The device has nothing to say that a plan could judge.
    #[error("{node} of {file} sends no messages")]
    Silent { file: String, node: String, nodes: Vec<DbcNode> },
    #[error("{0} has no messages")]
    Empty(String),
    #[error("{0} has no other node that sends messages")]
    Alone(String),
}

/// Generates a project for `node` of this DBC; `file` names it in messages. The default is the only node that sends.
///
/// # Errors
///
/// When the DBC cannot be read, has no such node, or has several candidates, or when the node sends nothing.
pub fn from_dbc(
    name: &Name,
    file: &str,
    bytes: &[u8],
    node: Option<&str>,
) -> Result<FromDbc, FromDbcError> {
    let dbc = Dbc::parse(file, &dbc_text(bytes)).map_err(Box::new)?;
    let mut nodes = dbc.nodes().to_vec();
    nodes.retain(|node| node.messages > 0);
    let node = match (node, nodes.as_slice()) {
        (Some(node), _) => node.to_owned(),
        (None, []) => return Err(FromDbcError::Empty(file.to_owned())),
        (None, [only]) => only.name.clone(),
        (None, _) => return Err(FromDbcError::Several { file: file.to_owned(), nodes }),
    };
    let layout = dbc.layout(&node).map_err(Box::new)?;
    if of(&layout, Sender::Device).next().is_none() {
        return Err(FromDbcError::Silent { file: file.to_owned(), node, nodes });
    }
    let of_template = Template::Can.named(name);
    let benches = of_template.into_iter().filter(|file| file.path.starts_with("benches"));
    let readme = include_str!("from_dbc.md").replace("mydevice", name.as_str());
    let period = assumed_period(&layout);
    let made = [
        ProjectFile { path: format!("devices/{name}.dbc").into(), bytes: bytes.to_owned() },
        ProjectFile::of_text(
            format!("devices/{name}.toml"),
            description(name, (name, &node), &layout, period),
        ),
        ProjectFile::of_text("talks.toml", plan(name, &layout, period)),
        ProjectFile::of_text("README.md", readme),
    ];
    let files = with_schemas(made.into_iter().chain(benches).collect());
    Ok(FromDbc { files, notes: layout.notes().to_vec() })
}

pub(super) fn of(layout: &Layout, sender: Sender) -> impl Iterator<Item = &Message> {
    layout.messages().iter().filter(move |message| message.sender == sender)
}

/// Returns the messages that the plan sends: all that the device receives, except the most frequent ones if the bus has
/// no room for them beside those of the device, or if the plan would have too many steps.
fn told(layout: &Layout, assumed: Span) -> Vec<&Message> {
    let mut room = LOAD_MAX - load(of(layout, Sender::Device), assumed);
    let mut slowest_first: Vec<&Message> = of(layout, Sender::Host).collect();
    slowest_first.sort_by_key(|message| std::cmp::Reverse(period(message, assumed)));
    let fits = |message: &&Message| {
        room -= load(std::iter::once(*message), assumed);
        room >= 0.0
    };
    let names: BTreeSet<&str> = slowest_first
        .into_iter()
        .take_while(fits)
        .take(STEPS_MAX - 1)
        .map(|message| message.name.as_str())
        .collect();
    of(layout, Sender::Host).filter(|message| names.contains(message.name.as_str())).collect()
}

/// Returns the name of a signal, prefixed by its message if it is ambiguous.
fn signal_name(layout: &Layout, message: &Message, signal: &Signal) -> String {
    match layout.signal(&signal.name) {
        Some(_) => signal.name.clone(),
        None => format!("{}.{}", message.name, signal.name),
    }
}

/// Generates the emulator of a node: its file is `name`, and the DBC belongs to `project`.
pub(super) fn description(
    project: &Name,
    (name, node): (&Name, &str),
    layout: &Layout,
    assumed: Span,
) -> String {
    let who = if node == NOBODY { "the device" } else { node };
    let mut text_of = format!(
        "# Emulates {who}. `hil emulate device devices/{name}.toml` puts it on a port.\n\
         name = \"{name}\"\n\
         title = {}\n\
         dbc = \"{project}.dbc\"\n\
         node = {}\n",
        text(who),
        text(node)
    );
    for message in of(layout, Sender::Device) {
        text_of += "\n";
        for (place, signal) in message.signals.iter().enumerate() {
            let pages = message.pages(place);
            if !pages.is_empty() {
                let pages: Vec<String> = pages.iter().map(ToString::to_string).collect();
                let _ = writeln!(
                    text_of,
                    "# {}, a multiplexer, takes its numbers in turn: {}.",
                    signal.name,
                    pages.join(", ")
                );
                continue;
            }
            let _ = writeln!(text_of, "[signal.{}]", key(&signal_name(layout, message, signal)));
            let _ = writeln!(
                text_of,
                "expression = \"{}\"    # {}",
                number(signal.start),
                range(signal)
            );
        }
        let _ = writeln!(text_of, "[message.{}]", key(&message.name));
        let period = period(message, assumed).as_secs_f64();
        let said = if message.period.is_some() { "" } else { "    # assumed: the DBC gives none" };
        let _ = writeln!(text_of, "period_s = {period}{said}");
    }
    for message in of(layout, Sender::Host) {
        let signals: Vec<&str> =
            message.signals.iter().map(|signal| signal.name.as_str()).collect();
        let with = if signals.is_empty() { "" } else { ", with " };
        let _ = writeln!(text_of, "\n# Received: {}{with}{}.", message.name, signals.join(", "));
        let _ = writeln!(text_of, "# [message.{}]", key(&message.name));
        let _ = writeln!(
            text_of,
            "# timeout_s = 1.0    # if it stops for this long, its signals return to their initial values"
        );
    }
    text_of
}

/// Formats the range of a signal for people, on one line.
fn range(signal: &Signal) -> String {
    let unit = signal.unit.replace(|c: char| c.is_control(), " ");
    let (minimum, maximum) = (number(signal.minimum), number(signal.maximum));
    format!("{minimum} to {maximum} {unit}").trim_end().to_owned()
}

fn plan(name: &Name, layout: &Layout, assumed: Span) -> String {
    let mut text_of = format!(
        "# Does the device send its messages on time, with values in range? `hil run talks.toml`\n\
         name = \"talks\"\n\
         title = \"{name} sends its messages on time, with values in range\"\n\
         device = \"{name}\"\n\n\
         steps = [\n"
    );
    let told = told(layout, assumed);
    let untold = of(layout, Sender::Host).count() - told.len();
    if untold > 0 {
        let _ = writeln!(
            text_of,
            "    # {untold} messages that the device receives are not sent: they are too many for the bus or for a plan."
        );
    }
    for message in told {
        let values = first_page(message);
        let signals = message.signals.iter().zip(&values).enumerate();
        let carried = signals.filter(|(place, _)| message.carries(*place, &values));
        let set = carried
            .map(|(_, (signal, value))| format!("{} = {}", key(&signal.name), number(*value)));
        let _ = writeln!(
            text_of,
            "    {{ send = {{ message = {}, set = {{ {} }}, every_s = {} }} }},",
            text(&message.name),
            set.collect::<Vec<_>>().join(", "),
            period(message, assumed).as_secs_f64()
        );
    }
    let duration_s = listening_s(layout, assumed);
    let _ = writeln!(
        text_of,
        "    {{ wait = {{ duration_s = {duration_s} }}, label = \"talking\" }},\n]"
    );
    let mut measured = Measured::new(&mut text_of, 0.9 * duration_s);
    let waits = Waits::of(layout);
    for message in of(layout, Sender::Device) {
        measured.add((None, layout, &waits), message, period(message, assumed));
    }
    measured.finish();
    text_of
}

/// Returns the start values of a message's signals, as its bits can hold them, with the first values of its multiplexers.
fn first_page(message: &Message) -> Vec<f64> {
    let value = |(place, signal): (usize, &Signal)| {
        let page = message.pages(place).first().copied();
        page.map_or_else(|| signal.as_sent(signal.start), |page| signal.selecting(page))
    };
    message.signals.iter().enumerate().map(value).collect()
}

/// Returns the time until every signal of the device has arrived a few times.
pub(super) fn listening_s(layout: &Layout, assumed: Span) -> f64 {
    let frames = |message: &Message| {
        let each = (0..message.signals.len()).map(|signal| {
            let pages = message
                .selections(signal)
                .map(|selection| message.pages(selection.multiplexer).len() as f64);
            pages.product::<f64>()
        });
        each.fold(1.0, f64::max)
    };
    let rounds = of(layout, Sender::Device)
        .map(|message| ROUNDS * frames(message) * period(message, assumed).as_secs_f64());
    rounds.fold(LISTENING_S_MIN, f64::max).ceil()
}

/// To microseconds.
fn rounded(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}

/// A sender on a rig, its layout and the waits of its messages; no name if the device is the only one of the plan.
type Of<'a> = (Option<&'a Name>, &'a Layout, &'a Waits);

pub(super) struct Measured<'a> {
    plan: &'a mut String,
    names: BTreeSet<String>,
    /// Messages for which the plan has no room.
    left_out: usize,
    /// Time for which each message must be heard, s.
    heard_s: f64,
}

impl<'a> Measured<'a> {
    pub(super) const fn new(plan: &'a mut String, heard_s: f64) -> Self {
        Self { plan, names: BTreeSet::new(), left_out: 0, heard_s }
    }

    /// Adds those of a message, unless the plan would be too large to be read.
    pub(super) fn add(&mut self, of: Of<'_>, message: &Message, period: Span) {
        let before = self.plan.len();
        measure(self.plan, of, message, (period, self.heard_s), &mut self.names);
        if self.plan.len() > PLAN_LEN_MAX {
            self.plan.truncate(before);
            self.left_out += 1;
        }
    }

    /// Says why a message is not measured.
    pub(super) fn leave_out(&mut self, message: &Message) {
        let _ = writeln!(
            self.plan,
            "\n# {} is not measured: the DBC gives it no period, so that it may be an event.",
            message.name
        );
    }

    pub(super) fn finish(self) {
        if self.left_out > 0 {
            let count = self.left_out;
            let _ = writeln!(
                self.plan,
                "\n# {count} more messages are not measured: a plan has no room for them."
            );
        }
    }
}

/// Adds the measurements of a message: that it arrives at its period, and that its signals are in their ranges.
fn measure(
    plan: &mut String,
    (node, layout, waits): Of<'_>,
    message: &Message,
    (period, heard_s): (Span, f64),
    names: &mut BTreeSet<String>,
) {
    let quantity = match node {
        Some(node) => format!("period.{node}.{}", message.name),
        None => format!("period.{}", message.name),
    };
    if QuantityName::new(&quantity).is_some() {
        let period_s = period.as_secs_f64();
        let beside_s = waits.wait_s(message).max(0.2 * period_s);
        let _ = write!(
            plan,
            "\n[[measurement]]\nname = \"{}\"\ndoc = {}\nquantity = {}\n\
             unit = \"1\"\ncheck = {{ share_within = {{ share = 0.95, band = [{}, {}] }} }}\n\
             observations_min = {}     # a silent device must not pass\n",
            unique("period", &message.name, names),
            text(&match node {
                Some(node) => format!("Time between two {} messages of {node}", message.name),
                None => format!("Time between two {} messages", message.name),
            }),
            text(&quantity),
            number(rounded((period_s - beside_s).max(0.0))),
            number(rounded(period_s + beside_s)),
            // The first message ends no period.
            least_of(heard_s - period_s, period_s)
        );
    }
    for signal in &message.signals {
        let of = signal_name(layout, message, signal);
        let quantity = match node {
            Some(node) => format!("{node}.{}.{}", message.name, signal.name),
            None => format!("signal.{of}"),
        };
        if QuantityName::new(&quantity).is_none() {
            let _ = writeln!(plan, "\n# No quantity can have the name {}.", text(&of));
            continue;
        }
        // A limit between two counts is sent as the nearer count.
        let [minimum, maximum] = [signal.minimum, signal.maximum];
        let band = [minimum.min(signal.as_sent(minimum)), maximum.max(signal.as_sent(maximum))];
        let _ = write!(
            plan,
            "\n[[measurement]]\nname = \"{}\"\ndoc = {}\nquantity = {}\nunit = {}\ncheck = {{ all_within = [{}, {}] }}\n",
            unique("range", &of, names),
            text(&format!("{of} in the range that the DBC gives")),
            text(&quantity),
            text(&unit_of(signal)),
            number(band[0]),
            number(band[1])
        );
    }
}

/// Whole periods in this time, and at least one.
pub(super) fn least_of(heard_s: f64, period_s: f64) -> u32 {
    let expected = heard_s / period_s;
    if expected.is_finite() { (expected as u32).max(1) } else { 1 }
}

/// Returns a name for a measurement that no other has.
pub(super) fn unique(kind: &str, of: &str, names: &mut BTreeSet<String>) -> String {
    const LENGTH_MAX: usize = 58;
    let lower = of.to_ascii_lowercase();
    let lower = lower.replace(|c: char| !c.is_ascii_alphanumeric() && c != '-', "_");
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
