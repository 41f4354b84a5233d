//! Describes the groups and channels of a file, in blocks after its data.

use super::{CHOICES_MAX, Channel, Group};
use crate::mdf4::channels::{Form, Kind};
use crate::mdf4::laid::{self, Blocks};
use crate::mdf4::{CN_FIXED, CN_MASTER, CN_VARIABLE};
use std::fmt::Write as _;

/// Data types of channels.
const UNSIGNED: u8 = 0;
const SIGNED: u8 = 2;
const FLOAT: u8 = 4;
const UTF8: u8 = 7;
/// The master channel is a time.
const SYNC_TIME: u8 = 1;
/// The channel has an invalidation bit.
const CN_HAS_INVALID: u32 = 1 << 1;
const CC_VALUE_TO_TEXT: u8 = 7;

/// Makes the start of the file, and the blocks at `place` that describe `groups`.
pub(super) fn describe(
    place: u64,
    groups: &[Group],
    facts: &[(&str, String)],
) -> (Vec<u8>, Vec<u8>) {
    let mut blocks = Blocks::at(place);
    let mut next = 0;
    for group in groups.iter().rev() {
        next = data_group(&mut blocks, group, next);
    }
    let history = blocks.history(0);
    let comment = blocks.push(b"##MD", &[], comment(facts).as_bytes());
    (laid::begin(true, 0, next, history, comment), blocks.into_bytes())
}

/// The comment of the header, with a terminating zero.
fn comment(facts: &[(&str, String)]) -> String {
    let mut text =
        "<HDcomment xmlns=\"http://www.asam.net/mdf/v4\"><TX></TX><common_properties>".to_owned();
    for (name, value) in facts {
        // Writing to a string does not fail.
        let _ = write!(text, "<e name=\"{}\">{}</e>", escaped(name), escaped(value));
    }
    text + "</common_properties></HDcomment>\0"
}

/// Escapes text for XML 1.0. Characters that XML does not allow become spaces.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' | '\r' | '\t' => escaped.push(character),
            other if other.is_control() || matches!(other, '\u{fffe}' | '\u{ffff}') => {
                escaped.push(' ')
            }
            other => escaped.push(other),
        }
    }
    escaped
}

fn data_group(blocks: &mut Blocks, group: &Group, next: u64) -> u64 {
    let channel_group = channel_group(blocks, group);
    blocks.push(b"##DG", &[next, channel_group, group.data_at, 0], &[0; 8])
}

fn channel_group(blocks: &mut Blocks, group: &Group) -> u64 {
    let bytes: u32 = group.channels.iter().map(|channel| channel.form.kind.bytes()).sum();
    let (mut first, mut at) = (0, bytes);
    for (place, one) in group.channels.iter().enumerate().rev() {
        at -= one.form.kind.bytes();
        first = channel(blocks, one, place, at, first);
    }
    let name = blocks.text(&group.name);
    let doc = blocks.text(&group.doc);
    let mut data = Vec::new();
    // Its records have no record number.
    data.extend(0u64.to_le_bytes());
    data.extend(group.records.to_le_bytes());
    data.extend([0; 8]);
    data.extend(bytes.to_le_bytes());
    data.extend((group.channels.len().div_ceil(8) as u32).to_le_bytes());
    blocks.push(b"##CG", &[0, first, name, 0, 0, doc], &data)
}

/// The channel of that index in its group, with its values at byte `at` of a record.
fn channel(blocks: &mut Blocks, channel: &Channel, place: usize, at: u32, next: u64) -> u64 {
    let form = &channel.form;
    let name = blocks.text(&form.name);
    let unit = blocks.text(&form.unit);
    let doc = blocks.text(&form.doc);
    let conversion = conversion(blocks, channel, unit);
    let is_master = place == 0;
    let kind = match form.kind {
        _ if is_master => CN_MASTER,
        Kind::Text => CN_VARIABLE,
        _ => CN_FIXED,
    };
    let data_type = match form.kind {
        Kind::Float => FLOAT,
        Kind::Integer => SIGNED,
        Kind::Bool | Kind::Choice => UNSIGNED,
        Kind::Text => UTF8,
    };
    let sync = if is_master { SYNC_TIME } else { 0 };
    let flags = if channel.has_gaps { CN_HAS_INVALID } else { 0 };
    let mut data = vec![kind, sync, data_type, 0];
    data.extend(at.to_le_bytes());
    data.extend((8 * form.kind.bytes()).to_le_bytes());
    data.extend(flags.to_le_bytes());
    data.extend((place as u32).to_le_bytes());
    data.resize(72, 0);
    let links = [next, 0, name, 0, conversion, channel.texts_at, unit, doc];
    blocks.push(b"##CN", &links, &data)
}

/// Conversion from values to names; zero if there are none.
fn conversion(blocks: &mut Blocks, channel: &Channel, unit: u64) -> u64 {
    let Form { kind, names, .. } = &channel.form;
    let named: Vec<(f64, &str)> = match kind {
        Kind::Choice => {
            let choices = channel.choices.iter();
            choices.map(|(text, number)| (f64::from(*number), text.as_str())).collect()
        }
        Kind::Float | Kind::Integer => {
            let names = names.iter().take(CHOICES_MAX);
            names.map(|(value, name)| (*value, name.as_str())).collect()
        }
        Kind::Bool | Kind::Text => Vec::new(),
    };
    if named.is_empty() {
        return 0;
    }
    let texts: Vec<u64> = named.iter().map(|(_, name)| blocks.text(name)).collect();
    // A value without a name is not changed: the conversion for it is the identity.
    let same = match kind {
        Kind::Choice => 0,
        _ => blocks.push(b"##CC", &[0, unit, 0, 0], &conversion_data(0, 0, &[])),
    };
    let values: Vec<f64> = named.iter().map(|(value, _)| *value).collect();
    let links = [&[0, unit, 0, 0], &texts[..], &[same]].concat();
    blocks.push(b"##CC", &links, &conversion_data(CC_VALUE_TO_TEXT, texts.len() + 1, &values))
}

fn conversion_data(kind: u8, references: usize, values: &[f64]) -> Vec<u8> {
    let mut data = vec![kind, 0, 0, 0];
    // At most `CHOICES_MAX`, and one for values without a name.
    data.extend((references as u16).to_le_bytes());
    data.extend((values.len() as u16).to_le_bytes());
    data.extend([0; 16]);
    data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    data
}
