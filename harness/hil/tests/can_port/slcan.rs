//! The kernel's own line discipline `slcan` as the user of an emulated adapter.

use crate::link::{Link, ip};
use crate::{NOW, frame, heard, opened, run};
use ports::{FrameEvent, FramePort, PortSpec};
use std::process::Stdio;
use std::time::Duration;
use tokio::process::{Child, Command};
use wire::can::BitRates;

/// The interface that the kernel creates on the pty.
const INTERFACE: &str = "hilslcan";

/// `slcand` in the foreground: opens the adapter at 500 kbit/s and hands the pty to the kernel.
fn slcand(pty: &str) -> Child {
    Command::new("slcand")
        .args(["-F", "-o", "-s6", pty, INTERFACE])
        .stdout(Stdio::null())
        .kill_on_drop(true)
        .spawn()
        .unwrap()
}

/// Sets the interface up, once it exists.
async fn take_up() {
    while !std::path::Path::new("/sys/class/net").join(INTERFACE).exists() {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    ip(&["link", "set", INTERFACE, "up"]).await.unwrap();
}

#[test]
fn the_kernel_uses_the_adapter() {
    run(async {
        // Skips if there is no CAN, or if interfaces cannot be created.
        let Some(_link) = Link::make("hilprobe").await else { return };
        let spec: PortSpec = "slcan-pty".parse().unwrap();
        let mut adapter = FramePort::open(&spec, BitRates::USUAL).await.unwrap();
        let _slcand = slcand(adapter.far_path().unwrap());
        let (up, ()) = tokio::join!(adapter.receive(), take_up());
        assert_eq!(up, Ok(FrameEvent::Up));
        let mut kernel = opened(INTERFACE).await;

        for number in 0..20 {
            adapter.send(NOW, &frame(number));
            assert_eq!(heard(&mut kernel).await, frame(number));
            kernel.send(NOW, &frame(number + 100));
            assert_eq!(heard(&mut adapter).await, frame(number + 100));
        }
    });
}
