//! Content of a DBC, and handling of unusable parts.

use super::{Dbc, Dbcs};
use crate::layout::{Layout, Sender};
use std::sync::Arc;
use wire::can::Id;
use wire::device::Transmit;

/// A layout with all features of a DBC.
const RICH: &str = r#"VERSION ""

NS_ :

BS_:

BU_: ECU TOOL

BO_ 2566844926 Rich: 8 ECU
 SG_ Page M : 7|4@0+ (1,0) [0|3] "" TOOL
 SG_ Torque m0 : 3|12@0- (0.5,10) [0|0] "Nm" TOOL
 SG_ Speed m1 : 8|16@1+ (0.1,0) [0|100] "km/h" TOOL
 SG_ Ratio : 32|32@1- (1,0) [0|0] "" TOOL

BO_ 100 Wide: 8 TOOL
 SG_ Double : 0|64@1- (1,0) [0|0] "" ECU

CM_ BO_ 100 "A double.";
CM_ SG_ 2566844926 Speed "Over ground.";
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_ SG_ "GenSigStartValue" FLOAT 0 100000;
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_DEF_DEF_ "GenSigStartValue" 0;
BA_ "GenMsgCycleTime" BO_ 2566844926 50;
BA_ "GenSigStartValue" SG_ 2566844926 Speed 250;
VAL_ 2566844926 Page 0 "torque" 1 "speed" ;
SIG_VALTYPE_ 2566844926 Ratio : 1;
SIG_VALTYPE_ 100 Double : 2;
"#;

fn dbcs(files: &[(&str, &str)]) -> Vec<Arc<Dbc>> {
    let mut read = Dbcs::default();
    files.iter().map(|(file, text)| read.get(file, text).unwrap()).collect()
}

#[test]
fn a_file_is_read_once_until_it_changes() {
    let mut read = Dbcs::default();
    let first = read.get("rich.dbc", RICH).unwrap();
    assert!(Arc::ptr_eq(&first, &read.get("rich.dbc", RICH).unwrap()));
    let changed = RICH.replace("Ratio", "Share");
    let second = read.get("rich.dbc", &changed).unwrap();
    assert!(second.layout("ECU").unwrap().signal("Share").is_some());
    let of = |dbc: &Dbc, node: &str| dbc.layout(node).unwrap().messages()[0].sender;
    assert_eq!([of(&first, "ECU"), of(&first, "TOOL")], [Sender::Device, Sender::Host]);
}

#[test]
fn what_two_files_contradict_each_other_in_is_shown_in_the_second() {
    let other = RICH.replace("Ratio", "Share");
    let error = Layout::from_dbcs(&dbcs(&[("rich.dbc", RICH), ("other.dbc", &other)]), &|_| true)
        .unwrap_err();
    assert_eq!(error.file(), "other.dbc");
    assert!(other[error.range()].starts_with("BO_ 2566844926 "), "{error}");
    assert!(error.to_string().contains("in rich.dbc, line "), "{error}");
    assert!(error.advice().is_some());
    let alike =
        Layout::from_dbcs(&dbcs(&[("rich.dbc", RICH), ("copy.dbc", RICH)]), &|_| true).unwrap();
    assert_eq!(alike.messages().len(), 2);
}

#[test]
fn a_dbc_says_all_of_a_signal() {
    let layout = Layout::from_dbc("rich.dbc", RICH, "ECU").unwrap();
    let [rich, wide] = layout.messages() else { panic!("two messages") };
    assert_eq!((rich.sender, wide.sender), (Sender::Device, Sender::Host));
    assert_eq!(rich.period.map(|period| period.as_nanos()), Some(50_000_000));
    assert_eq!((wide.period, wide.doc.as_str()), (None, "A double."));
    let speed = &rich.signals[2];
    assert_eq!((speed.minimum, speed.maximum, speed.start), (0.0, 100.0, 25.0));
    assert_eq!((speed.unit.as_str(), speed.doc.as_str()), ("km/h", "Over ground."));
    assert_eq!(rich.signals[0].name_of(1.0), Some("speed"));
    assert_eq!(rich.multiplexers().collect::<Vec<_>>(), [0]);
    // Twelve bits from -2048 to 2047, in steps of a half from offset 10.
    assert_eq!((rich.signals[1].minimum, rich.signals[1].maximum), (-1014.0, 1033.5));

    let page = |values: &[f64]| {
        let Transmit::Frame(frame) = layout.encode(0, values).unwrap() else { panic!("on CAN") };
        assert!(matches!(frame.id(), Id::Extended(_)));
        (frame.data().to_vec(), layout.decoder().frame(&frame).unwrap().values.to_vec())
    };
    // Page 0 does not carry the speed, whatever its value.
    let (data, values) = page(&[0.0, -3.5, f64::NAN, 1.5]);
    assert_eq!(data[..4], [0x0f, 0xe5, 0, 0]);
    assert_eq!(values, [Some(0.0), Some(-3.5), None, Some(1.5)]);
    let (data, values) = page(&[1.0, f64::NAN, 25.0, 1.5]);
    assert_eq!(data[..4], [0x10, 250, 0, 0]);
    assert_eq!(values, [Some(1.0), None, Some(25.0), Some(1.5)]);
    let (_, values) = page(&[2.0, f64::NAN, f64::NAN, 0.0]);
    assert_eq!(values, [Some(2.0), None, None, Some(0.0)]);
}

/// With a search through all names for each, this takes minutes.
#[test]
fn names_are_found_among_tens_of_thousands() {
    let message = |number: u32| {
        format!(
            "BO_ {} M{number}: 8 ECU\n SG_ S{number} : 0|8@1+ (1,0) [0|0] \"\" TOOL\n \
             SG_ Counter : 8|8@1+ (1,0) [0|0] \"\" TOOL\n",
            (1 << 31) + number
        )
    };
    const MESSAGES: u32 = 20_000;
    let text: String = (0..MESSAGES).map(message).collect();
    let layout = Layout::from_dbc("large.dbc", &format!("BU_: ECU TOOL\n{text}"), "ECU").unwrap();
    for number in 0..MESSAGES {
        let index = number as usize;
        assert_eq!(layout.find(&format!("M{number}")), Some(index));
        assert_eq!(layout.signal(&format!("S{number}")), Some((index, 0)));
        assert_eq!(layout.signal(&format!("M{number}.Counter")), Some((index, 1)));
        assert_eq!(layout.signal(&format!("M{number}.Count")), None);
        assert_eq!(layout.sent_signal(Sender::Host, &format!("S{number}")), None);
    }
    assert_eq!(layout.signal("Counter"), None);
}

/// The nearest number of 32 bits is 4294967296, one beyond the range.
#[test]
fn a_range_may_end_between_two_floating_point_numbers() {
    let layout = layout(
        "BO_ 100 M: 8 ECU\n SG_ F : 0|32@1- (-1,-40) [-4294967335|-40] \"\" TOOL\n\
         SIG_VALTYPE_ 100 F : 1;",
    );
    assert_eq!(notes(&layout), [""; 0]);
    let signal = &layout.messages()[0].signals[0];
    assert_eq!((signal.minimum, signal.maximum), (-4_294_967_335.0, -40.0));
    let least = signal.nearest(signal.minimum);
    assert_eq!(least, -4_294_967_080.0, "256 is the distance of such numbers there");
}

/// A DBC with these messages, sent by `ECU`.
fn layout(messages: &str) -> Layout {
    let text = format!("BU_: ECU TOOL\n{messages}");
    Layout::from_dbc("test.dbc", &text, "ECU").unwrap_or_else(|error| panic!("{error}"))
}

fn notes(layout: &Layout) -> Vec<String> {
    layout.notes().iter().map(ToString::to_string).collect()
}

/// The bytes of the first message with these values.
fn bytes(layout: &Layout, values: &[f64]) -> Vec<u8> {
    let Transmit::Frame(frame) = layout.encode(0, values).unwrap() else { panic!("on CAN") };
    let mut decoder = layout.decoder();
    let message = &layout.messages()[0];
    let read = decoder.frame(&frame).unwrap().values;
    for (place, (read, value)) in read.iter().zip(values).enumerate() {
        let carried = message.carries(place, values).then_some(*value);
        assert_eq!(*read, carried, "{}", message.signals[place].name);
    }
    frame.data().to_vec()
}

#[test]
fn what_says_so_or_is_long_is_of_can_fd() {
    let layout = layout(
        r#"BO_ 1 Classic: 8 ECU
BO_ 2 Short: 8 ECU
BO_ 3 Long: 64 ECU
 SG_ A : 500|12@1+ (1,0) [0|0] "" TOOL
BO_ 4 Slow: 10 ECU
BO_ 2147483653 Group: 1786 ECU
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","J1939PG","StandardCAN_FD";
BA_DEF_ BO_ "CANFD_BRS" ENUM "0","1";
BA_DEF_DEF_ "VFrameFormat" "StandardCAN";
BA_DEF_DEF_ "CANFD_BRS" "1";
BA_ "VFrameFormat" BO_ 2 3;
BA_ "VFrameFormat" BO_ 2147483653 2;
BA_ "CANFD_BRS" BO_ 4 0;
"#,
    );
    let frame = |name: &str| {
        let message = layout.find(name).unwrap();
        let values = vec![7.0; layout.messages()[message].signals.len()];
        let Ok(Transmit::Frame(frame)) = layout.encode(message, &values) else { panic!("{name}") };
        (frame.data().len(), frame.fd_flags().map(|flags| flags.bits()))
    };
    assert_eq!(
        ["Classic", "Short", "Long", "Slow"].map(frame),
        [(8, None), (8, Some(1)), (64, Some(1)), (12, Some(0))]
    );
    let why = layout.left_out("Group").unwrap().to_string();
    assert!(why.contains("it has 1786 bytes, and J1939 1785 at most"), "{why}");
}

#[test]
fn what_cannot_be_used_is_left_out_alone() {
    let layout = layout(
        r#"BO_ 1 Endless: 65 ECU
 SG_ A : 0|8@1+ (1,0) [0|0] "" TOOL
BO_ 2 Again: 8 ECU
BO_ 4294967295 Far: 8 ECU
BO_ 2 Known: 2 ECU
 SG_ Kept : 0|4@1+ (1,0) [0|0] "" TOOL
 SG_ Outside : 12|8@1+ (1,0) [0|0] "" TOOL
 SG_ Whole : 0|16@1+ (1,0) [0|0] "" TOOL
 SG_ Nothing : 4|1@1+ (0,0) [0|0] "" TOOL
 SG_ Half : 0|16@1- (1,0) [0|0] "" TOOL
 SG_ Page m1 : 5|1@1+ (1,0) [0|0] "" TOOL
 SG_ Kept : 6|1@1+ (1,0) [0|0] "" TOOL
BO_ 300000 Long: 8 ECU
SIG_VALTYPE_ 2 Half : 1;
"#,
    );
    insta::assert_snapshot!(notes(&layout).join("\n"));
    let names: Vec<&str> = layout.messages().iter().map(|known| known.name.as_str()).collect();
    assert_eq!(names, ["Known", "Long"]);
    let signals: Vec<&str> =
        layout.messages()[0].signals.iter().map(|signal| signal.name.as_str()).collect();
    assert_eq!(signals, ["Kept", "Page"]);
    assert!(matches!(layout.messages()[1].can_id(), Some(Id::Extended(_))));
    let help = layout.resolve("Known.Outside").unwrap_err();
    assert!(help.advice().contains("do not lie in the 2 bytes"), "{}", help.advice());
    assert!(layout.left_out("Endless").is_some() && layout.left_out("Endless.A").is_some());
    assert!(layout.left_out("Kept").is_some() && layout.left_out("Long").is_none());
}

#[test]
fn a_range_without_a_value_is_that_of_the_bits() {
    let layout = layout(
        r#"BO_ 1 M: 8 ECU
 SG_ Turned : 0|4@1+ (1,0) [1|0] "" TOOL
 SG_ Beyond : 4|4@1+ (1,0) [20|30] "" TOOL
 SG_ Between : 8|4@1+ (10,0) [1|9] "" TOOL
 SG_ None : 12|4@1- (1,0) [1.#QNAN|1] "" TOOL
 SG_ Wide : 16|4@1+ (0.5,0) [-5|5] "" TOOL
"#,
    );
    let ranges: Vec<_> =
        layout.messages()[0].signals.iter().map(|one| (one.minimum, one.maximum)).collect();
    assert_eq!(ranges, [(0.0, 15.0), (0.0, 15.0), (0.0, 150.0), (-8.0, 7.0), (0.0, 5.0)]);
    assert_eq!(layout.notes().len(), 4);
    assert!(layout.notes().iter().all(|note| !note.is_left_out));
}

#[test]
fn multiplexers_below_multiplexers_with_ranges() {
    let layout = layout(
        r#"BO_ 1 M: 4 ECU
 SG_ Top M : 0|4@1+ (1,0) [0|0] "" TOOL
 SG_ Low m1M : 4|4@1+ (1,0) [0|1] "" TOOL
 SG_ A m0 : 8|8@1+ (1,0) [0|0] "" TOOL
 SG_ B m0 : 8|8@1+ (2,0) [0|0] "" TOOL
 SG_ C m7 : 8|8@1- (1,0) [0|0] "" TOOL
 SG_ All : 16|8@1+ (1,0) [0|0] "" TOOL
SG_MUL_VAL_ 1 Low Top 1-1;
SG_MUL_VAL_ 1 A Top 0-0, 3-5;
SG_MUL_VAL_ 1 B Low 0-3;
SG_MUL_VAL_ 1 C Low 7-7, 9-15;
"#,
    );
    let message = &layout.messages()[0];
    assert_eq!(message.multiplexers().collect::<Vec<_>>(), [0, 1]);
    assert_eq!(message.pages(0).into_iter().collect::<Vec<_>>(), [0, 1, 3, 5]);
    assert_eq!(message.pages(1).into_iter().collect::<Vec<_>>(), [0, 3, 7, 9, 15]);
    // The declared range of `Low` lacks most of its numbers.
    assert_eq!((message.signals[1].maximum, layout.notes().len()), (15.0, 1));
    assert_eq!(bytes(&layout, &[4.0, 0.0, 9.0, 8.0, -1.0, 6.0]), [0x04, 9, 6, 0]);
    assert_eq!(bytes(&layout, &[1.0, 2.0, 9.0, 8.0, -1.0, 6.0]), [0x21, 4, 6, 0]);
    assert_eq!(bytes(&layout, &[1.0, 9.0, 9.0, 8.0, -1.0, 6.0]), [0x91, 0xff, 6, 0]);
    assert_eq!(bytes(&layout, &[2.0, 9.0, 9.0, 8.0, -1.0, 6.0]), [0x02, 0, 6, 0]);
    assert_eq!(
        message.selections(4).map(ToString::to_string).collect::<Vec<_>>(),
        ["7 or 9 to 15", "1"]
    );
}

#[test]
fn sections_come_in_any_order_and_what_is_of_no_use_is_passed_over() {
    let text = "NS_ :\n\tNS_DESC_\n\tCM_\n\tNEW_THING_\n\nBS_: 500 : 1,2\r\n// a comment\r\n\
        VAL_ 1 S 1 \"on\" 0 \"off; or \\\"not\\\"\" ;\r\nVAL_ Environment 0 \"x\" ;\n\
        CM_ \"two\nlines\"\nBA_ \"GenMsgCycleTime\" BO_ 1 20;\nEV_ E: 0 [0|1] \"\" 0 1 DUMMY_NODE_VECTOR0 A;\n\
        BA_DEF_REL_ BU_SG_REL_ \"x\" INT 0 1;\nVAL_TABLE_ T 0 \"a;b\" ;\nSIG_GROUP_ 1 G 1 : S;\n\
        BO_ 1 M : 1 Vector__XXX\n SG_ S:0|1@1+(1,0)[0|0]\"\"A,B\n\nBO_TX_BU_ 1 : A,B;\n\
        BA_DEF_DEF_ \"SystemSignalLongSymbol\" \"\";\nBA_ \"SystemSignalLongSymbol\" SG_ 1 S \"AVeryLongName\";\nBU_: A B";
    let dbc = Dbc::parse("t.dbc", text).unwrap();
    let nodes: Vec<_> =
        dbc.nodes().iter().map(|node| (node.name.as_str(), node.messages)).collect();
    assert_eq!(nodes, [("A", 1), ("B", 1)]);
    let layout = Layout::from_dbc("t.dbc", text, "B").unwrap();
    let message = &layout.messages()[0];
    assert_eq!((message.sender, message.signals.len()), (Sender::Device, 1));
    assert_eq!(message.period.map(|period| period.as_nanos()), Some(20_000_000));
    let signal = &message.signals[0];
    assert_eq!(signal.name, "AVeryLongName");
    assert_eq!(signal.name_of(0.0), Some("off; or \"not\""));
    let nothing = Layout::from_dbc("t.dbc", "BU_:", "A").unwrap_err();
    assert_eq!(nothing.advice(), Some("the DBC names no node and has no message"));
    let nobody = Layout::from_dbc("t.dbc", "BO_ 1 M: 1\nBO_ 2 N: 1 Vector__XXX", super::NOBODY);
    assert!(nobody.unwrap().messages().iter().all(|message| message.sender == Sender::Device));
}

/// As in files of opendbc.
#[test]
fn a_comment_on_something_unnamed_is_left_out() {
    let text = "BU_: A\nBO_ 1 M: 8 A\n SG_ S : 0|8@1+ (1,0) [0|100] \"\" A\nCM_ SG_ 1 \"lost; here\";\nCM_ 1 \"too\";\n\
        CM_ BO_ 1 \"kept\";\n";
    let layout = Layout::from_dbc("t.dbc", text, "A").unwrap();
    assert_eq!(layout.messages()[0].doc, "kept");
    assert_eq!(layout.messages()[0].signals.len(), 1);
}

#[test]
fn what_is_no_dbc_says_what_was_expected_and_where() {
    let good = "BU_: A\nBO_ 1 M: 8 A\n SG_ S : 0|8@1+ (0.5,0) [0|100] \"V\" A\nCM_ BO_ 1 \"x\";\n";
    let changes = [
        ("BO_ 1", "BO 1"),
        ("BO_ 1 M:", "BO_ M 1:"),
        ("M: 8", "M 8"),
        ("S :", "S m :"),
        ("0|8", "0-8"),
        ("@1+", "@2+"),
        ("(0.5,0)", "(0,5,0)"),
        ("(0.5,0)", "(x,0)"),
        ("[0|100]", "[0,100]"),
        ("\"V\"", "V"),
        ("\"x\"", "\"x"),
        ("\"x\"", "\"x\" y"),
        ("BO_ 1 M: 8 A\n", ""),
    ];
    let shown: Vec<String> = changes
        .iter()
        .map(|(from, to)| {
            let text = good.replacen(from, to, 1);
            let error = Layout::from_dbc("t.dbc", &text, "A").unwrap_err();
            let at = &text[error.range()];
            format!("{from}  ->  {to}\n  {}\n  at {at:?}; {:?}\n", error.message(), error.advice())
        })
        .collect();
    insta::assert_snapshot!(shown.join("\n"));
}

proptest::proptest! {
    /// Any text is either read or refused with a position.
    #[test]
    fn no_text_makes_the_reader_panic(
        from in 0..RICH.len(), length in 0usize..40, with in "[ -~\n]{0,12}|(SG_|BO_|M|m1|\"|;|:|0-0)"
    ) {
        let to = (from + length).min(RICH.len());
        let text = format!("{}{with}{}", &RICH[..from], &RICH[to..]);
        if let Err(error) = Dbc::parse("t.dbc", &text) {
            proptest::prop_assert!(error.range().end <= text.len());
        }
    }
}

/// Vector's files for J1939 mark counters.
#[test]
fn a_counter_that_is_marked_counts() {
    let text = "BU_: A\nBO_ 1 M: 2 A\n SG_ Count : 0|2@1+ (1,0) [0|3] \"\" A\n SG_ Value : 8|8@1+ (1,0) [0|255] \"\" A\n\
        BA_DEF_ SG_ \"SigType\" ENUM \"Default\",\"Range\",\"MessageCounter\";\n\
        BA_DEF_DEF_ \"SigType\" \"Default\";\nBA_ \"SigType\" SG_ 1 Count 2;\n";
    let layout = Layout::from_dbc("a.dbc", text, "A").unwrap();
    assert_eq!(layout.messages()[0].counter_signal(), Some(0));
    let mut encoder = crate::layout::Encoder::new(layout.clone());
    let counts: Vec<_> = (0..5)
        .map(|_| {
            layout.messages()[0]
                .count(&encoder.encode(0, &[0.0, 7.0], |_| false).unwrap().whole().unwrap())
        })
        .collect();
    assert_eq!(counts, [0, 1, 2, 3, 0].map(Some));
    let unmarked = Layout::from_dbc("a.dbc", &text.replace("Count 2", "Count 1"), "A").unwrap();
    assert_eq!(unmarked.messages()[0].counter_signal(), None);
}
