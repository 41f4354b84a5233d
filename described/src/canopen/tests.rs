mod errors;

use super::{Abort, Progress, SdoClient};
use crate::{Description, Device, FileError};
use proptest::prelude::*;
use std::sync::{Arc, LazyLock};
use wire::can::{CanFrame, Id, StandardId};
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

const EDS: &str = include_str!("../../../examples/rotary-table/devices/drive.eds");
const DRIVE: &str = include_str!("../../../examples/rotary-table/devices/drive.toml");

fn described(toml: &str, eds: &str) -> Result<Description, FileError> {
    Description::parse("drive.toml", toml, &mut |_| Ok(eds.to_owned()))
}

/// The drive of the example, with a 64-bit object beside its own.
static KNOWN: LazyLock<Arc<Description>> = LazyLock::new(|| {
    let long =
        "[2000]\nParameterName=Long\nDataType=0x1B\nAccessType=rw\nDefaultValue=1\nPDOMapping=1\n";
    Arc::new(described(DRIVE, &format!("{EDS}\n{long}")).unwrap())
});

fn frame(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::new(StandardId::new(id).unwrap(), data).unwrap()
}

fn at_ms(ms: i64) -> Timestamp {
    Timestamp::ZERO + Span::from_millis(ms)
}

/// A device, and the time that it has come to.
struct Bus {
    device: Device,
    now: Timestamp,
}

impl Bus {
    /// Pre-operational, its boot-up message sent.
    fn new() -> Self {
        Self::of(Arc::clone(&KNOWN))
    }

    fn of(description: Arc<Description>) -> Self {
        let mut bus = Self { device: Device::new(description, 1), now: Timestamp::ZERO };
        assert_eq!(bus.until(at_ms(0)), [(0, 0x705, vec![0])]);
        bus
    }

    /// Sends a frame; returns what the device sends at once.
    fn say(&mut self, id: u16, data: &[u8]) -> Vec<(u16, Vec<u8>)> {
        self.device.receive_frame(self.now, &frame(id, data));
        self.sent().into_iter().map(|(_, id, data)| (id, data)).collect()
    }

    fn sent(&mut self) -> Vec<(i64, u16, Vec<u8>)> {
        let ms = (self.now - Timestamp::ZERO).as_nanos() / 1_000_000;
        let sent = std::iter::from_fn(|| self.device.transmit());
        let sent = sent.map(|what| {
            let Transmit::Frame(frame) = what else { panic!("it is on CAN") };
            let Id::Standard(id) = frame.id() else { panic!("its identifiers have 11 bits") };
            (ms, id.as_raw(), frame.data().to_vec())
        });
        sent.collect()
    }

    /// What the device sends by itself until then, with its time in ms.
    fn until(&mut self, end: Timestamp) -> Vec<(i64, u16, Vec<u8>)> {
        let mut sent = Vec::new();
        let mut wakes = 0;
        while self.device.next_wakeup() <= end {
            self.now = self.now.max(self.device.next_wakeup());
            self.device.wake(self.now);
            wakes += 1;
            assert!(wakes < 100_000, "it is woken for ever at {:?}", self.now);
            sent.extend(self.sent());
        }
        self.now = end;
        sent
    }

    fn transfer(&mut self, object: (u16, u8), write: Option<Vec<u8>>) -> Result<Vec<u8>, Abort> {
        let (mut client, mut words) = SdoClient::new(self.now, object, write);
        for _ in 0..100 {
            let answer = self.say(0x605, &words);
            let words_of = |(id, data): &(u16, Vec<u8>)| {
                (*id == 0x585).then(|| *data.first_chunk::<8>().unwrap())
            };
            let answer = answer.iter().find_map(words_of).expect("an answer");
            match client.receive(self.now, &answer) {
                Progress::Send(next) => words = next,
                Progress::Done(bytes) => return Ok(bytes),
                Progress::Aborted(why) | Progress::Senseless(why) => return Err(why),
                Progress::Nothing => panic!("no progress"),
            }
        }
        panic!("the transfer does not end");
    }

    fn write(&mut self, object: (u16, u8), bytes: &[u8]) -> Result<(), Abort> {
        self.transfer(object, Some(bytes.to_vec())).map(drop)
    }
}

#[test]
fn numbers_of_more_than_four_bytes_and_texts_go_in_segments() {
    let mut bus = Bus::new();
    assert_eq!(bus.transfer((0x1008, 0), None).unwrap(), b"Rotary table");
    let long = 0xFEDC_BA98_7654_3210u64.to_le_bytes();
    bus.write((0x2000, 0), &long).unwrap();
    assert_eq!(bus.transfer((0x2000, 0), None).unwrap(), long, "all 64 bits");
    assert_eq!(bus.write((0x2000, 0), &[1; 9]), Err(Abort(0x0607_0012)));
    assert_eq!(bus.transfer((0x6064, 0), None).unwrap(), [0; 4]);
    assert_eq!(
        Abort(0x0602_0000).to_string(),
        "0602 0000h (object does not exist in the object dictionary)"
    );
}

#[test]
fn an_event_sends_a_pdo_no_sooner_than_its_inhibit_time_and_the_timer_without_one() {
    let mut bus = Bus::new();
    // Inhibit time 40 ms, event timer 100 ms; the heartbeat is off.
    for (object, bytes) in [
        ((0x1017, 0), vec![0, 0]),
        ((0x1800, 1), 0x8000_0185u32.to_le_bytes().to_vec()),
        ((0x1800, 3), 400u16.to_le_bytes().to_vec()),
        ((0x1800, 5), 100u16.to_le_bytes().to_vec()),
        ((0x1800, 1), 0x185u32.to_le_bytes().to_vec()),
    ] {
        bus.write(object, &bytes).unwrap();
    }
    assert_eq!(bus.say(0, &[1, 5]), [(0x185, vec![0x50, 0x02, 1])]);
    bus.until(at_ms(5));
    assert_eq!(bus.say(0x205, &[6, 0]), [], "within the inhibit time");
    let times: Vec<_> =
        bus.until(at_ms(300)).iter().map(|(ms, id, data)| (*ms, *id, data[0])).collect();
    assert_eq!(times, [(40, 0x185, 0x31), (140, 0x185, 0x31), (240, 0x185, 0x31)]);
    assert_eq!(bus.say(0x205, &[7, 0]), [(0x185, vec![0x33, 0x02, 1])]);
    assert_eq!(bus.say(0, &[128, 0]), []);
    assert_eq!(bus.say(0x205, &[15, 0]), [], "no PDO is heard before it is operational");
    assert_eq!(bus.device.value("controlword"), Some(7.0));
}

#[test]
fn a_pdo_that_loses_its_identifier_while_its_timer_runs_is_sent_no_more() {
    let mut bus = Bus::new();
    bus.write((0x1800, 5), &[100, 0]).unwrap();
    bus.say(0, &[1, 5]);
    bus.write((0x1800, 1), &0x8000_0185u32.to_le_bytes()).unwrap();
    bus.say(0x205, &[6, 0]);
    for ms in [100, 200, 300] {
        assert!(bus.until(at_ms(ms)).iter().all(|(_, id, _)| *id != 0x185));
        assert!(bus.device.next_wakeup() > at_ms(ms), "it would be woken for ever");
    }
}

#[test]
fn a_pdo_that_is_too_short_is_an_emergency_and_changes_nothing() {
    let mut bus = Bus::new();
    bus.say(0, &[1, 0]);
    let emergencies = [(0x85, vec![0x10, 0x82, 0x11, 0, 0, 0, 0, 0]), (0x85, vec![0; 8])];
    assert_eq!(bus.say(0x205, &[6]), emergencies);
    assert_eq!(bus.device.value("controlword"), Some(0.0));
}

/// Sub-index 0 of 1003h, whether the EDS has each sub-index or says how many there are.
#[test]
fn the_error_history_counts_the_errors() {
    let (begin, end) = (EDS.find("[1003]").unwrap(), EDS.find("[1005]").unwrap());
    let history = "[1003]\nParameterName=Errors\nObjectType=0x8\nDataType=0x0007\nAccessType=ro\n";
    let compact = format!("{}{history}CompactSubObj=4\n\n{}", &EDS[..begin], &EDS[end..]);
    let compact = Arc::new(described(DRIVE, &compact).unwrap());
    for mut bus in [Bus::new(), Bus::of(compact)] {
        bus.say(0, &[1, 0]);
        for count in 0..3u8 {
            assert_eq!(bus.transfer((0x1003, 0), None).unwrap(), [count]);
            bus.say(0x205, &[6]);
        }
        assert_eq!(bus.transfer((0x1003, 1), None).unwrap(), [0x10, 0x82, 0, 0]);
        assert_eq!(bus.write((0x1003, 0), &[4]), Err(Abort::RANGE));
        bus.write((0x1003, 0), &[0]).unwrap();
        assert_eq!(bus.transfer((0x1003, 0), None).unwrap(), [0]);
    }
}

#[test]
fn a_received_pdo_of_a_synchronous_type_waits_for_the_sync() {
    let mut bus = Bus::new();
    bus.write((0x1402, 2), &[1]).unwrap();
    bus.say(0, &[1, 5]);
    bus.say(0x405, &20_000u32.to_le_bytes());
    assert_eq!(bus.device.value("target_velocity"), Some(0.0));
    assert_eq!(bus.say(0x80, &[]), [(0x285, vec![0; 8])]);
    assert_eq!(bus.device.value("target_velocity"), Some(20.0));
    // Beyond its limits it is left out.
    bus.say(0x405, &2_000_000u32.to_le_bytes());
    bus.say(0x80, &[]);
    assert_eq!(bus.device.value("target_velocity"), Some(20.0));
}

/// TPDO2 is sent at each SYNC, until its identifier is marked as not valid (CiA 301, 7.5.2.35).
#[test]
fn a_synchronous_pdo_that_is_switched_off_lasts_any_number_of_syncs() {
    let mut bus = Bus::new();
    bus.write((0x1801, 1), &0x8000_0285u32.to_le_bytes()).unwrap();
    bus.say(0, &[1, 5]);
    for _ in 0..300 {
        assert_eq!(bus.say(0x80, &[]), []);
    }
    bus.write((0x1801, 1), &0x285u32.to_le_bytes()).unwrap();
    assert_eq!(bus.say(0x80, &[]).len(), 1);
}

#[test]
fn a_node_is_guarded_by_remote_requests_with_a_bit_that_toggles() {
    let mut bus = Bus::new();
    bus.write((0x1017, 0), &[0, 0]).unwrap();
    let remote = CanFrame::of_word(0x705 | wire::can::REMOTE_FLAG, None, 1, &[]).unwrap();
    let mut ask = || {
        bus.device.receive_frame(at_ms(1), &remote);
        bus.sent().remove(0).2
    };
    assert_eq!([ask(), ask(), ask()], [[0x7F], [0xFF], [0x7F]]);
}

#[test]
fn a_reset_of_the_node_begins_anew() {
    let mut bus = Bus::new();
    bus.write((0x607A, 0), &[1, 0, 0, 0]).unwrap();
    bus.say(0, &[129, 5]);
    assert_eq!(bus.until(at_ms(1))[0].1, 0x705);
    assert_eq!(bus.transfer((0x607A, 0), None).unwrap(), [0; 4]);
}

/// The message, and the line that it is about.
fn mistake(toml: &str, eds: &str) -> String {
    let error = described(toml, eds).unwrap_err();
    let text = if error.file() == "drive.toml" { toml } else { eds };
    let line = text[..error.range().start].lines().count().max(1);
    let of = text[error.range()].lines().next().unwrap_or_default();
    format!("{}:{line} `{of}`: {}", error.file(), error.message())
}

#[test]
fn mistakes_have_a_place_in_the_device_file_or_the_eds() {
    let swap = |from: &str, to: &str| {
        assert!(EDS.contains(from) || DRIVE.contains(from), "{from}");
        mistake(&DRIVE.replace(from, to), &EDS.replace(from, to))
    };
    let cut = EDS.find("[6502]").unwrap();
    let mistakes = [
        mistake(DRIVE, &EDS[..cut]),
        mistake(DRIVE, &EDS[..EDS.find("[1018sub3]").unwrap()]),
        mistake(DRIVE, &EDS[..cut + 40]),
        mistake(DRIVE, ""),
        swap("node_id = 5", "node_id = 128"),
        swap("node_id = 5", ""),
        swap("node_id = 5", "node_id = 5\ndbc = \"x.dbc\""),
        swap("node_id = 5", "node_id = 5\n[message.TPDO1]\nperiod_s = 0.25"),
        swap("DefaultValue=0x60640020", "DefaultValue=0x60990020"),
        swap("DefaultValue=0x60640020", "DefaultValue=0x60640010"),
        swap("DefaultValue=0x60410010", "DefaultValue=0x60400110"),
        swap("[object.statusword]", "[object.statuswort]"),
        swap("[state.goal]", "[state.controlword]"),
        swap("code = 0x4310", "code = 0x10"),
        swap("AccessType=const", "AccessType=rx"),
        swap("DefaultValue=30000", "DefaultValue=0x1FFFFFFFF"),
        swap("[6502]", "[6502"),
        swap("DefaultValue=$NODEID+0x280", "DefaultValue=$NODEID+0x180"),
        swap("DefaultValue=$NODEID+0x280", "DefaultValue=$NODEID+0x1280"),
        swap(
            "Transmission type\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\nDefaultValue=1\n",
            "Transmission type\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\nDefaultValue=245\n",
        ),
    ];
    insta::assert_snapshot!(mistakes.join("\n"));
}

/// As in an EDS of Pilz.
#[test]
fn sub_indices_are_those_of_the_file_whatever_their_number_says() {
    let wrong = EDS.replacen("SubNumber=5", "SubNumber=6", 1);
    assert_ne!(wrong, EDS);
    let (right, found) = (described(DRIVE, EDS).unwrap(), described(DRIVE, &wrong).unwrap());
    let objects = |description: &Description| {
        let dictionary = description.layout().dictionary().unwrap();
        dictionary.objects().map(|entry| entry.name().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(objects(&found), objects(&right));
    assert!(right.layout().notes().is_empty());
    let [note] = found.layout().notes() else { panic!("{:?}", found.layout().notes()) };
    assert!(note.to_string().contains("SubNumber says 6, and the file has 5"), "{note}");
    let without = EDS.replacen("SubNumber=5\n", "", 1);
    assert_eq!(described(DRIVE, &without).unwrap().layout().notes().len(), 1);
}

#[test]
fn limits_that_contradict_each_other_are_noted_and_not_used() {
    let wrong = EDS.replacen("LowLimit=1\nHighLimit=3", "LowLimit=4\nHighLimit=3", 1);
    assert_ne!(wrong, EDS);
    let found = described(DRIVE, &wrong).unwrap();
    let [note] = found.layout().notes() else { panic!("{:?}", found.layout().notes()) };
    assert!(note.to_string().contains("its HighLimit 3 is below its LowLimit 4"), "{note}");
}

#[test]
fn a_pdo_without_an_identifier_is_not_used() {
    let without = EDS.replacen("DefaultValue=$NODEID+0x280", "DefaultValue=0", 1);
    assert_ne!(without, EDS);
    let messages = |eds: &str| described(DRIVE, eds).unwrap().layout().messages().len();
    assert_eq!(messages(&without), messages(EDS) - 1);
}

#[test]
fn a_value_may_have_a_comment_behind_it() {
    let commented = EDS.replace("DataType=0x0007", "DataType=0x0007 ; UNSIGNED32");
    assert_ne!(commented, EDS);
    assert!(described(DRIVE, &commented).is_ok());
}

#[test]
fn a_mapping_of_more_than_eight_bytes_is_refused() {
    let eds = EDS.replace("ParameterName=Number of mapped objects\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\nDefaultValue=2", "ParameterName=Number of mapped objects\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\nDefaultValue=3");
    let at = eds.find("[1A01sub3]").unwrap();
    let eds = format!(
        "{}{}",
        &eds[..at],
        eds[at..].replacen("DefaultValue=0x00000000", "DefaultValue=0x60410010", 1)
    );
    let eds = eds.replacen("[1601sub3]\nParameterName=Mapped object 3\nObjectType=0x7\nDataType=0x0007\nAccessType=rw\nDefaultValue=0x00000000", "[1601sub3]\nParameterName=Mapped object 3\nObjectType=0x7\nDataType=0x0007\nAccessType=rw\nDefaultValue=0x60400010", 1);
    let text = mistake(DRIVE, &eds);
    assert!(text.contains("would exceed PDO length"), "{text}");
}

#[test]
fn a_dcf_says_the_node_and_the_values() {
    let dcf = EDS.replace("DefaultValue=30000", "DefaultValue=30000\nParameterValue=20000");
    let dcf = format!("{dcf}\n[DeviceComissioning]\nNodeID=0x11\n");
    let description = described(&DRIVE.replace("node_id = 5", ""), &dcf).unwrap();
    let device = Device::new(Arc::new(description), 1);
    assert_eq!(device.value("profile_velocity"), Some(20.0));
    let layout = device.description().layout();
    let place = layout.find("TPDO1").unwrap();
    assert_eq!(layout.messages()[place].can_id(), StandardId::new(0x191).map(Id::Standard));
}

/// Frames that mean something to the device, more often than not.
fn any_frame() -> impl Strategy<Value = CanFrame> {
    let ids = vec![0u16, 0x80, 0x205, 0x305, 0x405, 0x605, 0x605, 0x605, 0x701, 0x705];
    let words = (
        any::<u8>(),
        prop::sample::select(vec![
            0x1003u16, 0x1016, 0x1017, 0x1400, 0x1600, 0x1800, 0x1A00, 0x1A01, 0x2000, 0x6064,
        ]),
        0u8..6,
        any::<[u8; 4]>(),
    );
    let words = words.prop_map(|(command, index, sub, data)| {
        super::sdo::words(command, (index, sub), data).to_vec()
    });
    let data = prop_oneof![words, prop::collection::vec(any::<u8>(), 0..=8)];
    (prop::sample::select(ids), data).prop_map(|(id, data)| frame(id, &data))
}

proptest! {
    #[test]
    fn whatever_comes_it_goes_on(frames in prop::collection::vec((any_frame(), 0i64..30), 0..60)) {
        let mut bus = Bus::new();
        bus.say(0, &[1, 0]);
        for (frame, later) in frames {
            bus.until(bus.now + Span::from_millis(later));
            bus.device.receive_frame(bus.now, &frame);
            prop_assert!(bus.sent().len() <= 8);
        }
        bus.say(0, &[129, 0]);
        bus.until(bus.now);
        prop_assert_eq!(bus.transfer((0x1008, 0), None).unwrap(), b"Rotary table");
    }

    #[test]
    fn a_file_that_is_cut_or_changed_is_read_or_refused(
        cut in 0usize..EDS.len(), at in 0usize..EDS.len(), byte in 32u8..127,
    ) {
        let _ = described(DRIVE, &EDS[..cut]);
        let mut bytes = EDS.as_bytes().to_vec();
        bytes[at] = byte;
        if let Ok(description) = described(DRIVE, &String::from_utf8(bytes).unwrap()) {
            let mut device = Device::new(Arc::new(description), 1);
            device.wake(at_ms(10));
            prop_assert!(device.transmit().is_some());
        }
    }
}
