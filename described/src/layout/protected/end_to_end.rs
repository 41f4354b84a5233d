//! AUTOSAR's profiles: their data ids and the positions of their fields in a message.

use crate::bits::BitField;
use crate::error::{Mistake, Read};
use crate::file::ByteOrder;
use crate::file::{E2eTable, Profile};
use crate::layout::message::{Message, Protected};
use crate::place::Place;
use crate::protection::{Counter, DataId, E2e, PROFILE_1_COUNTER_MAX, Protection, Seal};

impl Message {
    pub(super) fn end_to_end(&self, table: &E2eTable, place: &Place) -> Read<Protected> {
        let profile = table.profile;
        let (counter, counter_field) = self.bits_of(&table.counter, &place.key("counter"))?;
        let (checksum, crc_field) = self.bits_of(&table.checksum, &place.key("checksum"))?;
        for (key, name, field, bits) in [
            ("counter", &table.counter, counter_field, profile.bits().0),
            ("checksum", &table.checksum, crc_field, profile.bits().1),
        ] {
            if field.length() != bits {
                let text = format!(
                    "the {key} of profile {} has {bits} bits, and `{name}` has {}",
                    profile.name(),
                    field.length()
                );
                let mistake = Mistake::new(place.key(key), text);
                let has_whole_bytes = field.length() % 8 == 0;
                return Err(if has_whole_bytes && bits % 8 > 0 {
                    mistake.help(format!(
                        "a signal of a DBC can have {bits} bits; fields of `[[message]]` have whole bytes"
                    ))
                } else {
                    mistake
                });
            }
        }
        let length = self.payload().len();
        let crc_at = *crc_field.bytes().start();
        let e2e = e2e(table, crc_at, *counter_field.bytes().start(), place)?;
        let little =
            |start: usize, bits| BitField::new(ByteOrder::Little, start as u64, bits, length);
        let big = |start: usize, bits| BitField::new(ByteOrder::Big, start as u64, bits, length);
        let half = 4 * (*counter_field.bytes().start() * 2);
        let (right, where_) = match &e2e {
            E2e::Profile1 { data_id: DataId::Nibble(..), .. } => {
                ([little(half, 4), None], "the low half of a byte".to_owned())
            }
            E2e::Profile1 { .. } => {
                ([little(half, 4), little(half + 4, 4)], "half of a byte".to_owned())
            }
            E2e::Profile2 { .. } => ([little(8, 4), None], "the low half of byte 1".to_owned()),
            E2e::Profile4 { at, .. } => (
                [big(8 * (at + 2) + 7, 16), None],
                format!("bytes {} and {}, the most significant first", at + 2, at + 3),
            ),
            E2e::Profile5 { at, .. } => {
                ([little(8 * (at + 2), 8), None], format!("byte {}", at + 2))
            }
        };
        let wrong = |key: &str, name: &str, where_: &str| {
            let text = format!("`{name}` is not where profile {} has its {key}", profile.name());
            Mistake::new(place.key(key), text).help(format!("expected {where_}"))
        };
        if !e2e.crc_field(length).is_some_and(|field| crc_field.is_same(field)) {
            let where_ = match profile {
                Profile::P1A | Profile::P1B | Profile::P1C => "one whole byte",
                Profile::P2 => "byte 0",
                Profile::P4 => {
                    "four whole bytes after eight of the header, the most significant first"
                }
                Profile::P5 => "two whole bytes, the least significant first",
            };
            return Err(wrong("checksum", &table.checksum, where_));
        }
        if !right.into_iter().flatten().any(|field| counter_field.is_same(field)) {
            return Err(wrong("counter", &table.counter, &where_));
        }
        let most = u64::MAX >> (u64::BITS - profile.bits().0);
        let (first, greatest) = match e2e {
            E2e::Profile1 { .. } => (0, PROFILE_1_COUNTER_MAX),
            // Its sender increments the counter before sending.
            E2e::Profile2 { .. } => (1, most),
            E2e::Profile4 { .. } | E2e::Profile5 { .. } => (0, most),
        };
        let max_delta = table.max_delta;
        if max_delta.is_some_and(|delta| !(1..=greatest).contains(&delta)) {
            let text = "no such difference of the counter";
            return Err(place.key("max_delta").mistake(text).help(format!("from 1 to {greatest}")));
        }
        let field = counter_field;
        let counting = Counter { field, first, step: 1, greatest, max_delta };
        let protection = Protection { counter: Some(counting), seal: Some(Seal::E2e(e2e)) };
        Ok(Protected { protection, counter: Some(counter), checksum: Some(checksum) })
    }
}

/// The profile with its data id; the CRC begins in byte `crc_at`, the counter is in `counter_at`.
fn e2e(table: &E2eTable, crc_at: usize, counter_at: usize, place: &Place) -> Read<E2e> {
    let profile = table.profile;
    let name = profile.name();
    let (one, several) = ("data_id", "data_ids");
    if profile == Profile::P2 {
        if table.data_id.is_some() {
            let text = "profile 2 has sixteen data ids";
            return Err(Mistake::new(place.key(one).name(), text).help("write `data_ids = [...]`"));
        }
        let ids = table.data_ids.as_ref().ok_or_else(|| {
            Mistake::new(place.clone(), "profile 2 needs its `data_ids`")
                .help("sixteen bytes, one a number of the counter")
        })?;
        let data_ids = ids.as_slice().try_into().map_err(|_| {
            let text = format!("{} data ids, and profile 2 has sixteen", ids.len());
            Mistake::new(place.key(several), text)
        })?;
        return Ok(E2e::Profile2 { data_ids });
    }
    if table.data_ids.is_some() {
        let text = format!("profile {name} has one data id");
        return Err(Mistake::new(place.key(several).name(), text).help("write `data_id = 0x...`"));
    }
    let id = table.data_id.ok_or_else(|| {
        Mistake::new(place.clone(), format!("profile {name} needs a `data_id`"))
            .help("the number by which sender and receiver know the message: `data_id = 0x123`")
    })?;
    if id > profile.data_id_max() {
        let text = format!("{id:#x} is no data id of profile {name}");
        return Err(Mistake::new(place.key(one), text)
            .help(format!("at most {:#x}", profile.data_id_max())));
    }
    let short = id as u16;
    Ok(match profile {
        Profile::P1A => E2e::Profile1 { data_id: DataId::Both(short), crc_at },
        Profile::P1B => E2e::Profile1 { data_id: DataId::Alternating(short), crc_at },
        // The high half of the counter's byte.
        Profile::P1C => {
            E2e::Profile1 { data_id: DataId::Nibble(short, 8 * counter_at + 4), crc_at }
        }
        Profile::P4 => {
            let at = crc_at.checked_sub(8).ok_or_else(|| {
                let text = "the CRC of profile 4 is after eight bytes of the header";
                Mistake::new(place.key("checksum"), text)
            })?;
            E2e::Profile4 { data_id: id, at }
        }
        Profile::P2 | Profile::P5 => E2e::Profile5 { data_id: short, at: crc_at },
    })
}
