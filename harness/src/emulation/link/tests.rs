use super::{Link, LinkFault, Output, Pace, READY_MAX};
use wire::can::{CanFrame, StandardId};
use wire::packet::Packet;
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

const START: Timestamp = Timestamp::ZERO;

fn link(pace: Pace) -> Link {
    Link::new(pace, 1, "gyro")
}

fn bytes(text: &[u8]) -> Output {
    Output::Bytes(Packet::from_slice(text).unwrap())
}

fn frame(id: u16, data: u8) -> Output {
    Output::Frame(CanFrame::new(StandardId::new(id).unwrap(), &[data]).unwrap())
}

fn sent(link: &mut Link, output: Output) -> Option<Output> {
    link.send(START, output);
    link.transmit()
}

#[test]
fn a_pty_gets_the_pace_of_a_line_in_both_directions() {
    let mut link = link(Pace::Line(SerialSettings::new_8n1(9_600)));
    let through = START + Span::from_micros(12_500);
    link.send(START, bytes(&[0; 12]));
    assert_eq!(link.receive(START, Packet::from_slice(&[1; 12]).unwrap()), None);
    assert_eq!(link.next_wakeup(), through);
    link.wake(through - Span::from_nanos(1));
    assert_eq!((link.transmit(), link.arrived(through - Span::from_nanos(1))), (None, None));
    link.wake(through);
    assert_eq!(link.transmit(), Some(bytes(&[0; 12])));
    assert_eq!(link.arrived(through), Packet::from_slice(&[1; 12]));
}

#[test]
fn a_fault_ends_at_its_time() {
    let mut link = link(Pace::Medium);
    link.set_fault(LinkFault::Silent, START + Span::from_secs(1));
    assert_eq!(sent(&mut link, bytes(b"a")), None);
    link.send(START + Span::from_secs(1), bytes(b"b"));
    assert_eq!(link.transmit(), Some(bytes(b"b")));
    assert_eq!(link.counters().silenced, 1);
}

#[test]
fn a_stuck_link_repeats_the_last_of_each_kind() {
    let mut link = link(Pace::Medium);
    for output in [bytes(b"a"), frame(1, 1), frame(2, 2), frame(1, 3)] {
        assert_eq!(sent(&mut link, output), Some(output));
    }
    link.set_fault(LinkFault::Stuck, Timestamp::MAX);
    assert_eq!(sent(&mut link, bytes(b"b")), Some(bytes(b"a")));
    assert_eq!(sent(&mut link, frame(1, 9)), Some(frame(1, 3)));
    assert_eq!(sent(&mut link, frame(2, 9)), Some(frame(2, 2)));
    assert_eq!(sent(&mut link, frame(3, 9)), None);
    link.clear_fault();
    assert_eq!(sent(&mut link, bytes(b"c")), Some(bytes(b"c")));
}

#[test]
fn bytes_are_lost_in_their_share() {
    const OUTPUTS: u64 = 1_000;
    let mut link = link(Pace::Medium);
    link.set_fault(LinkFault::Drop { share: 0.25 }, Timestamp::MAX);
    let mut kept = 0;
    for _ in 0..OUTPUTS {
        if let Some(Output::Bytes(rest)) = sent(&mut link, bytes(b"12345678")) {
            kept += rest.len() as u64;
        }
    }
    let lost = link.counters().lost;
    assert_eq!(kept + lost, 8 * OUTPUTS);
    // Six standard deviations of a binomial count about its mean.
    assert!(lost.abs_diff(2 * OUTPUTS) < 240, "{lost}");
    link.set_fault(LinkFault::Drop { share: 1.0 }, Timestamp::MAX);
    assert_eq!(sent(&mut link, frame(1, 1)), None);
}

#[test]
fn what_comes_later_keeps_its_order() {
    let mut link = link(Pace::Medium);
    let (late, later) = (START + Span::from_millis(200), START + Span::from_millis(300));
    link.set_fault(LinkFault::Delay { by: Span::from_millis(200) }, START + Span::from_millis(100));
    link.send(START, bytes(b"a"));
    link.send(START + Span::from_millis(50), bytes(b"b"));
    // The fault is over, and what was sent under it is still on its way.
    link.send(START + Span::from_millis(150), bytes(b"c"));
    assert_eq!((link.transmit(), link.next_wakeup()), (None, late));
    link.wake(late);
    assert_eq!((link.transmit(), link.transmit()), (Some(bytes(b"a")), None));
    link.wake(later);
    assert_eq!((link.transmit(), link.transmit()), (Some(bytes(b"b")), Some(bytes(b"c"))));
    link.send(later, bytes(b"d"));
    assert_eq!((link.transmit(), link.counters().delayed), (Some(bytes(b"d")), 3));
}

#[test]
fn what_nobody_fetches_is_counted() {
    let mut link = link(Pace::Medium);
    for _ in 0..READY_MAX + 2 {
        link.send(START, bytes(b"a"));
    }
    assert_eq!(link.counters().overflowed, 2);
}
