//! Excess: too many, too late or too often.

use super::{at, command, oven, run, showing};
use crate::device::answers::ANSWERS_MAX;
use crate::device::{Device, QUEUE_MAX};
use proptest::prelude::*;
use std::sync::Arc;
use wire::can::CanFrame;
use wire::time::{Span, Timestamp};

#[test]
fn what_nobody_takes_is_dropped_and_counted() {
    let description = oven();
    let frame = command(description.layout(), 100.0, 1.0);
    let mut device = Device::new(Arc::clone(&description), 1);
    for _ in 0..ANSWERS_MAX + 3 {
        device.receive_frame(at(0.0), &frame);
    }
    assert_eq!(device.dropped(), 3);
    for count in 1..=100 {
        device.wake(at(0.1 * f64::from(count)));
    }
    let mut waiting = 0;
    while device.transmit().is_some() {
        waiting += 1;
    }
    assert_eq!(waiting, QUEUE_MAX);
    assert_eq!(device.dropped(), (3 + 100 + ANSWERS_MAX - QUEUE_MAX) as u64);
}

#[test]
fn woken_late_it_sends_once_and_keeps_its_grid() {
    let mut device = Device::new(oven(), 1);
    device.wake(at(1.05));
    assert!(device.transmit().is_some() && device.transmit().is_none());
    assert_eq!(device.next_wakeup(), at(1.1));
    // A wake-up before its time, or in the past, does nothing.
    device.wake(at(1.06));
    device.wake(at(0.5));
    assert_eq!(device.transmit(), None);
}

#[test]
fn the_end_of_all_time_is_reached() {
    let mut device = Device::new(showing("step_s = 1e6\n[state.a]\nrate = 1\n"), 1);
    device.wake(Timestamp::MAX);
    assert!(device.transmit().is_some());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// A wake-up is not an event: only receiving and sending are.
    #[test]
    fn what_it_sends_does_not_depend_on_how_often_it_is_woken(
        wakes in prop::collection::vec(0i64..5_000_000_000, 0..40), told in 0i64..4_000_000_000
    ) {
        let description = oven();
        let frame = command(description.layout(), 80.0, 1.0);
        let told = Timestamp::from_nanos(told);
        let mut plain = Device::new(Arc::clone(&description), 5);
        let mut woken = Device::new(Arc::clone(&description), 5);
        let seconds = |at: Timestamp| at.as_secs_f64();
        let mut expected = run(&mut plain, seconds(told));
        plain.receive_frame(told, &frame);
        expected.extend(run(&mut plain, 5.0));

        let mut wakes = wakes;
        wakes.sort_unstable();
        let mut found = Vec::new();
        let (before, behind): (Vec<i64>, Vec<i64>) =
            wakes.into_iter().partition(|nanos| *nanos < told.as_nanos());
        for nanos in before {
            found.extend(run(&mut woken, seconds(Timestamp::from_nanos(nanos))));
        }
        found.extend(run(&mut woken, seconds(told)));
        woken.receive_frame(told, &frame);
        for nanos in behind {
            found.extend(run(&mut woken, seconds(Timestamp::from_nanos(nanos))));
        }
        found.extend(run(&mut woken, 5.0));
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn nothing_that_it_receives_makes_it_panic(
        frames in prop::collection::vec((0u16..0x7ff, prop::collection::vec(any::<u8>(), 0..=8)), 0..20),
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        times in prop::collection::vec(any::<i64>(), 1..5)
    ) {
        let mut device = Device::new(showing("[signal.x]\nexpression = \"u / (u - 7)\"\n"), 1);
        for time in times {
            let now = Timestamp::from_nanos(time);
            for (id, data) in &frames {
                let id = wire::can::StandardId::new(*id).unwrap();
                device.receive_frame(now, &CanFrame::new(id, data).unwrap());
            }
            device.receive_bytes(now, &bytes);
            device.wake(now);
            device.power(now + Span::from_secs(1), time % 2 == 0);
        }
    }
}
