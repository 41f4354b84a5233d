//! What a DBC says, and what becomes of what cannot be used.

use crate::layout::{Layout, Sender};
use wire::can::Id;
use wire::device::Transmit;

/// A layout with all that a DBC may say.
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

#[test]
fn what_two_files_contradict_each_other_in_is_shown_in_the_second() {
    let other = RICH.replace("Ratio", "Share");
    let error =
        Layout::from_dbcs(&[("rich.dbc", RICH), ("other.dbc", &other)], &|_| true).unwrap_err();
    assert_eq!(error.file(), "other.dbc");
    assert!(other[error.range()].starts_with("BO_ 2566844926 "), "{error}");
    assert!(error.to_string().contains("in rich.dbc, line "), "{error}");
    assert!(error.advice().is_some());
    let alike = Layout::from_dbcs(&[("rich.dbc", RICH), ("copy.dbc", RICH)], &|_| true).unwrap();
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
    // Twelve bits from -2048 to 2047, by half and from 10 on.
    assert_eq!((rich.signals[1].minimum, rich.signals[1].maximum), (-1014.0, 1033.5));

    let page = |values: &[f64]| {
        let Transmit::Frame(frame) = layout.encode(0, values).unwrap() else { panic!("on CAN") };
        assert!(matches!(frame.id(), Id::Extended(_)));
        (frame.data().to_vec(), layout.decoder().frame(&frame).unwrap().values.to_vec())
    };
    // The speed is not in page 0, whatever it is.
    let (data, values) = page(&[0.0, -3.5, f64::NAN, 1.5]);
    assert_eq!(data[..4], [0x0f, 0xe5, 0, 0]);
    assert_eq!(values, [Some(0.0), Some(-3.5), None, Some(1.5)]);
    let (data, values) = page(&[1.0, f64::NAN, 25.0, 1.5]);
    assert_eq!(data[..4], [0x10, 250, 0, 0]);
    assert_eq!(values, [Some(1.0), None, Some(25.0), Some(1.5)]);
    let (_, values) = page(&[2.0, f64::NAN, f64::NAN, 0.0]);
    assert_eq!(values, [Some(2.0), None, None, Some(0.0)]);
}
