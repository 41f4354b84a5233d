//! Layouts defined in a description: frames of whole bytes, packets and lines.

use super::checksum::Trailer;
use super::message::{Carrier, Message};
use super::number::{Coding, Scale};
use super::signal::{Signal, Storage};
use super::text::{Pattern, TextChecksum};
use super::{Layout, Medium, alike};
use crate::bits::BitField;
use crate::error::{Mistake, Read};
use crate::file::ByteOrder;
use crate::file::{ChecksumOver, FieldTable, FieldType, MessageTable, SerialTable};
use crate::hint;
use crate::place::Place;
use crate::protection::Checksum;
use wire::can::{self, DATA_BYTES_MAX, FD_BYTES_MAX, FdFlags, fd_length};
use wire::packet::BYTES_MAX;
use wire::serial::SerialSettings;

/// Limit of printed numbers without a range. Assumption: with a few decimals a dozen of them fit a packet, and no
/// device prints larger ones.
const PRINTED_MAX: f64 = 1e9;
/// The same with an exponent. SCPI prints infinity as 9.9E37, and what is no number as 9.91E37 (SCPI-99, 7.2.1.4).
const PRINTED_WITH_EXPONENT_MAX: f64 = 1e38;

impl Layout {
    /// The layout of `[[message]]` tables.
    pub(crate) fn from_tables(serial: Option<SerialTable>, tables: &[MessageTable]) -> Read<Self> {
        let mut messages: Vec<Message> = Vec::new();
        for (index, table) in tables.iter().enumerate() {
            let place = Place::file().key("message").index(index);
            messages.push(message(table, serial.is_some(), &place)?);
            alike::tell_apart(&mut messages, tables)?;
        }
        let medium = match serial {
            None => Medium::Can,
            Some(serial) => Medium::Serial(settings(serial)?),
        };
        Ok(Self::new(medium, messages))
    }
}

fn message(table: &MessageTable, serial: bool, place: &Place) -> Read<Message> {
    let (carrier, signals) = match (&table.text, serial) {
        (Some(text), true) => line(table, text, place)?,
        (Some(_), false) => {
            let message = "lines of text go over a serial line";
            return Err(place.key("text").mistake(message).help("add [serial] with its `baud`"));
        }
        (None, true) => packet(table, place)?,
        (None, false) => frame(table, place)?,
    };
    for (index, signal) in signals.iter().enumerate() {
        if signals[..index].iter().any(|other| other.name == signal.name) {
            let message = format!("`{}` has two fields `{}`", table.name, signal.name);
            return Err(Mistake::new(place.key("fields").index(index), message));
        }
    }
    let message = Message::new(table.name.clone(), table.sent_by, carrier, signals);
    Ok(Message { doc: table.doc.clone(), ..message })
}

fn frame(table: &MessageTable, place: &Place) -> Read<(Carrier, Vec<Signal>)> {
    unused(
        place,
        "on CAN",
        &[
            ("start", table.start.is_some()),
            ("checksum", table.trailer().is_some()),
            ("checksum_between", table.checksum_between.is_some()),
        ],
    )?;
    let raw = table.can_id.ok_or_else(|| {
        let message = format!("`{}` has no `can_id`, and the file no [serial]", table.name);
        Mistake::new(place.clone(), message).help("a message on CAN has a `can_id`")
    })?;
    let id = match table.extended {
        Some(extended) => can::identifier(raw, extended),
        None => can::identifier(raw, false).or_else(|| can::identifier(raw, true)),
    };
    let id = id.ok_or_else(|| {
        Mistake::new(place.key("can_id"), format!("{raw:#x} is no CAN identifier"))
            .help("at most 0x7ff, or 0x1fffffff where `extended` is true")
    })?;
    let fd = table.fd.then_some(FdFlags { bit_rate_switch: true, error_state: false });
    let limit = if table.fd { FD_BYTES_MAX } else { DATA_BYTES_MAX };
    let (signals, end) = fields(table, 0, limit, place)?;
    let length = if table.fd { fd_length(end).unwrap_or(end) } else { end };
    Ok((Carrier::Frame { id, length, fd }, signals))
}

fn packet(table: &MessageTable, place: &Place) -> Read<(Carrier, Vec<Signal>)> {
    unused(
        place,
        "on a serial line",
        &[
            ("can_id", table.can_id.is_some()),
            ("extended", table.extended.is_some()),
            ("fd", table.fd),
        ],
    )?;
    unused(place, "in a packet", &[("checksum_between", table.checksum_between.is_some())])?;
    let start = table.start.clone().unwrap_or_default();
    if start.is_empty() {
        let message = format!("`{}` has neither `start` nor `text`", table.name);
        return Err(Mistake::new(place.clone(), message)
            .help("a packet begins with bytes that tell it from others: start = [0xAA, 0x55]"));
    }
    let checksum = table.trailer().map(|name| Checksum::at(name, &place.key("checksum")));
    let trailer = checksum.transpose()?.map(|checksum| Trailer {
        checksum,
        order: table.checksum_order.unwrap_or_default(),
        from: match table.checksum_over.unwrap_or_default() {
            ChecksumOver::BehindStart => start.len(),
            ChecksumOver::All => 0,
        },
    });
    let sealed = trailer.map_or(0, |trailer| trailer.checksum.length());
    let room = BYTES_MAX.saturating_sub(sealed);
    let (signals, end) = fields(table, start.len(), room, place)?;
    Ok((Carrier::Packet { start, length: end + sealed, trailer }, signals))
}

/// The consecutive fields from byte `first` on, and their end, which must not exceed `limit`.
fn fields(
    table: &MessageTable,
    first: usize,
    limit: usize,
    place: &Place,
) -> Read<(Vec<Signal>, usize)> {
    let mut end = first;
    let mut signals = Vec::new();
    for (index, field) in table.fields.iter().enumerate() {
        let place = place.key("fields").index(index);
        let kind = field.kind.ok_or_else(|| {
            Mistake::new(place.clone(), format!("`{}` has no `type`", field.name))
                .help("u8, i16, u24, f32, ...: what its bytes are")
        })?;
        let (coding, bits) = Coding::of(kind);
        let begin = end;
        end += bits / 8;
        if end > limit {
            let message =
                format!("`{}` is longer than the {limit} bytes that there are", table.name);
            return Err(Mistake::new(place, message).help("divide it into several messages"));
        }
        let order = field.order.unwrap_or_default();
        let start_bit = match order {
            ByteOrder::Little => 8 * begin,
            ByteOrder::Big => 8 * begin + 7,
        };
        let bits = BitField::new(order, start_bit as u64, bits as u64, end)
            .ok_or_else(|| Mistake::new(place.clone(), "the field does not fit"))?;
        let limits = coding.limits(bits.length());
        signals.push(signal(field, Storage::Bits { field: bits, coding }, limits, &place)?);
    }
    Ok((signals, end))
}

fn line(table: &MessageTable, text: &str, place: &Place) -> Read<(Carrier, Vec<Signal>)> {
    let of_packets = [
        ("can_id", table.can_id.is_some()),
        ("fd", table.fd),
        ("start", table.start.is_some()),
        ("checksum_over", table.checksum_over.is_some()),
        ("checksum_order", table.checksum_order.is_some()),
    ];
    unused(place, "in a line of text", &of_packets)?;
    let checksum = text_checksum(table, place)?;
    let pattern = Pattern::parse(text, checksum)
        .map_err(|error| Mistake::new(place.key("text"), error.to_string()))?;
    let names: Vec<&str> = pattern.fields.iter().map(|field| field.name.as_str()).collect();
    for (index, field) in table.fields.iter().enumerate() {
        let place = place.key("fields").index(index);
        if !names.contains(&field.name.as_str()) {
            let message = format!("the line has no field `{}`", field.name);
            return Err(Mistake::new(place, message).help(hint::proposal(&field.name, &names)));
        }
        unused(
            &place,
            "in a line of text",
            &[("type", field.kind.is_some()), ("order", field.order.is_some())],
        )?;
    }
    let mut signals = Vec::new();
    for field in &pattern.fields {
        let storage = Storage::Printed { format: field.format };
        let said = table.fields.iter().enumerate().find(|(_, said)| said.name == field.name);
        let greatest =
            if field.format.has_exponent() { PRINTED_WITH_EXPONENT_MAX } else { PRINTED_MAX };
        let limits = (-greatest, greatest);
        signals.push(match said {
            Some((index, said)) => {
                signal(said, storage, limits, &place.key("fields").index(index))?
            }
            None => {
                let unsaid = FieldTable { name: field.name.clone(), ..FieldTable::default() };
                signal(&unsaid, storage, limits, place)?
            }
        });
    }
    let ends = |index: usize| {
        let signal: &Signal = &signals[index];
        [signal.minimum, signal.maximum].map(|end| signal.scale.number(end))
    };
    let longest = pattern.longest(ends);
    if longest > BYTES_MAX {
        let message =
            format!("the line can have {longest} bytes, and at most {BYTES_MAX} are sent");
        return Err(Mistake::new(place.key("text"), message)
            .help("say how many decimals (`{X:.2}`), and `minimum` and `maximum` in `fields`"));
    }
    Ok((Carrier::Line(pattern), signals))
}

/// The checksum of a line of text.
fn text_checksum(table: &MessageTable, place: &Place) -> Read<Option<TextChecksum>> {
    let Some(name) = table.trailer() else {
        unused(
            place,
            "without a checksum",
            &[("checksum_between", table.checksum_between.is_some())],
        )?;
        return Ok(None);
    };
    let checksum = Checksum::at(name, &place.key("checksum"))?;
    let byte = |end: char| {
        let refused =
            || place.key("checksum_between").mistake(format!("`{end}` is no ASCII character"));
        u8::try_from(end).ok().filter(u8::is_ascii).ok_or_else(refused)
    };
    let between = table.checksum_between.map(|[first, last]| Ok([byte(first)?, byte(last)?]));
    Ok(Some(TextChecksum { checksum, between: between.transpose()? }))
}

/// The signal of a field; `limits` are those of the number on the wire.
fn signal(field: &FieldTable, storage: Storage, limits: (f64, f64), place: &Place) -> Read<Signal> {
    let (factor, offset) = (field.scale.unwrap_or(1.0), field.offset.unwrap_or(0.0));
    let scale = Scale::new(factor, offset).ok_or_else(|| {
        Mistake::new(place.clone(), format!("`{}` has the scale {factor}", field.name))
            .help("a scale is finite and not zero: value = scale * number + offset")
    })?;
    let (least, greatest) = scale.range(limits.0, limits.1);
    let minimum = field.minimum.unwrap_or(least).max(least);
    let maximum = field.maximum.unwrap_or(greatest).min(greatest);
    let no_number = |end: Option<f64>| end.is_some_and(f64::is_nan);
    if no_number(field.minimum) || no_number(field.maximum) || minimum > maximum {
        let message = format!("`{}` has no value between {minimum} and {maximum}", field.name);
        return Err(Mistake::new(place.clone(), message)
            .help(format!("what it can carry goes from {least} to {greatest}")));
    }
    let signal = Signal::new(field.name.clone(), (minimum, maximum), scale, storage);
    Ok(Signal { unit: field.unit.clone(), doc: field.doc.clone(), ..signal })
}

/// Refuses keys without a meaning at this place.
fn unused(place: &Place, where_: &str, keys: &[(&str, bool)]) -> Read {
    match keys.iter().find(|(_, given)| *given) {
        Some((key, _)) => {
            Err(Mistake::new(place.key(key).name(), format!("`{key}` has no meaning {where_}")))
        }
        None => Ok(()),
    }
}

impl Coding {
    /// Encoding of a number of this type, and its number of bits.
    pub(crate) const fn of(kind: FieldType) -> (Self, usize) {
        match kind {
            FieldType::U8 => (Self::Unsigned, 8),
            FieldType::U16 => (Self::Unsigned, 16),
            FieldType::U24 => (Self::Unsigned, 24),
            FieldType::U32 => (Self::Unsigned, 32),
            FieldType::U64 => (Self::Unsigned, 64),
            FieldType::I8 => (Self::Signed, 8),
            FieldType::I16 => (Self::Signed, 16),
            FieldType::I24 => (Self::Signed, 24),
            FieldType::I32 => (Self::Signed, 32),
            FieldType::I64 => (Self::Signed, 64),
            FieldType::F32 => (Self::Float32, 32),
            FieldType::F64 => (Self::Float64, 64),
        }
    }
}

/// Eight data bits, no parity and one stop bit, unless it says otherwise.
fn settings(of: SerialTable) -> Read<SerialSettings> {
    let plain = SerialSettings::new_8n1(of.baud);
    let place = Place::file().key("serial");
    if of.baud == 0 {
        return Err(Mistake::new(place.key("baud"), "baud = 0, expected bits per second"));
    }
    let bits = |name, set: Option<u8>, usual, (least, most)| match set.unwrap_or(usual) {
        bits if (least..=most).contains(&bits) => Ok(bits),
        bits => {
            let text = format!("{name} = {bits}, expected {least} to {most}");
            Err(Mistake::new(place.key(name), text))
        }
    };
    Ok(SerialSettings {
        data_bits: bits("data_bits", of.data_bits, plain.data_bits, (5, 8))?,
        parity: of.parity.unwrap_or(plain.parity),
        stop_bits: bits("stop_bits", of.stop_bits, plain.stop_bits, (1, 2))?,
        ..plain
    })
}
