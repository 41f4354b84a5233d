//! The messages of a device, as a layout: what its EDS maps, and the protocol's own.

use super::abort::Abort;
use super::dictionary::Dictionary;
use super::nmt::{COMMANDS, STATES};
use super::pdo::{self, Direction, Pdo, Wrong, pdos};
use crate::bits::BitField;
use crate::file::ByteOrder;
use crate::layout::{Coding, Layout, Message, Scale, Sender, Signal};
use std::sync::Arc;
use wire::can::{Hex, Id, StandardId};

/// Message with a request of an SDO transfer.
pub const SDO_REQUEST: &str = "SDO_request";
/// Message with an answer of an SDO transfer.
pub const SDO_RESPONSE: &str = "SDO_response";

/// Signal of an NMT command: the node that it is for.
pub(crate) const NODE: &str = "node";

/// A number of a message without an object: name, first bit, number of bits.
type Field = (&'static str, u32, u32);

const SDO: [Field; 4] = [("command", 0, 8), ("index", 8, 16), ("sub", 24, 8), ("data", 32, 32)];
const EMERGENCY: [Field; 3] =
    [("error_code", 0, 16), ("error_register", 16, 8), ("manufacturer", 24, 40)];

/// What is wrong with an object: index, sub-index and reason.
type Mistake = (u16, u8, String);

/// The layout of a device with this dictionary.
///
/// # Errors
/// With the first object that is not possible: a mapping, an identifier, a transmission type.
pub(super) fn layout(dictionary: &Arc<Dictionary>) -> Result<Layout, Mistake> {
    let values = dictionary.start();
    let mut messages: Vec<Message> = Vec::new();
    let mut add = |name: &str, sender, (index, sub, id), bits: u32, signals: Vec<Signal>| {
        let Some(id): Option<Id> = id else { return Ok(()) };
        if let Some(known) = messages.iter().find(|known| known.can_id() == Some(id)) {
            let why = format!("is {}, which is the identifier of {} already", Hex(id), known.name);
            return Err((index, sub, why));
        }
        let length = bits.div_ceil(8) as usize;
        messages.push(Message::of_frame(name, sender, (id, length), signals));
        Ok(())
    };
    let of_node =
        |function: u16| StandardId::new(function + u16::from(dictionary.node_id)).map(Id::Standard);
    let cob = |index: u16, sub: u8, default: Option<Id>| {
        let id = match dictionary.setting(&values, index, sub) {
            Some(cob) => pdo::id(cob as u32).filter(|_| cob & 1 << 31 == 0),
            None => default,
        };
        (index, sub, id)
    };
    let mut node = plain((NODE, 8, 8), &[]);
    node.start = f64::from(dictionary.node_id);
    let command = plain(("command", 0, 8), &COMMANDS);
    let nmt = (0, 0, Some(Id::Standard(StandardId::ZERO)));
    add("NMT", Sender::Host, nmt, 16, vec![command, node])?;
    let sync = cob(0x1005, 0, StandardId::new(0x80).map(Id::Standard));
    add("SYNC", Sender::Host, sync, 0, Vec::new())?;
    for (direction, prefix, sender) in
        [(Direction::Receive, "RPDO", Sender::Host), (Direction::Transmit, "TPDO", Sender::Device)]
    {
        let pdos = pdos(dictionary, &values, direction);
        let no_mapping = |why: Abort| format!("is no mapping of a PDO: {why}");
        for pdo in pdos.map_err(|(index, sub, why): Wrong| (index, sub, no_mapping(why)))? {
            let id = pdo.usable().map_err(|(sub, why)| (pdo.object(direction), sub, why))?;
            let name = format!("{prefix}{}", pdo.number);
            let bits = pdo.mapped.iter().map(|mapped| mapped.bits).sum();
            add(&name, sender, (pdo.object(direction), 1, id), bits, mapped(dictionary, &pdo))?;
        }
    }
    let fields = |fields: &[Field]| fields.iter().map(|field| plain(*field, &[])).collect();
    let emergency = cob(0x1014, 0, of_node(0x80));
    add("EMCY", Sender::Device, emergency, 64, fields(&EMERGENCY))?;
    let state = plain(("nmt_state", 0, 8), &STATES);
    add("Heartbeat", Sender::Device, (0x1017, 0, of_node(0x700)), 8, vec![state])?;
    add(SDO_REQUEST, Sender::Host, cob(0x1200, 1, of_node(0x600)), 64, fields(&SDO))?;
    add(SDO_RESPONSE, Sender::Device, cob(0x1200, 2, of_node(0x580)), 64, fields(&SDO))?;
    Ok(Layout::of_canopen(messages, Arc::clone(dictionary)))
}

fn signal(name: &str, (first, bits): (u32, u32), coding: Coding, scale: Scale) -> Option<Signal> {
    let field = BitField::new(ByteOrder::Little, first.into(), bits.into(), 8)?;
    Some(Signal::of_bits(name, field, coding, scale))
}

fn plain((name, first, bits): Field, names: &[(i64, &str)]) -> Signal {
    let scale = Scale::ONE;
    let signal = signal(name, (first, bits), Coding::Unsigned, scale);
    #[expect(clippy::expect_used, reason = "the fields are constants of this file")]
    let mut signal = signal.expect("a field of eight bytes");
    signal.named_values =
        names.iter().map(|(number, name)| (*number, (*name).to_owned())).collect();
    signal
}

fn mapped(dictionary: &Dictionary, pdo: &Pdo) -> Vec<Signal> {
    let mut signals: Vec<Signal> = Vec::new();
    for (place, first, bits) in pdo.objects() {
        let entry = &dictionary.entries[place];
        let Some((coding, _)) = entry.number() else { continue };
        let Some(mut signal) = signal(&entry.name, (first, bits), coding, entry.scale) else {
            continue;
        };
        (signal.minimum, signal.maximum) = entry.range();
        signal.start = entry.value(&entry.start).unwrap_or(0.0);
        signal.start = signal.start.clamp(signal.minimum, signal.maximum);
        signal.unit.clone_from(&entry.unit);
        signal.doc.clone_from(&entry.title);
        if signals.iter().all(|known| known.name != signal.name) {
            signals.push(signal);
        }
    }
    signals
}
