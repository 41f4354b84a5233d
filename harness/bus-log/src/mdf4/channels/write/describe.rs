//! Describes the groups and channels of a file, in blocks after its data.

use super::{CHOICES_MAX, Channel, Group};
use crate::mdf4::channels::{Form, Kind};
use crate::mdf4::laid::{self, Blocks, FLOAT, Records, SIGNED, UNSIGNED, UTF8, Values};
use crate::mdf4::{CN_FIXED, CN_MASTER, CN_VARIABLE};

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
        next = group_of(&mut blocks, group, next);
    }
    let history = blocks.history(0);
    let comment = blocks.push(b"##MD", &[], laid::comment(facts).as_bytes());
    (laid::begin(true, 0, next, history, comment), blocks.into_bytes())
}

fn group_of(blocks: &mut Blocks, group: &Group, next: u64) -> u64 {
    let bytes: u32 = group.channels.iter().map(|channel| channel.form.kind.bytes()).sum();
    let (mut first, mut at) = (0, bytes);
    for (place, one) in group.channels.iter().enumerate().rev() {
        at -= one.form.kind.bytes();
        first = channel(blocks, one, place, at, first);
    }
    let name = blocks.text(&group.name);
    let doc = blocks.text(&group.doc);
    let invalid_bytes = group.channels.len().div_ceil(8) as u32;
    let records = Records { count: group.records, flags: 0, bytes, invalid_bytes };
    blocks.group([first, name, 0, doc], records, group.data_at, next)
}

/// The channel of that index in its group, with its values at byte `at` of a record.
fn channel(blocks: &mut Blocks, channel: &Channel, place: usize, at: u32, next: u64) -> u64 {
    let form = &channel.form;
    let name = blocks.text(&form.name);
    let unit = blocks.text(&form.unit);
    let doc = blocks.text(&form.doc);
    let conversion = conversion(blocks, channel, unit);
    let kind = match form.kind {
        _ if place == 0 => CN_MASTER,
        Kind::Text => CN_VARIABLE,
        _ => CN_FIXED,
    };
    let data_type = match form.kind {
        Kind::Float => FLOAT,
        Kind::Integer => SIGNED,
        Kind::Bool | Kind::Choice => UNSIGNED,
        Kind::Text => UTF8,
    };
    let flags = if channel.has_gaps { CN_HAS_INVALID } else { 0 };
    let bytes = form.kind.bytes();
    let values = Values { kind, data_type, at, bytes, flags, invalid_bit: place as u32 };
    let links = [next, 0, name, 0, conversion, channel.texts_at, unit, doc];
    blocks.channel(links, values)
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
    let mut texts: Vec<u64> = named.iter().map(|(_, name)| blocks.text(name)).collect();
    // A value without a name is not changed: the conversion for it is the identity.
    texts.push(match kind {
        Kind::Choice => 0,
        _ => blocks.conversion(0, unit, &[], &[]),
    });
    let values: Vec<f64> = named.iter().map(|(value, _)| *value).collect();
    // At most `CHOICES_MAX` references, and one for values without a name.
    blocks.conversion(CC_VALUE_TO_TEXT, unit, &texts, &values)
}
