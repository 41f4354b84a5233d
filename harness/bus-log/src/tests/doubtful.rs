//! Files that can be read, in which something may be wrong: the reader says so.

use super::samples::{read, written};
use crate::{Channel, Direction, Entry, Format, LogReader, Payload};
use std::io::Cursor;
use std::path::Path;
use wire::can::{CanFrame, FdFlags, StandardId};
use wire::time::Timestamp;

const DATE_NS: i64 = 1_762_957_325_123_000_000;

fn notes(format: Format, bytes: &[u8]) -> Vec<String> {
    let mut reader = LogReader::new(Path::new("bus.log"), Cursor::new(bytes), format).unwrap();
    assert!(reader.by_ref().all(|entry| entry.is_ok()));
    reader.notes()
}

fn asc(date: &[u8]) -> Vec<u8> {
    let event = b"\nbase hex  timestamps absolute\n   0.500000 1  123  Rx   d 1 05\n";
    [b"date ", date, event].concat()
}

fn entry() -> Entry {
    let frame = CanFrame::new(StandardId::new(0x123).unwrap(), &[1, 2, 3]).unwrap();
    Entry {
        at: Timestamp::from_nanos(DATE_NS),
        channel: Channel::CAN0,
        direction: Some(Direction::Rx),
        payload: Payload::Frame(frame),
    }
}

#[test]
fn a_date_may_be_in_the_language_of_the_machine() {
    for date in [&b"Mi Nov 12 14:22:05.123 2025"[..], b"mer. nov. 12 02:22:05.123 pm 2025"] {
        let (entries, _) = read(Format::Asc, &asc(date));
        assert_eq!(entries[0].at, Timestamp::from_nanos(DATE_NS + 500_000_000));
        assert!(notes(Format::Asc, &asc(date)).is_empty());
    }
    // In Latin-1.
    let march = asc(b"Mi M\xe4r 12 14:22:05.123 2025");
    assert_eq!(read(Format::Asc, &march).0[0].at.as_nanos() / 1_000_000_000, 1_741_789_325);
}

#[test]
fn a_date_that_is_not_understood_is_told() {
    let strange = asc(b"12.11.2025 14:22:05");
    assert_eq!(read(Format::Asc, &strange).0[0].at, Timestamp::from_nanos(500_000_000));
    let told = "the date `12.11.2025 14:22:05` in line 1 is not understood: times count from 1970";
    assert_eq!(notes(Format::Asc, &strange), [told]);
    let begun = [&strange[..], b"Begin Triggerblock Mi Nov 12 14:22:05.123 2025\n"].concat();
    assert!(notes(Format::Asc, &begun).is_empty());
}

#[test]
fn a_last_line_without_an_end_is_told() {
    let entry = entry();
    for format in [Format::Candump, Format::Asc, Format::Trc] {
        let whole = written(format, &[entry; 2]);
        assert!(notes(format, &whole).is_empty(), "{format:?}");
        let end = String::from_utf8_lossy(&whole).rfind("03").unwrap() + 2;
        assert_eq!(notes(format, &whole[..end]).len(), 1, "{format:?}");
    }
    // A whole file, whose closing line has no line break.
    let whole = written(Format::Asc, &[entry]);
    assert!(notes(Format::Asc, whole.trim_ascii_end()).is_empty());
    // Found by a user: cut in the white space before an event.
    for format in [Format::Candump, Format::Asc, Format::Trc] {
        let cut = [&written(format, &[entry; 2])[..], b"   "].concat();
        assert_eq!(notes(format, &cut).len(), 1, "{format:?}");
    }
    let shorter = b"(1.000000) can0 123#112233\n(1.000000) can0 123#1122";
    assert_eq!(read(Format::Candump, shorter).0.len(), 2);
    assert_eq!(notes(Format::Candump, shorter).len(), 1);
}

#[test]
fn a_canfd_event_whose_flags_are_zero_is_a_can_fd_frame() {
    let line =
        format!("30.506898 CANFD 4 Rx 4EE 0 0 f 64 {}1331984 11 0 46500250\n", "a1 ".repeat(64));
    let (entries, error) = read(Format::Asc, line.as_bytes());
    assert!(error.is_none(), "{error:?}");
    let (id, flags) = (StandardId::new(0x4ee).unwrap(), FdFlags::from_bits(0));
    let expected = CanFrame::fd(id, flags, &[0xa1; 64]).unwrap();
    assert_eq!(entries[0].payload, Payload::Frame(expected));
}

#[test]
fn a_blf_file_without_the_containers_of_its_head_is_cut() {
    let entry = entry();
    let whole = written(Format::Blf, &[entry; 6_000]);
    let second = whole[200..].windows(4).position(|four| four == b"LOBJ").unwrap() + 200;
    for (end, least) in [(144, 0), (second, 2_700)] {
        let (found, error) = read(Format::Blf, &whole[..end]);
        assert!(found.len() >= least, "{} entries", found.len());
        let told = error.unwrap().to_string();
        assert!(told.contains(&format!("after {end} of {} bytes", whole.len())), "{told}");
    }
    assert!(read(Format::Blf, &written(Format::Blf, &[])).1.is_none());
}
