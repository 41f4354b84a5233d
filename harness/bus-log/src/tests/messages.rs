//! Reading files of other tools, and messages about files that cannot be read.

use super::samples::{read, written};
use crate::{Entry, Format, Payload};
use miette::Diagnostic;
use std::fmt::Write;
use wire::can::{CanFrame, FdFlags, StandardId};

/// One entry per line as in candump, to the nanosecond.
fn table(entries: &[Entry]) -> String {
    let mut text = String::new();
    for entry in entries {
        let line = String::from_utf8(written(Format::Candump, &[*entry])).unwrap();
        let frame = line.split_once(' ').unwrap().1;
        write!(text, "{:>20} {frame}", entry.at.as_nanos()).unwrap();
    }
    text
}

fn message(format: Format, text: &str) -> String {
    let (entries, error) = read(format, text.as_bytes());
    let error = error.unwrap_or_else(|| panic!("{entries:?} from {text:?}"));
    let help = error.help().map(|help| format!("\n  help: {help}")).unwrap_or_default();
    format!("{error}{help}\n")
}

/// Every kind of line that a version has, from the description of the format.
const TRC_1_0: &str = ";   Start time: 11.09.2002 16:00:20.682\r\n\
    ;----+- ---+--- ----+--- + -+ -- -- ...\r\n\
    1)    1841     0001 8 00 00 00 00 00 00 00 00\r\n\
    2)    1842     0008 4 ERROR 00 19 08 08\r\n\
    3)    1843 FFFFFFFF 4 00 00 00 04 -- -- -- -- BUSLIGHT\r\n\
    4)    1844 00000100 3 RTR\r\n";
const TRC_1_1: &str = ";$FILEVERSION=1.1\n;$STARTTIME=44548.6028595139\n\
    1)  1059.9  Rx         0300  7  00 00 00 00 04 00 00\n\
    5)  1346.8  Warng  FFFFFFFF  4  00 00 00 04  BUSLIGHT\n\
    6)  1349.2  Error      0008  4  00 19 08 08\n\
    7)  1352.7  Tx         0100  3  RTR\n";
const TRC_1_3: &str = ";$FILEVERSION=1.3\n;$STARTTIME=44548.6028595139\n\
    1)      6357.213 2  Rx        0401 -  8    00 00 00 00 00 00 00 00\n\
    3)      6357.682 1  Warng FFFFFFFF -  4    00 00 00 04 BUSLIGHT\n\
    4)      6377.180 1  Tx    000004A1 -  0\n";
const TRC_2_0: &str = ";$FILEVERSION=2.0\n;$STARTTIME=44548.6028595139\n;$COLUMNS=N,O,T,I,d,l,D\n\
    1      1059.900 DT     0300 Rx 7  00 00 00 00 04 00 00\n\
    5      1334.416 FD     0500 Tx 12 01 02 03 04 05 06 07 08 09 0A 0B 0C\n\
    6      1334.522 ER          Rx    04 00 02 00 00\n\
    7      1334.531 ST          Rx    00 00 00 08\n\
    8      1334.643 EC          Rx    02 02\n\
    9      1335.156 DT 18EFC034 Tx 8  01 02 03 04 05 06 07 08\n\
   10      1336.543 RR     0100 Rx 3\n";
const TRC_2_1: &str = ";$FILEVERSION=2.1\n;$STARTTIME=44548.6028595139\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n\
    1      1059.900 DT 1      0300 Rx -  7    00 00 00 00 04 00 00\n\
    5      1334.416 FB 2      0500 Tx -  12   01 02 03 04 05 06 07 08 09 0A 0B 0C\n\
    5      1334.417 FE 2  00000500 Tx -  9    01 02 03 04 05 06 07 08 09 0A 0B 0C\n\
    6      1334.522 ER 1         - Rx -  5    04 00 02 00 00\n\
    7      1334.524 EV 1  User-defined event for bus 1\n\
    8      1334.525 EV -  User-defined event for all busses\n\
   12      1335.156 DT 1  18EFC034 Tx -  12   01 02 03 04 05 06 07 08\n\
   13      1336.543 RR 1      0100 Rx -  3\n";

#[test]
fn what_other_tools_write_is_read() {
    let candump = "(1436509052.249713) vcan0 044#2A366C2BBA\r\n\
        \n\
        (1436509052.249713123) vcan0 7ff#\n\
        (0.5) can1 1fffffff#R\n\
        (0000000000.000001) can1 123#R8_9 R\n\
        (0.000001) can1 123#11.22.33 T\n\
        (0.000001) can1 123##1AABB\n\
        (0.000001) can1 123##0\n\
        (0.000001) can1 20000080#\n\
        (0.000001) can1 20000004#0001000000000000";
    let asc = "date Sat Sep 30 15:06:13.191 2017\n\
        base dec  timestamps relative\n\
        no internal events logged\n\
        // a comment\n\
        Begin Triggerblock Sat Sep 30 15:06:13.191 2017\n   \
           0.000000 Start of measurement\n   \
           0.015991 CAN 1 Status:chip status error passive - TxErr: 132 RxErr: 0\n   \
           0.100000 1  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%\n   \
           0.100000 1  2047            Rx   d 8 1 2 3 4 5 6 7 255  Length = 240015 BitCount = 124\n   \
           0.100000 2  100             Tx   r\n   \
           0.100000 2  536870911x      Rx   r 3\n   \
           0.100000 1  ErrorFrame  ECC: 10100010\n   \
           0.100000 CANFD   1 Rx        300  Name 1 0 9 12 1 2 3 4 5 6 7 8 9 10 11 12 130000 130 303000 0\n   \
           0.100000 CANFD   1 Tx        300       0 0 2  2 1 255   130000  130   200000 0 0 0 0 0\n   \
           0.100000 CANFD   1 Tx        300       0 0 8  0   130000  130   200010 0 0 0 0 0\n   \
           0.100000 CANFD   1 Rx   ErrorFrame   Not Acknowledge error\n   \
           0.100000 1  100             TxRq d 0\n\
        End TriggerBlock\n";
    let mut text = String::new();
    let logs = [
        (Format::Candump, candump),
        (Format::Asc, asc),
        (Format::Trc, TRC_1_0),
        (Format::Trc, TRC_1_1),
        (Format::Trc, TRC_1_3),
        (Format::Trc, TRC_2_0),
        (Format::Trc, TRC_2_1),
    ];
    for (format, log) in logs {
        let (entries, error) = read(format, log.as_bytes());
        assert!(error.is_none(), "{error:?}");
        write!(text, "{}\n{}", format.name(), table(&entries)).unwrap();
    }
    insta::assert_snapshot!(text);
}

/// Every log of every tool begins so: it is nothing that is missing.
#[test]
fn the_start_of_a_measurement_is_not_passed_over() {
    for (event, passed_over) in [("Start of measurement", 0), ("1  Statistic: D 0 R 0", 1)] {
        let log = format!("0.0 {event}\n0.1 1  64  Rx   d 1 02\n");
        let path = std::path::Path::new("bus.asc");
        let input = std::io::Cursor::new(log);
        let mut reader = crate::LogReader::new(path, input, Format::Asc).unwrap();
        assert_eq!(reader.by_ref().filter(|entry| entry.is_ok()).count(), 1);
        assert_eq!(reader.passed_over(), passed_over, "{event}");
    }
}

#[test]
fn what_is_not_understood_has_its_message() {
    let long = format!("(1.0) can0 123#{}", "0".repeat(5_000));
    let text: String = [
        (Format::Candump, "(1.0) can0 123#00\n1436509052.249713 vcan0 044#2A\n"),
        (Format::Candump, "(1.x) can0 123#00"),
        (Format::Candump, "(1.0) a-name-of-16-char 123#00"),
        (Format::Candump, "(1.0) can0 123"),
        (Format::Candump, "(1.0) can0 800#00"),
        (Format::Candump, "(1.0) can0 0123#00"),
        (Format::Candump, "(1.0) can0 123#000"),
        (Format::Candump, "(1.0) can0 123#000102030405060708"),
        (Format::Candump, "(1.0) can0 123#R9"),
        (Format::Candump, "(1.0) can0 123##0000102030405060708"),
        (Format::Candump, "(1.0) can0 123#00 X"),
        (Format::Candump, "(1.0) can0 123#00 T and more"),
        (Format::Candump, "\u{1b}[31mred, and a line that goes on for longer than is shown"),
        (Format::Candump, &long),
        (Format::Candump, "  vcan0  123   [2]  11 22\n"),
        (Format::Candump, " (1436509052.249713)  vcan0  123   [2]  11 22\n"),
        (Format::Asc, "base oct"),
        (Format::Asc, "base hex timestamps somehow"),
        (Format::Asc, "12 1 100 Rx d 1 00"),
        (Format::Asc, "0.5 1 800 Rx d 1 00"),
        (Format::Asc, "base dec\n0.5 1 7FF Rx d 1 00"),
        (Format::Asc, "0.5 1 100 Rx d 8 00 01"),
        (Format::Asc, "0.5 1 100 Rx d 1 100"),
        (Format::Asc, "0.5 1 100 Rx q 1 00"),
        (Format::Asc, "0.5 CANFD 1 Rx 100 0 0 9 13 00"),
        (Format::Asc, "0.5 CANFD 0 Rx 100 0 0 1 1 00"),
        (Format::Pcapng, "(1.0) can0 123#00"),
        (Format::Blf, "(1.0) can0 123#00"),
        (Format::Mdf4, "(1.0) can0 123#00"),
        (Format::Trc, ";$FILEVERSION=3.0"),
        (Format::Trc, ";$STARTTIME=noon"),
        (Format::Trc, ";$COLUMNS=N,O,T,B,I,d,R,D,L"),
        (Format::Trc, ";$FILEVERSION=2.1\n1 5.0 DT 1 0300 Rx - 0"),
        (Format::Trc, "1) 5 0800 1 00"),
        (Format::Trc, "1) 5 0123 2 00"),
        (Format::Trc, "1) 5 0123 x 00"),
        (Format::Trc, "1) soon 0123 1 00"),
        (Format::Trc, ";$FILEVERSION=1.1\n1) 5.0 Xx 0123 1 00"),
        (Format::Trc, ";$COLUMNS=O,T,B,I,d,l,D\n5.0 DT 0 0123 Rx 1 00"),
        (Format::Trc, ";$COLUMNS=O,T,B,I,d,l,D\n5.0 DT 1 0123 Zx 1 00"),
        (Format::Trc, ";$COLUMNS=O,T,B,I,d,l,D\n5.0 RR 1 0123 Rx 9"),
        (Format::Trc, ";$COLUMNS=O,T,B,I,d,l,D\n5.0 FD 1 0123 Rx 9 00 01 02 03 04 05 06 07 08"),
        (Format::Trc, ";$COLUMNS=O,T,B,I,d,l,D\n9300000000000.0 DT 1 0123 Rx 1 00"),
        (Format::Trc, ";$STARTTIME=132300\n1) 9000000000 0123 1 00"),
    ]
    .into_iter()
    .map(|(format, text)| message(format, text))
    .collect();
    insta::assert_snapshot!(text);
}

/// Found by a user: the lines of an ASC log in UTF-16 were all passed over.
#[test]
fn a_log_in_utf_16_is_refused_and_the_mark_of_utf_8_is_not_read() {
    let asc = "base hex  timestamps absolute\n   0.500000 1  123  Rx   d 1 05\n";
    let utf_16 = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
        "\u{feff}".encode_utf16().chain(asc.encode_utf16()).flat_map(bytes).collect()
    };
    for (format, bytes) in [
        (Format::Asc, utf_16(u16::to_le_bytes)),
        (Format::Asc, utf_16(u16::to_be_bytes)),
        (Format::Candump, utf_16(u16::to_le_bytes)),
        (Format::Trc, utf_16(u16::to_le_bytes)),
    ] {
        let error = read(format, &bytes).1.unwrap();
        assert!(error.to_string().ends_with("expected text in UTF-8, found `UTF-16`"), "{error}");
        assert!(error.help().unwrap().to_string().contains("iconv -f UTF-16"));
    }
    let marked = "\u{feff}(1.5) can0 123#00\n";
    let (entries, error) = read(Format::Candump, marked.as_bytes());
    assert!(error.is_none() && entries.len() == 1, "{error:?}");
}

#[test]
fn a_capture_that_is_cut_short_is_good_up_to_there() {
    let id = StandardId::new(0x123).unwrap();
    let entry = Entry {
        at: wire::time::Timestamp::from_nanos(7),
        channel: crate::Channel::CAN0,
        direction: None,
        payload: Payload::Frame(CanFrame::fd(id, FdFlags::default(), &[1; 64]).unwrap()),
    };
    let whole = written(Format::Pcapng, &[entry, entry]);
    let (entries, error) = read(Format::Pcapng, &whole[..whole.len() - 1]);
    assert_eq!(entries, [entry]);
    let message = error.unwrap().to_string();
    assert!(message.ends_with("expected a whole block, found `the end of the file`"), "{message}");
}

#[test]
fn there_is_nothing_before_1970() {
    let at = wire::time::Timestamp::from_nanos(-1);
    let channel = crate::Channel::CAN0;
    let payload = Payload::Error(crate::ErrorFrame::BUS_ERROR);
    let entry = Entry { at, channel, direction: None, payload };
    for format in Format::ALL {
        let path = std::path::Path::new("bus.log");
        let mut writer =
            crate::LogWriter::new(path, std::io::Cursor::new(Vec::new()), format).unwrap();
        let message = writer.write(&entry).unwrap_err().to_string();
        let end = format!("an entry before 1970 has no place in {}", format.name());
        assert!(message.ends_with(&end), "{message}");
    }
}
