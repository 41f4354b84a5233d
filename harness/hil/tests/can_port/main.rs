//! Ports for CAN frames on a kernel with CAN: an interface that appears and disappears, a bus with errors, and the
//! kernel as the user of an emulated adapter.
//!
//! Needs permission to create interfaces; `tests/vcan-guest/run` provides a kernel with it.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "in a test what cannot go on may panic")]

mod gone;
mod link;
mod recorder;
mod replay;
mod slcan;
mod socket;

use ports::{FrameEvent, FramePort, PortSpec};
use std::future::Future;
use std::time::Duration;
use wire::can::BitRates;
use wire::can::{CanFrame, ExtendedId};
use wire::time::Timestamp;

const NOW: Timestamp = Timestamp::ZERO;
/// Time limit for an event. The machine may be busy with other work.
const LIMIT: Duration = Duration::from_secs(60);
/// Time limit for a whole test: it only ends one that hangs.
const WHOLE: Duration = Duration::from_secs(300);

fn run<T>(test: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async { tokio::time::timeout(WHOLE, test).await.expect("the test ends") })
}

async fn opened(interface: &str) -> FramePort {
    let spec = PortSpec::Can { interface: interface.to_owned() };
    FramePort::open(&spec, BitRates::USUAL).await.unwrap()
}

fn frame(number: u32) -> CanFrame {
    CanFrame::new(ExtendedId::new(number).unwrap(), &number.to_be_bytes()).unwrap()
}

/// Receives the next event, which must be a frame.
async fn heard(port: &mut FramePort) -> CanFrame {
    match tokio::time::timeout(LIMIT, port.receive()).await {
        Ok(Ok(FrameEvent::Frame(frame))) => frame,
        Ok(other) => panic!("{other:?}"),
        Err(_) => panic!("nothing arrives any more: {:?}", port.counters()),
    }
}
