//! Logs played to an adapter on a pty, and to one that disappears.

use super::{Ending, Replayed, Setup, play};
use bus_log::playable::Playable;
use bus_log::{Channel, Entry, LogError, Payload};
use ports::{FrameEvent, FramePort, PortLost, PortSpec};
use skips::in_time;
use std::future::{Future, pending, ready};
use std::time::Duration;
use wire::can::BitRates;
use wire::can::{CanFrame, ExtendedId};
use wire::time::Timestamp;

const FRAMES: u32 = 500;

fn run<T>(test: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        tokio::time::timeout(Duration::from_secs(60), test).await.expect("the test ends")
    })
}

fn frame(number: u32) -> CanFrame {
    CanFrame::new(ExtendedId::new(number).unwrap(), &number.to_be_bytes()).unwrap()
}

/// Frames 0.5 ms apart.
fn log(count: u32) -> Playable<impl Iterator<Item = Result<Entry, LogError>>> {
    let entries = (0..count).map(|number| {
        Ok(Entry {
            at: Timestamp::from_nanos(1_436_509_052_000_000_000 + i64::from(number) * 500_000),
            channel: Channel::CAN0,
            direction: None,
            payload: Payload::Frame(frame(number)),
        })
    });
    Playable::new(entries, None, false)
}

fn setup(port: &str) -> Setup {
    Setup { port: port.parse().unwrap(), speed: 1.0 }
}

async fn opened(spec: &PortSpec) -> FramePort {
    FramePort::open(spec, BitRates::USUAL).await.unwrap()
}

/// The user of the adapter.
async fn user(adapter: &str) -> FramePort {
    opened(&format!("slcan:{adapter}").parse().unwrap()).await
}

#[test]
fn every_frame_arrives_in_order_and_none_early() {
    in_time(|| {
        run(async {
            let setup = setup("slcan-pty");
            let mut port = opened(&setup.port).await;
            let far = port.far_path().unwrap().to_owned();
            let listen = async {
                let mut user = user(&far).await;
                for number in 0..FRAMES {
                    assert_eq!(user.receive().await, Ok(FrameEvent::Frame(frame(number))));
                }
                // Dropping it closes the bus: the replay need not wait for it.
            };
            let (replayed, ()) =
                tokio::join!(play(log(FRAMES), &mut port, &setup, pending()), listen);
            assert!(matches!(replayed.ending, Ending::Complete), "{replayed}");
            assert_eq!((replayed.sent(), replayed.lost()), (u64::from(FRAMES), 0), "{replayed}");
            assert_eq!(replayed.channel.as_deref(), Some("can0"));
            // The last frame is due 0.5 ms before 250 ms after the first.
            assert!(replayed.took.as_secs_f64() >= 0.2495, "{replayed}");
            assert!(replayed.late.max_us >= replayed.late.p50_us, "{replayed}");
        });
    });
}

#[test]
fn a_port_that_vanishes_ends_it_with_what_was_sent() {
    // 20 s: a busy machine may come late to see that it has vanished.
    const LONG: u32 = 40_000;
    run(async {
        let mut adapter = opened(&"slcan-pty".parse().unwrap()).await;
        let setup = setup(&format!("slcan:{}", adapter.far_path().unwrap()));
        let played = async {
            let mut port = opened(&setup.port).await;
            play(log(LONG), &mut port, &setup, pending()).await
        };
        let vanish = async {
            let mut heard = 0;
            while heard < 10 {
                heard += u32::from(matches!(adapter.receive().await, Ok(FrameEvent::Frame(_))));
            }
            drop(adapter);
        };
        let (replayed, ()): (Replayed, ()) = tokio::join!(played, vanish);
        assert!(matches!(replayed.ending, Ending::PortLost(PortLost::HungUp)), "{replayed}");
        assert!((10..u64::from(LONG)).contains(&replayed.sent()), "{replayed}");
    });
}

#[test]
fn it_stops_when_told_to_with_nobody_there() {
    run(async {
        let setup = setup("slcan-pty");
        let mut port = opened(&setup.port).await;
        let replayed = play(log(FRAMES), &mut port, &setup, ready(())).await;
        assert!(matches!(replayed.ending, Ending::Stopped), "{replayed}");
        assert_eq!((replayed.sent(), replayed.channel), (0, None));
    });
}
