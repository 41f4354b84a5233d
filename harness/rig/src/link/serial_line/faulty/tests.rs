//! Effect of each fault of a serial line on bytes and their times.

use super::{BYTES_MAX, Chance, FaultKind, Packet, SerialLine, Span, Timestamp};
use wire::serial::SerialSettings;

/// Sends `count` packets of these bytes, one per second, through one fault; returns what arrives and the fault's count.
fn through(kind: FaultKind, sent: &[u8], count: i64) -> (Vec<(Timestamp, Vec<u8>)>, u64) {
    let mut line = SerialLine::new(SerialSettings::new_8n1(9_600));
    assert!(line.begin_fault(Timestamp::ZERO, 3, &kind, Chance::new(7, "3")));
    let mut heard = Vec::new();
    for second in 0..count {
        line.send(Timestamp::ZERO + Span::from_secs(second), Packet::from_slice(sent).unwrap());
        while line.next_arrival() < Timestamp::MAX {
            let at = line.next_arrival();
            heard.push((at, line.arrived(at).unwrap().as_slice().to_vec()));
        }
    }
    let acted = line.end_fault(3);
    assert!(line.faulty.is_none(), "a line without faults carries no layer");
    (heard, acted)
}

fn bytes(heard: &[(Timestamp, Vec<u8>)]) -> usize {
    heard.iter().map(|(_, bytes)| bytes.len()).sum()
}

#[test]
fn losses_have_their_share_and_are_counted() {
    for (kind, expected) in [
        (FaultKind::Drop { loss_percent: 10.0 }, 1_000.0),
        (
            FaultKind::BurstLoss {
                loss_percent: 5.0,
                recover_percent: 45.0,
                bad_percent: 100.0,
                good_percent: 0.0,
            },
            1_000.0,
        ),
        (FaultKind::Disconnect { for_s: 1.0 }, 10_000.0),
    ] {
        let (heard, acted) = through(kind, &[0x5a; 10], 1_000);
        assert_eq!(bytes(&heard) as u64 + acted, 10_000);
        // Standard deviation of a binomial count: 30; for bursts somewhat more.
        assert!((acted as f64 - expected).abs() < 200.0, "{} {acted}", kind.name());
    }
}

#[test]
fn what_is_added_and_changed_is_counted() {
    let (heard, acted) =
        through(FaultKind::Duplicate { duplicate_percent: 10.0 }, &[1, 2, 3], 1_000);
    assert_eq!(bytes(&heard) as u64, 3_000 + acted);
    assert!((200..400).contains(&acted) && heard.iter().any(|(_, bytes)| bytes[..2] == [1, 1]));
    let (heard, acted) = through(FaultKind::Insert { insert_percent: 10.0 }, &[1, 2, 3], 1_000);
    assert_eq!(bytes(&heard) as u64, 3_000 + acted);
    assert!(heard.iter().all(|(_, bytes)| bytes.ends_with(&[3])));
    let (heard, acted) = through(FaultKind::Flip { flip_percent: 10.0 }, &[0; 3], 1_000);
    let ones: u32 = heard.iter().flat_map(|(_, bytes)| bytes).map(|byte| byte.count_ones()).sum();
    assert_eq!((bytes(&heard), u64::from(ones)), (3_000, acted));
    assert!((200..400).contains(&acted));
}

#[test]
fn a_packet_that_is_repeated_comes_whole_behind_itself() {
    let (heard, acted) = through(FaultKind::Repeat { repeat_percent: 30.0 }, b"123", 1_000);
    let twice = heard.iter().filter(|(_, bytes)| bytes == b"123123").count();
    assert_eq!((heard.len(), twice as u64), (1_000, acted));
    assert!((200..400).contains(&acted));
}

#[test]
fn a_packet_that_is_split_arrives_in_two_parts_and_its_second_one_late() {
    let (heard, acted) =
        through(FaultKind::Split { split_percent: 30.0, late_s: 0.1 }, b"123456", 1_000);
    assert!((200..400).contains(&acted));
    assert_eq!((heard.len() as u64, bytes(&heard)), (1_000 + acted, 6_000));
    let byte = 10.0 / 9_600.0;
    for split in heard.chunk_by(|(_, before), _| before != b"123456" && !before.ends_with(b"6")) {
        let sent = split[0].0.as_secs_f64().floor();
        let whole: Vec<u8> = split.iter().flat_map(|(_, bytes)| bytes.clone()).collect();
        assert_eq!(whole, b"123456");
        let first = sent + split[0].1.len() as f64 * byte;
        assert!((split[0].0.as_secs_f64() - first).abs() < 1e-8);
        if let [_, (second, _)] = split {
            assert!((second.as_secs_f64() - (sent + 6.0 * byte + 0.1)).abs() < 1e-8);
        }
    }
}

#[test]
fn what_is_sent_behind_a_late_part_arrives_behind_it() {
    let mut line = SerialLine::new(SerialSettings::new_8n1(9_600));
    let split = FaultKind::Split { split_percent: 100.0, late_s: 0.5 };
    line.begin_fault(Timestamp::ZERO, 0, &split, Chance::new(1, "0"));
    line.send(Timestamp::ZERO, Packet::from_slice(b"1234").unwrap());
    assert_eq!(line.end_fault(0), 1);
    line.send(Timestamp::ZERO, Packet::from_slice(b"5").unwrap());
    let heard: Vec<u8> = std::iter::from_fn(|| line.arrived(Timestamp::from_secs_f64(1.0)))
        .flat_map(|packet| packet.as_slice().to_vec())
        .collect();
    assert_eq!(heard, b"12345");
}

#[test]
fn a_full_packet_that_doubles_becomes_two() {
    let (heard, _) = through(FaultKind::Duplicate { duplicate_percent: 100.0 }, &[9; BYTES_MAX], 1);
    assert_eq!(
        heard.iter().map(|(_, bytes)| bytes.len()).collect::<Vec<_>>(),
        [BYTES_MAX, BYTES_MAX]
    );
}

#[test]
fn drift_and_slip_make_other_bytes() {
    let (heard, acted) = through(FaultKind::BaudDrift { drift_percent: 8.0 }, b"123456", 3);
    assert_eq!(acted, 3);
    assert!(heard.iter().all(|(_, bytes)| bytes != b"123456"));
    let (_, acted) = through(FaultKind::BaudDrift { drift_percent: -2.0 }, b"123456", 3);
    assert_eq!(acted, 0, "two per cent are within what a UART takes");
    let (heard, acted) = through(FaultKind::FramingSlip { slip_percent: 50.0 }, b"123456", 100);
    assert!((30..70).contains(&acted) && heard.iter().any(|(_, bytes)| bytes == b"123456"));
}

#[test]
fn a_fast_sender_takes_less_time() {
    let (heard, _) = through(FaultKind::BaudDrift { drift_percent: 4.0 }, b"123456", 1);
    let expected = 6.0 * 10.0 / 9_600.0 / 1.04;
    assert!((heard[0].0.as_secs_f64() - expected).abs() < 1e-8);
}

#[test]
fn a_stall_holds_all_back_and_lets_all_go_at_once() {
    let mut line = SerialLine::new(SerialSettings::new_8n1(9_600));
    let packet = Packet::from_slice(b"abc").unwrap();
    line.send(Timestamp::ZERO, packet);
    line.begin_fault(Timestamp::ZERO, 0, &FaultKind::Stall { for_s: 2.0 }, Chance::new(1, "0"));
    line.send(Timestamp::from_secs_f64(0.5), packet);
    line.send(Timestamp::from_secs_f64(1.0), packet);
    let end = Timestamp::from_secs_f64(2.0);
    assert_eq!(line.next_arrival(), end);
    assert_eq!(std::iter::from_fn(|| line.arrived(end)).count(), 3);
    assert_eq!(line.end_fault(0), 3);
}

#[test]
fn kinds_of_other_reach_are_no_layer() {
    let mut line = SerialLine::new(SerialSettings::new_8n1(9_600));
    let kind = FaultKind::typical("babble").unwrap();
    assert!(!line.begin_fault(Timestamp::ZERO, 0, &kind, Chance::new(1, "0")));
}
