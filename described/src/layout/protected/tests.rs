//! Counters and checksums of descriptions: the content of frames, and each mistake at its place.

use crate::layout::Encoder;
use crate::layout::tests::described;
use crate::{Decoder, Description, Layout, Verdict};
use miette::{GraphicalReportHandler, GraphicalTheme};
use wire::can::CanFrame;
use wire::device::Transmit;

pub(crate) const DBC: &str = r#"VERSION ""

BU_: Cells Manager

BO_ 256 CellStatus: 8 Cells
 SG_ Crc : 0|8@1+ (1,0) [0|255] "" Manager
 SG_ Alive : 8|4@1+ (1,0) [0|15] "" Manager
 SG_ IdPart : 12|4@1+ (1,0) [0|15] "" Manager
 SG_ Voltage : 16|16@1+ (0.001,0) [0|65.535] "V" Manager
 SG_ Page M : 32|8@1+ (1,0) [0|255] "" Manager
 SG_ Serial m0 : 40|8@1+ (1,0) [0|255] "" Manager
 SG_ Wide : 48|16@1+ (1,0) [0|65535] "" Manager

BO_ 512 Request: 8 Manager
 SG_ Limit : 7|16@0+ (0.1,0) [0|6553.5] "A" Cells
 SG_ Count : 16|3@1+ (1,0) [0|5] "" Cells
 SG_ Sum : 63|8@0+ (1,0) [0|255] "" Cells
"#;

/// The description of the cells with these lines for their messages.
pub(crate) fn cells(rest: &str) -> Result<Description, crate::FileError> {
    let text = format!("name = \"cells\"\ndbc = \"pack.dbc\"\nnode = \"Cells\"\n{rest}");
    Description::parse("cells.toml", &text, &mut |_| Ok(DBC.to_owned()))
}

fn layout(rest: &str) -> Layout {
    cells(rest).unwrap_or_else(|error| panic!("{error}")).layout().clone()
}

fn frame(encoder: &mut Encoder, message: &str, values: &[f64]) -> CanFrame {
    let message = encoder.layout().find(message).unwrap();
    match encoder.encode(message, values, |_| false).unwrap().whole().unwrap() {
        Transmit::Frame(frame) => frame,
        Transmit::Bytes(_) => panic!("on CAN"),
    }
}

fn verdict(decoder: &mut Decoder, frame: &CanFrame) -> Verdict {
    decoder.frame(frame).unwrap().verdict.unwrap()
}

pub(crate) const E2E: &str = "[message.CellStatus]\nperiod_s = 0.1\n\
    e2e = { profile = \"1C\", data_id = 0x123, counter = \"Alive\", checksum = \"Crc\" }\n";
pub(crate) const PLAIN: &str = "[message.Request]\ncounter = { signal = \"Count\", first = 4 }\n\
    checksum = { signal = \"Sum\", crc = \"crc8-autosar\", prepend = [0x02, 0x00] }\n";

/// Found by a user: nothing told of a device that sends more bytes than its DBC has.
#[test]
fn longer_and_shorter_frames_are_counted() {
    let dbc = DBC.replace("Request: 8 Manager", "Request: 4 Manager").replace("63|8@0+", "24|8@1+");
    let layout = Layout::from_dbc("pack.dbc", &dbc, "Manager").unwrap();
    let mut decoder = layout.decoder();
    let read = [3, 4, 8].map(|bytes| {
        let id = wire::can::StandardId::new(512).unwrap();
        decoder.frame(&CanFrame::new(id, &[7; 8][..bytes]).unwrap()).is_some()
    });
    assert_eq!(read, [false, true, true]);
    let counts = |counts: Vec<(&crate::Message, u64)>| {
        counts.into_iter().map(|(message, count)| (message.name.clone(), count)).collect::<Vec<_>>()
    };
    let (short, long) = (counts(decoder.short().collect()), counts(decoder.long().collect()));
    let one = vec![("Request".to_owned(), 1)];
    assert_eq!((short, long, decoder.damaged()), (one.clone(), one, 1));
}

/// A checksum in a signal that cannot be read is explained by what is wrong with the signal.
#[test]
fn a_checksum_in_a_signal_that_was_left_out_is_explained() {
    let dbc = DBC.replace("Crc : 0|8@1+", "Crc : 0|80@1+");
    let text = format!("name = \"cells\"\ndbc = \"pack.dbc\"\nnode = \"Cells\"\n{E2E}");
    let error = Description::parse("cells.toml", &text, &mut |_| Ok(dbc.clone())).unwrap_err();
    assert_eq!(error.message(), "`CellStatus` has no usable signal `Crc`");
    assert_eq!(&text[error.range()], "\"Crc\"");
    let why = error.advice().unwrap();
    assert!(why.contains("pack.dbc, line 6") && why.contains("the signal is left out"), "{why}");
    let line = Layout::from_dbc("pack.dbc", &dbc, "Cells").unwrap();
    let text =
        "[[line]]\nmessage.CellStatus = { checksum = { signal = \"Crc\", crc = \"sum8\" } }\n";
    let tables: toml::Table = text.parse().unwrap();
    let tables = tables["line"][0]["message"].clone().try_into().unwrap();
    let error = line.protected(("rig.toml", text, 0), &tables).unwrap_err();
    assert_eq!(error.advice(), Some(why));
    assert_eq!(&text[error.range()], "\"Crc\"");
}

#[test]
fn a_message_of_a_dbc_has_autosars_bytes() {
    let mut encoder = Encoder::new(layout(E2E));
    let zeros = [0.0; 7];
    // The published example of profile 1 with a nibble of the data id.
    assert_eq!(frame(&mut encoder, "CellStatus", &zeros).data(), [0x2a, 0x10, 0, 0, 0, 0, 0, 0]);
    assert_eq!(frame(&mut encoder, "CellStatus", &zeros).data(), [0x77, 0x11, 0, 0, 0, 0, 0, 0]);
    encoder.reset();
    assert_eq!(frame(&mut encoder, "CellStatus", &zeros).data(), [0x2a, 0x10, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn a_counter_goes_to_the_end_of_its_signals_range_and_a_checksum_covers_the_rest() {
    let layout = layout(PLAIN);
    let (mut encoder, mut decoder) = (Encoder::new(layout.clone()), layout.decoder());
    let mut counts = Vec::new();
    for _ in 0..5 {
        let frame = frame(&mut encoder, "Request", &[25.6, 0.0, 0.0]);
        assert_eq!(frame.data()[..2], [0x01, 0x00]);
        let covered = [&[0x02, 0x00], &frame.data()[..7]].concat();
        let crc = crc::Crc::<u8>::new(&crc::CRC_8_AUTOSAR).checksum(&covered);
        assert_eq!(frame.data()[7], crc);
        counts.push(frame.data()[2]);
        assert_eq!(verdict(&mut decoder, &frame), Verdict::Ok);
    }
    assert_eq!(counts, [4, 5, 0, 1, 2]);
}

#[test]
fn a_decoder_judges_each_message_by_itself() {
    let layout = layout(&format!("{E2E}{PLAIN}"));
    let (mut encoder, mut decoder) = (Encoder::new(layout.clone()), layout.decoder());
    let status = frame(&mut encoder, "CellStatus", &[0.0; 7]);
    let request = frame(&mut encoder, "Request", &[0.0; 3]);
    assert_eq!(verdict(&mut decoder, &status), Verdict::Ok);
    assert_eq!(verdict(&mut decoder, &request), Verdict::Ok);
    assert_eq!(verdict(&mut decoder, &status), Verdict::Repeated);
    frame(&mut encoder, "Request", &[0.0; 3]);
    let third = frame(&mut encoder, "Request", &[0.0; 3]);
    assert_eq!(verdict(&mut decoder, &third), Verdict::Lost(1));
    decoder.reset();
    assert_eq!(verdict(&mut decoder, &status), Verdict::Ok);
    let mut data = [0; 8];
    data.copy_from_slice(status.data());
    data[4] ^= 1;
    let damaged = CanFrame::new(status.id(), &data).unwrap();
    assert_eq!(verdict(&mut decoder, &damaged), Verdict::WrongChecksum);
}

/// Also on a serial line, where messages are long enough for profile 4.
#[test]
fn a_packet_has_its_header_behind_its_start() {
    let description = described(
        "name = \"d\"\n[serial]\nbaud = 9600\n[[message]]\nname = \"M\"\nsent_by = \"device\"\n\
         period_s = 1\nstart = [0xAA]\nchecksum = \"sum8\"\n\
         e2e = { profile = \"4\", data_id = 0x0a0b0c0d, counter = \"Count\", checksum = \"Crc\" }\n\
         fields = [{ name = \"Length\", type = \"u16\" }, { name = \"Count\", type = \"u16\", order = \"big\" },\n\
         { name = \"Id\", type = \"u32\" }, { name = \"Crc\", type = \"u32\", order = \"big\" },\n\
         { name = \"Value\", type = \"u32\" }]\n",
    );
    let mut encoder = Encoder::new(description.layout().clone());
    let sent = encoder.encode(0, &[0.0; 5], |_| false).unwrap().whole();
    let Some(Transmit::Bytes(packet)) = sent else { panic!() };
    // The published example of profile 4, between the start byte and the sum.
    let example = [0, 0x10, 0, 0, 0x0a, 0x0b, 0x0c, 0x0d, 0x86, 0x2b, 0x05, 0x56, 0, 0, 0, 0];
    assert_eq!(packet.as_slice()[1..17], example);
    let mut verdicts = Vec::new();
    description
        .layout()
        .decoder()
        .bytes(packet.as_slice(), &mut |found| verdicts.push(found.verdict));
    assert_eq!(verdicts, [Some(Verdict::Ok)]);
}

#[test]
fn a_counter_of_half_a_byte_is_in_no_field() {
    let text = "name = \"d\"\n[[message]]\nname = \"M\"\nsent_by = \"device\"\ncan_id = 1\nperiod_s = 1\n\
                e2e = { profile = \"1A\", data_id = 1, counter = \"Count\", checksum = \"Crc\" }\n\
                fields = [{ name = \"Crc\", type = \"u8\" }, { name = \"Count\", type = \"u8\" }]\n";
    let error = Description::parse("d.toml", text, &mut |name| Err(name.to_owned())).unwrap_err();
    let help = miette::Diagnostic::help(&error).unwrap().to_string();
    assert!(help.contains("a signal of a DBC can have 4 bits"), "{help}");
}

#[test]
fn mistakes_are_shown_where_they_are() {
    let e2e =
        "e2e = { profile = \"1A\", data_id = 0x123, counter = \"Alive\", checksum = \"Crc\" }";
    let counter = "counter = { signal = \"Alive\" }";
    let checksum = "checksum = { signal = \"Crc\", crc = \"crc8-sae-j1850\" }";
    let cases = [
        e2e.replace("data_id = 0x123, ", ""),
        e2e.replace("0x123", "0x12345"),
        e2e.replace("\"1A\"", "\"2\""),
        e2e.replace("\"1A\"", "\"7\""),
        e2e.replace("\"1A\", data_id = 0x123", "\"2\", data_ids = [1, 2]"),
        e2e.replace("\"1A\"", "\"5\""),
        e2e.replace("\"1A\"", "\"1C\"").replace("Alive", "IdPart"),
        e2e.replace("Crc", "Serial"),
        e2e.replace("\"Alive\"", "\"Alvie\""),
        format!("{e2e}\n{counter}"),
        counter.replace("Alive\"", "Alive\", modulo = 17"),
        counter.replace("Alive\"", "Alive\", first = 16"),
        counter.replace("Alive\"", "Alive\", step = 0"),
        checksum.replace("\"Crc\"", "\"Alive\""),
        checksum.replace("sae-j1850", "sea-j1850"),
        checksum.replace("850\"", "850\", bytes = [1, 8]"),
        format!(
            "{counter}\n{}",
            checksum.replace("\"Crc\"", "\"Alive\"").replace("crc8-sae-j1850", "sum8")
        ),
        "checksum = \"crc8-sae-j1850\"".to_owned(),
    ];
    let shown = cases.map(|case| {
        let text = format!("[message.CellStatus]\nperiod_s = 0.1\n{case}\n");
        let error = cells(&text).expect_err(&case);
        let mut shown = format!("{case}\n");
        let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor());
        handler.with_width(100).render_report(&mut shown, &error).unwrap();
        shown
    });
    insta::assert_snapshot!(shown.join("\n"));
}
