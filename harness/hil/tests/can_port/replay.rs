//! Replay of a log to an interface of the kernel.

use crate::link::Link;
use crate::{frame, heard, opened, run};
use bus_log::playable::Playable;
use bus_log::{Channel, Entry, LogError, Payload};
use hil::replay::{Ending, Setup, play};
use ports::{PortLost, PortSpec};
use std::future::pending;
use wire::time::Timestamp;

const FRAMES: u32 = 1_000;

/// Frames 1 ms apart.
fn log(count: u32) -> Playable<impl Iterator<Item = Result<Entry, LogError>>> {
    let entries = (0..count).map(|number| {
        Ok(Entry {
            at: Timestamp::from_nanos(i64::from(number) * 1_000_000),
            channel: Channel::CAN0,
            direction: None,
            payload: Payload::Frame(frame(number)),
        })
    });
    Playable::new(entries, None, false)
}

fn setup(interface: &str, speed: f64) -> Setup {
    Setup { port: PortSpec::Can { interface: interface.to_owned() }, speed }
}

#[test]
fn a_log_reaches_who_listens_whole_and_in_order() {
    run(async {
        let Some(link) = Link::make("hilreplay").await else { return };
        let (mut here, mut there) = (opened(link.0).await, opened(link.0).await);
        let setup = setup(link.0, 4.0);
        let listen = async {
            for number in 0..FRAMES {
                assert_eq!(heard(&mut there).await, frame(number));
            }
        };
        let (replayed, ()) = tokio::join!(play(log(FRAMES), &mut here, &setup, pending()), listen);
        eprint!("{replayed}");
        assert!(matches!(replayed.ending, Ending::Complete), "{replayed}");
        assert_eq!((replayed.sent(), replayed.lost()), (u64::from(FRAMES), 0), "{replayed}");
        assert!(replayed.took.as_secs_f64() >= 0.2497, "{replayed}");
        assert!(there.counters().all_crossed(), "{:?}", there.counters());
    });
}

#[test]
fn an_interface_that_is_deleted_ends_it() {
    run(async {
        let Some(link) = Link::make("hilvanishes").await else { return };
        let (mut here, mut there) = (opened(link.0).await, opened(link.0).await);
        // At this speed no log ends before the interface is gone.
        let setup = setup(link.0, 1e-3);
        let vanish = async {
            assert_eq!(heard(&mut there).await, frame(0));
            link.delete().await.unwrap();
        };
        let (replayed, ()) = tokio::join!(play(log(FRAMES), &mut here, &setup, pending()), vanish);
        assert!(matches!(replayed.ending, Ending::PortLost(PortLost::Deleted)), "{replayed}");
        assert!((1..u64::from(FRAMES)).contains(&replayed.sent()), "{replayed}");
    });
}
