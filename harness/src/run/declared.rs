//! Declarations of a plan and its bench for the header of a record.

use crate::plan::quantities::during_tag;
use crate::plan::rig::{NodePart, RigLine, RigNode};
use crate::plan::{
    Action, Declared, Plan, QuantityName, Rig, Speaker, Step, resolve, signal, unit,
};
use crate::record::Device;
use crate::record::header::{Band, Bus, Line, Node, Quantity, StepNote};
use ::described::{Description, Medium};
use emulators::base::Transport;
use emulators::device_file::Devices;
use std::collections::BTreeMap;

/// The serial lines of a bench.
pub(super) fn lines(devices: &Devices) -> Vec<Line> {
    let gyro = Some((Device::Gyro, devices.gyro.0.format.serial()));
    let is_serial = devices.base.as_ref().is_some_and(|base| base.0 == Transport::Serial);
    let base = is_serial.then_some((Device::Base, wire::base::serial_link::SETTINGS));
    let table = devices.table.as_ref().map(|_| (Device::Table, wire::table::SETTINGS));
    let all = [gyro, base, table].into_iter().flatten();
    all.map(|(device, settings)| Line {
        device,
        baud: settings.baud,
        bits_per_byte: settings.bits_per_byte(),
    })
    .collect()
}

/// The serial line of a described device.
pub(super) fn line_of(device: &Description) -> Vec<Line> {
    let Medium::Serial(settings) = device.layout().medium() else { return Vec::new() };
    let (baud, bits_per_byte) = (settings.baud, settings.bits_per_byte());
    vec![Line { device: Device::Device, baud, bits_per_byte }]
}

/// The CAN buses of a rig with a rig file.
pub(super) fn buses(rig: &Rig) -> Vec<Bus> {
    let lines = rig.lines.iter().filter(|line| !rig.is_short && line.medium == Medium::Can);
    let bus = |line: &RigLine| Bus {
        line: line.name.clone(),
        bit_rate: line.rates().nominal,
        data_bit_rate: line.data_bit_rate,
    };
    lines.map(bus).collect()
}

/// The nodes of a rig as a record counts them; none if the plan names its only device.
pub(super) fn nodes(rig: &Rig) -> Vec<Node> {
    // Of a log, the harness sent nothing.
    let is_played =
        |node: &RigNode| rig.logged.is_none() && !matches!(node.part, NodePart::UnderTest(_));
    let node = |(place, line): (usize, usize)| Node {
        name: rig.nodes[place].name.clone(),
        line: rig.line_name(line).to_owned(),
        host: rig.is_host(&rig.nodes[place], line),
        played: is_played(&rig.nodes[place]),
    };
    if rig.is_short { Vec::new() } else { rig.ends().map(node).collect() }
}

/// Unit and title of a quantity, from the table of quantities or from the layout of its speaker.
fn described(name: &QuantityName, plan: &Plan, speakers: &[Speaker]) -> (String, String) {
    if let Some(entry) = name.entry() {
        return (entry.unit.to_owned(), entry.doc.to_owned());
    }
    if name.reaction().is_some() {
        return ("s".to_owned(), "Time from one condition to another.".to_owned());
    }
    if name.read().is_some() {
        let is_it = |quantity: Option<String>| quantity.as_deref() == Some(name.as_str());
        let read = |step: &Step| match &step.action {
            Action::Uds(uds) if is_it(uds.quantity()) => {
                let unit = uds.read.as_ref()?.unit().to_owned();
                Some((unit, "A number in a response to a diagnostic request.".to_owned()))
            }
            Action::Sdo(sdo) if is_it(sdo.quantity()) => {
                Some((sdo.unit(speakers)?, "An object of a CANopen device.".to_owned()))
            }
            _ => None,
        };
        return Step::walk(&plan.steps).find_map(read).unwrap_or_default();
    }
    let place = name.of_message().and_then(|of| resolve(speakers, of).ok());
    let Some(place) = place else { return Default::default() };
    let title = match signal(speakers, place) {
        Some(signal) => signal.doc.clone(),
        None => "Time from one message to the next.".to_owned(),
    };
    (unit(speakers, place), title)
}

/// The tags of the observations for which a measurement's band holds.
fn tags(declared: &Declared) -> BTreeMap<String, f64> {
    let mut tags = declared.filter.equalities();
    if let Some(during) = declared.check.kind().facts().during {
        tags.insert(during_tag(during), 1.0);
    }
    tags
}

/// Steps with a label, and those that act on a device, by their place.
pub(super) fn steps(plan: &Plan) -> BTreeMap<String, StepNote> {
    let mut notes = BTreeMap::new();
    note(&plan.steps, "steps", &mut notes);
    notes
}

fn note(steps: &[Step], around: &str, notes: &mut BTreeMap<String, StepNote>) {
    for (index, step) in steps.iter().enumerate() {
        let place = format!("{around}[{index}]");
        note(step.action.steps(), &format!("{place}.{}", step.action.name()), notes);
        let label = step.label.as_ref().map(|label| label.as_str().to_owned());
        let found = StepNote { label, acts: acts(&step.action) };
        if found != StepNote::default() {
            notes.insert(place, found);
        }
    }
}

/// Whether a step sends, sets or switches something, other than by a mission of the controller.
const fn acts(action: &Action) -> bool {
    matches!(
        action,
        Action::Send(_)
            | Action::StopSending(_)
            | Action::SetParameter(_)
            | Action::PowerCycle(_)
            | Action::BenchCommand(_)
            | Action::Sdo(_)
            | Action::Uds(_)
    )
}

/// The quantities that the plan judges, with the bands for single values. `speakers` define the quantities in messages.
pub(super) fn quantities(plan: &Plan, speakers: &[Speaker]) -> Vec<Quantity> {
    let mut quantities: Vec<Quantity> = Vec::new();
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    for declared in &plan.measurements {
        let names = std::iter::once(&declared.quantity)
            .chain(declared.check.kind().facts().second_quantity.map(|(_, name)| name));
        for name in names {
            let judged_by = declared.name.as_str().to_owned();
            if let Some(place) = places.get(name.as_str()) {
                quantities[*place].judged_by.push(judged_by);
                continue;
            }
            places.insert(name.as_str(), quantities.len());
            let (unit, title) = described(name, plan, speakers);
            quantities.push(Quantity {
                name: name.as_str().to_owned(),
                unit,
                title,
                bands: Vec::new(),
                judged_by: vec![judged_by],
            });
        }
        let Some(band) = declared.check.kind().facts().value_band else { continue };
        quantities[places[declared.quantity.as_str()]].bands.push(Band {
            measurement: declared.name.as_str().to_owned(),
            lower: band.lower(),
            upper: band.upper(),
            paper: declared.paper.clone(),
            tags: tags(declared),
        });
    }
    quantities
}
