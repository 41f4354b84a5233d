//! A rest-of-bus simulation for the user's own device: all nodes of a DBC except some are emulated and send its
//! messages.

use super::from_dbc::{Measured, description, listening_s, of};
use super::traffic::{Waits, assumed_period};
use super::written::text;
use super::{FromDbc, FromDbcError, ProjectFile, with_schemas};
use described::{Dbc, DbcNode, Layout, NOBODY, Note, Sender, dbc_text};
use plan::Name;
use plan::rig::NODES_MAX;
use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use wire::time::Span;

/// Names that a rig node cannot have, since they have another meaning in plans and bench files.
const TAKEN: [&str; 8] =
    ["device", "host", "operator", "gyro", "base", "table", "controller", "plan"];

/// Most nodes of a rig file.
const MEMBERS_MAX: usize = NODES_MAX - 2;

struct Member {
    dbc_node: String,
    name: Name,
    layout: Layout,
    is_real: bool,
}

/// Generates a project for the bus of this DBC, with all nodes except those of `except` emulated; `file` names the DBC
/// in messages.
///
/// # Errors
///
/// When the DBC cannot be read, has no such node, or no messages of other nodes.
pub fn restbus(
    name: &Name,
    file: &str,
    bytes: &[u8],
    except: &[String],
) -> Result<FromDbc, FromDbcError> {
    let text = dbc_text(bytes);
    let dbc = Dbc::parse(file, &text).map_err(Box::new)?;
    let mut nodes = dbc.nodes().to_vec();
    let is_real = |node: &str| except.iter().any(|real| real == node);
    // An unknown name is refused; the error lists the known ones.
    for real in except {
        dbc.layout(real).map_err(Box::new)?;
    }
    nodes.retain(|node| node.messages > 0 || is_real(&node.name));
    let left_out = beyond(&mut nodes, &is_real);
    let mut taken = BTreeSet::new();
    let mut members = Vec::new();
    for node in nodes {
        let layout = dbc.layout(&node.name).map_err(Box::new)?;
        let is_real = is_real(&node.name);
        if is_real || of(&layout, Sender::Device).next().is_some() {
            let name = called(&node.name, &mut taken);
            members.push(Member { dbc_node: node.name, name, layout, is_real });
        }
    }
    let emulated = || members.iter().filter(|one| !one.is_real);
    let Some(first) = emulated().next() else { return Err(FromDbcError::Alone(file.to_owned())) };
    let (assumed, mut notes) = (assumed_period(&first.layout), first.layout.notes().to_vec());
    let line = text.lines().position(|line| line.starts_with("BU_")).map_or(1, |place| place + 1);
    notes.extend(left_out.into_iter().map(|node| Note {
        file: file.to_owned(),
        line,
        message: node,
        signal: None,
        is_left_out: true,
        what: format!("the node is left out: a rig has at most {MEMBERS_MAX} nodes"),
    }));
    let mut made =
        vec![ProjectFile { path: format!("devices/{name}.dbc").into(), bytes: bytes.to_owned() }];
    for one in emulated() {
        let device = description(name, (&one.name, &one.dbc_node), &one.layout, assumed);
        made.push(ProjectFile::of_text(format!("devices/{}.toml", one.name), device));
    }
    made.push(ProjectFile::of_text("rigs/rest.toml", rig(name, &members, false)));
    made.push(ProjectFile::of_text("rest.toml", rest_plan(name, &members, assumed)));
    if members.iter().any(|one| one.is_real) {
        made.push(ProjectFile::of_text("rigs/bench.toml", rig(name, &members, true)));
        made.push(ProjectFile::of_text("bench.toml", bench_plan(name, &members, assumed)));
    }
    made.push(ProjectFile::of_text("README.md", readme(name, &members)));
    Ok(FromDbc { files: with_schemas(made), notes })
}

/// Takes out the nodes beyond what a rig can have, those with the fewest messages, and returns their names.
fn beyond(nodes: &mut Vec<DbcNode>, is_real: &dyn Fn(&str) -> bool) -> Vec<String> {
    let mut places: Vec<usize> = (0..nodes.len()).collect();
    places.sort_by_key(|place| (!is_real(&nodes[*place].name), Reverse(nodes[*place].messages)));
    let kept: BTreeSet<usize> = places.into_iter().take(MEMBERS_MAX).collect();
    let (mut left_out, mut place) = (Vec::new(), 0..);
    nodes.retain(|node| {
        let is_kept = place.next().is_some_and(|place| kept.contains(&place));
        left_out.extend((!is_kept).then(|| node.name.clone()));
        is_kept
    });
    left_out
}

/// Returns the name of a node in a rig: `EPS_Rack` becomes `eps_rack`.
fn called(dbc_node: &str, taken: &mut BTreeSet<String>) -> Name {
    const LENGTH_MAX: usize = 24;
    let lower = if dbc_node == NOBODY { "nobody".to_owned() } else { dbc_node.to_lowercase() };
    let mut name: String =
        lower.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !name.starts_with(|c: char| c.is_ascii_lowercase()) || TAKEN.contains(&name.as_str()) {
        name.insert_str(0, "node_");
    }
    name.truncate(LENGTH_MAX);
    let free = (1..).map(|number| match number {
        1 => name.clone(),
        number => format!("{name}_{number}"),
    });
    let mut fitting =
        free.filter(|name| taken.insert(name.clone())).filter_map(|name| Name::new(&name));
    fitting.next().unwrap_or_else(|| unreachable!("one of all numbers is free"))
}

/// Generates the rig: all emulated nodes, and with `real` the others too.
fn rig(name: &Name, members: &[Member], real: bool) -> String {
    let mut text_of = match real {
        true => "# The real device on its bus, and the other nodes emulated.\n".to_owned(),
        false => "# The rest of the bus. `hil emulate rig rigs/rest.toml --line can0=can:can0` connects it to your device.\n"
            .to_owned(),
    };
    let is_fd = members.iter().any(|one| one.layout.fd_message().is_some());
    let data = if is_fd { "data_bit_rate = 2_000_000, " } else { "" };
    let _ = write!(
        text_of,
        "title = {}\n\n[[line]]\nname = \"can0\"\ncan = {{ bit_rate = 500_000, {data}dbc = \"../devices/{name}.dbc\" }}\n",
        text(&format!("The bus of {name}"))
    );
    for one in members.iter().filter(|one| real || !one.is_real) {
        let _ = write!(
            text_of,
            "\n[[node]]\nname = \"{}\"\nat = \"can0\"\ndbc_node = {}\n",
            one.name,
            text(&one.dbc_node)
        );
        text_of += &match one.is_real {
            true => "under_test = { attached = true }\n".to_owned(),
            false => format!("emulate = \"{}\"\n", one.name),
        };
    }
    text_of
}

fn rest_plan(name: &Name, members: &[Member], assumed: Span) -> String {
    let emulated = || members.iter().filter(|one| !one.is_real);
    let listening = emulated().map(|one| listening_s(&one.layout, assumed)).fold(0.0, f64::max);
    let mut plan = format!(
        "# Does the rest of the bus send what the DBC says? `hil run rest.toml`\n\
         name = \"rest\"\ntitle = \"The rest of the bus of {name} sends its messages\"\nrig = \"rest\"\n\n\
         steps = [{{ wait = {{ duration_s = {listening} }} }}]\n"
    );
    measured(&mut plan, 0.9 * listening, emulated(), assumed);
    plan
}

fn bench_plan(name: &Name, members: &[Member], assumed: Span) -> String {
    let real = || members.iter().filter(|one| one.is_real);
    let listening = real().map(|one| listening_s(&one.layout, assumed)).fold(0.0, f64::max);
    let mut plan = format!(
        "# Does the device send what the DBC says? `hil run bench.toml --clock real --bus vcan`, or with a bench file.\n\
         name = \"bench\"\ntitle = \"The device of {name} sends its messages on time, with values in range\"\nrig = \"bench\"\n\n\
         steps = [{{ wait = {{ duration_s = {listening} }} }}]\n"
    );
    // A device may be switched on after the plan has begun.
    measured(&mut plan, 0.5 * listening, real(), assumed);
    plan
}

/// Of a real device that the DBC gives periods, a message without one may be an event: that it comes is asked of none of
/// them. What is emulated here sends each message.
fn measured<'a>(
    plan: &mut String,
    heard_s: f64,
    members: impl Iterator<Item = &'a Member>,
    assumed: Span,
) {
    let mut measured = Measured::new(plan, heard_s);
    for one in members {
        let waits = Waits::of(&one.layout);
        let all = || of(&one.layout, Sender::Device);
        let has_events = one.is_real && all().any(|message| message.period.is_some());
        for message in all() {
            match message.period {
                None if has_events => measured.leave_out(message),
                period => {
                    let period = period.unwrap_or(assumed);
                    measured.add((Some(&one.name), &one.layout, &waits), message, period);
                }
            }
        }
    }
    measured.finish();
}

fn readme(name: &Name, members: &[Member]) -> String {
    let names = |real: bool| {
        let named = members.iter().filter(|one| one.is_real == real);
        named.map(|one| one.dbc_node.clone()).collect::<Vec<_>>().join(", ")
    };
    let readme = include_str!("restbus.md").replace("mybus", name.as_str());
    let readme = readme.replace("REST", &names(false));
    match names(true) {
        nobody if nobody.is_empty() => {
            // Everything from the bench on concerns a real device.
            readme.split("## 3.").next().unwrap_or_default().to_owned()
        }
        real => readme.replace("REAL", &real),
    }
}
