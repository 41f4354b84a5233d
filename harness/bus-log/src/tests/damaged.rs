//! Files truncated or altered at every byte: everything before the damage is good, and nothing panics.

use super::samples::{read, written};
use crate::{Channel, Direction, Entry, ErrorFrame, Format, Payload};
use wire::can::{CanFrame, ExtendedId, FdFlags, StandardId};
use wire::time::Timestamp;

fn entries() -> Vec<Entry> {
    let standard = StandardId::new(0x123).unwrap();
    let extended = ExtendedId::new(0x123_4567).unwrap();
    let payloads = [
        Payload::Frame(CanFrame::new(standard, &[1, 2, 3]).unwrap()),
        Payload::Frame(CanFrame::fd(extended, FdFlags::from_bits(1), &[7; 20]).unwrap()),
        Payload::Frame(CanFrame::of_word(0x4000_0123, None, 4, &[]).unwrap()),
        Payload::Error(ErrorFrame::BUS_ERROR),
        Payload::Frame(CanFrame::new(extended, &[9; 8]).unwrap()),
    ];
    let entry = |(index, payload): (usize, Payload)| Entry {
        at: Timestamp::from_nanos(1_506_783_973_191_000_000 + index as i64 * 250_000),
        channel: Channel::numbered(index as u32 % 2),
        direction: (!matches!(payload, Payload::Error(_))).then_some(Direction::Rx),
        payload,
    };
    payloads.into_iter().enumerate().map(entry).collect()
}

#[test]
fn a_file_that_is_cut_is_good_up_to_there() {
    let entries = entries();
    for format in [Format::Trc, Format::Blf, Format::Mdf4] {
        let whole = written(format, &entries);
        let (found, error) = read(format, &whole);
        assert!(error.is_none() && found == entries, "{error:?}");
        let mut told = 0;
        for length in 0..whole.len() {
            let (found, error) = read(format, &whole[..length]);
            // A truncated line may be read as another one.
            let good = found.len().saturating_sub(usize::from(format == Format::Trc));
            let mut rest = entries.iter();
            let expected: Vec<_> = match format {
                // The data of its groups lie one behind the other.
                Format::Mdf4 => {
                    found.iter().filter(|one| rest.any(|other| other == *one)).collect()
                }
                _ => entries[..good].iter().collect(),
            };
            let found: Vec<_> = found[..good].iter().collect();
            assert_eq!(found, expected, "{format:?} of {length} bytes");
            told += usize::from(error.is_some());
        }
        assert!(format == Format::Trc || told > whole.len() - 10, "{told} of {}", whole.len());
    }
}

/// The list of the blocks with the data lies behind them.
#[test]
fn of_a_cut_file_the_blocks_before_are_read_without_their_list() {
    let (first, all) = (entries()[0], 10_000_i64);
    let entry = |index| Entry {
        at: Timestamp::from_nanos(first.at.as_nanos() + index * 1_000_003),
        ..first
    };
    let entries: Vec<Entry> = (0..all).map(entry).collect();
    let whole = written(Format::Mdf4, &entries);
    for (percent, least) in [(60, 4_096), (95, 2 * 4_096)] {
        let (found, error) = read(Format::Mdf4, &whole[..whole.len() * percent / 100]);
        assert!(found.len() >= least && found.len() < all as usize, "{} entries", found.len());
        assert_eq!(found, entries[..found.len()]);
        let help = miette::Diagnostic::help(&error.unwrap()).unwrap().to_string();
        assert!(help.contains(&format!("{} entries before that are good", found.len())), "{help}");
    }
    // Without the last byte, everything is there.
    let (found, error) = read(Format::Mdf4, &whole[..whole.len() - 1]);
    assert!(found == entries, "{error:?}");
}

/// Behind compressed data stands their checksum.
#[test]
fn a_changed_bit_of_compressed_data_is_told() {
    let first = entries()[0];
    let entry = |index: i64| {
        let data = index.wrapping_mul(0x9e37_79b9_7f4a_7c15_u64.cast_signed()).to_le_bytes();
        Entry {
            at: Timestamp::from_nanos(first.at.as_nanos() + index * 1_000_003),
            payload: Payload::Frame(CanFrame::new(StandardId::new(0x123).unwrap(), &data).unwrap()),
            ..first
        }
    };
    let entries: Vec<Entry> = (0..200).map(entry).collect();
    let whole = written(Format::Mdf4, &entries);
    let block = whole.windows(4).position(|mark| mark == b"##DZ").unwrap();
    let length = u64::from_le_bytes(whole[block + 40..block + 48].try_into().unwrap()) as usize;
    assert!(length > 500, "{length}");
    for place in block + 48..block + 48 + length {
        let mut changed = whole.clone();
        changed[place] ^= 1 << (place % 8);
        let (found, error) = read(Format::Mdf4, &changed);
        assert!(error.is_some() || found == entries, "byte {place}");
    }
}

/// Their blocks are told apart by the lengths of their records.
#[test]
fn of_a_cut_file_the_blocks_of_several_groups_are_read() {
    let of_kind = |index: i64| match index % 3 {
        0 => 0,
        1 => 2,
        _ => 3,
    };
    let entry = |index| Entry {
        at: Timestamp::from_nanos(entries()[0].at.as_nanos() + index * 1_000_003),
        ..entries()[of_kind(index)]
    };
    let all: Vec<Entry> = (0..30_000).map(entry).collect();
    let whole = written(Format::Mdf4, &all);
    let group = |entry: &Entry| match &entry.payload {
        Payload::Frame(frame) => Some(frame.is_remote()),
        _ => None,
    };
    for (percent, least) in [(50, 4_096), (95, 2 * 4_096)] {
        let (found, error) = read(Format::Mdf4, &whole[..whole.len() * percent / 100]);
        assert!(found.is_sorted_by_key(|entry| entry.at));
        for one in &all[..3] {
            let of_group = |other: &&Entry| group(other) == group(one);
            let found: Vec<_> = found.iter().filter(of_group).collect();
            assert!(found.len() >= least, "{} entries", found.len());
            assert!(found.iter().copied().eq(all.iter().filter(of_group).take(found.len())));
        }
        let help = miette::Diagnostic::help(&error.unwrap()).unwrap().to_string();
        let good =
            format!("the file seems to be cut short; {} entries before that are good", found.len());
        assert_eq!(help, good);
    }
}

#[test]
fn help_says_whether_a_file_is_cut_and_how_much_of_it_is_good() {
    let help = |format, bytes: &[u8]| {
        let error = read(format, bytes).1.unwrap_or_else(|| panic!("{format:?}: no error"));
        miette::Diagnostic::help(&error).unwrap().to_string()
    };
    for format in [Format::Pcapng, Format::Blf, Format::Mdf4] {
        let empty = read(format, b"").1.unwrap().to_string();
        assert!(empty.ends_with(": the file is empty"), "{empty}");
    }
    let log = written(Format::Candump, &entries());
    let cut = help(Format::Candump, &log[..log.len() - b"9 R\n".len()]);
    assert_eq!(cut, "the file seems to be cut short; 4 entries before that are good");
    let second = log.iter().position(|byte| *byte == b'\n').unwrap() + 1;
    let broken = [&log[..second], b"x", &log[second..]].concat();
    assert_eq!(help(Format::Candump, &broken), "1 entry before that is good");
    assert!(help(Format::Blf, &log).starts_with("--from candump, "));
    let blf = written(Format::Blf, &entries());
    let cut = help(Format::Blf, &blf[..blf.len() - 20]);
    assert!(cut.starts_with("the file seems to be cut short"), "{cut}");
}

#[test]
fn a_byte_that_is_another_makes_nothing_panic() {
    for format in [Format::Trc, Format::Blf, Format::Mdf4] {
        let whole = written(format, &entries());
        for place in 0..whole.len() {
            for other in [1, 0x7f, 0x80, 0xff] {
                let mut bytes = whole.clone();
                bytes[place] ^= other;
                let (found, _) = read(format, &bytes);
                assert!(found.len() <= whole.len(), "{format:?} at {place}");
            }
        }
    }
}
