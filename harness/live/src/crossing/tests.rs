//! Lines through the kernel: their output, and their failures.

use super::pty_wire::PtyWire;
use super::{Kernel, KernelError};
use ports::pty::Ends;
use rig::crossing::{CrossedLine, Crossing as _, How, KernelBus, Toward};
use socketcan::EmbeddedFrame as _;
use std::os::fd::OwnedFd;
use std::time::Duration;
use wire::can::{CanFrame, ExtendedId, StandardId};
use wire::device::Transmit;
use wire::packet::Packet;
use wire::time::Timestamp;

/// Time limit in tests for something that never comes.
const SOON: Duration = Duration::from_millis(50);
const NOW: Timestamp = Timestamp::ZERO;

fn packet(bytes: &[u8]) -> Packet {
    Packet::from_slice(bytes).unwrap()
}

/// A line whose device is at its first end.
fn line(name: &str, is_can: bool) -> CrossedLine {
    CrossedLine { name: name.into(), is_can, is_fd: false, device_end: 0 }
}

/// A gyro and a base.
fn robot(is_can: bool) -> [CrossedLine; 2] {
    [line("gyro", false), line("base", is_can)]
}

/// A gyro on a table, with the device ends as in a run.
fn on_table() -> [CrossedLine; 2] {
    [line("gyro", false), CrossedLine { device_end: 1, ..line("table", false) }]
}

/// A line whose two ends are not connected, and the ends that they are connected to; if those were closed, the line
/// would hang up.
fn stuck(line: &str) -> (PtyWire, [OwnedFd; 2]) {
    let (one, other) = (Ends::open().unwrap(), Ends::open().unwrap());
    let ends = Ends { master: one.master, slave: other.slave, path: one.path };
    (PtyWire::of(line.into(), ends, SOON), [one.slave, other.master])
}

#[test]
fn every_byte_crosses_both_ways() {
    let mut kernel = Kernel::open(KernelBus::Pty, &robot(false)).unwrap();
    let all: Vec<u8> = (0..=255).collect();
    for line in [0, 1] {
        for from in [0, 1] {
            for part in all.chunks(63) {
                let mut carried = Transmit::Bytes(packet(part));
                assert!(kernel.carry(NOW, line, from, &mut carried), "{:?}", kernel.failure());
                assert_eq!(carried, Transmit::Bytes(packet(part)));
            }
        }
    }
    let mut nothing = Transmit::Bytes(Packet::new());
    assert!(kernel.carry(NOW, 0, 0, &mut nothing), "nothing is something");
    assert!(kernel.failure().is_none());
}

#[test]
fn frames_cross_as_lines() {
    let mut kernel = Kernel::open(KernelBus::Slcan, &robot(true)).unwrap();
    assert_eq!(kernel.bus(), "slcan");
    let frames = [
        CanFrame::new(StandardId::new(0x123).unwrap(), b"12345678").unwrap(),
        CanFrame::new(ExtendedId::new(0x1fff_ffff).unwrap(), b"").unwrap(),
        CanFrame::new_remote(StandardId::MAX, 4).unwrap(),
    ];
    for frame in frames {
        for from in [0, 1] {
            let mut carried = Transmit::Frame(frame);
            assert!(kernel.carry(NOW, 1, from, &mut carried), "{:?}", kernel.failure());
            assert_eq!(carried, Transmit::Frame(frame));
        }
    }
}

#[test]
fn lines_of_an_adapter_carry_no_can_fd() {
    let fd = CrossedLine { is_fd: true, ..line("can0", true) };
    let refused = Kernel::open(KernelBus::Slcan, &[fd]);
    assert!(matches!(refused, Err(KernelError::NoFd { .. })), "{refused:?}");
}

#[test]
fn a_bench_has_the_lines_that_it_needs() {
    let serial = Kernel::open(KernelBus::Vcan, &robot(false)).unwrap();
    assert_eq!(serial.bus(), "pty", "no frame crosses anything");
    let refused = Kernel::open(KernelBus::Pty, &robot(true));
    assert!(matches!(refused, Err(KernelError::NoFrames { .. })));
}

#[test]
fn what_is_lost_or_changed_is_named_and_the_line_is_dead() {
    let (lost, _far) = stuck("gyro");
    let mut sent = packet(b"speed");
    let failure = lost.carry(Toward::Device, &mut sent).unwrap_err();
    assert!(matches!(failure.how(), How::Late { .. }), "{failure}");

    let Ends { master, slave, path } = Ends::open().unwrap();
    rustix::io::write(&master, b"stray").unwrap();
    let changed = PtyWire::of("gyro".into(), Ends { master, slave, path: path.clone() }, SOON);
    let mut kernel = Kernel::open(KernelBus::Pty, &on_table()).unwrap().with_wire("gyro", changed);
    let mut speed = Transmit::Bytes(packet(b"speed"));
    assert!(!kernel.carry(NOW, 0, 0, &mut speed));
    let failure = kernel.failure().unwrap();
    assert!(matches!(failure.how(), How::Changed { .. }), "{failure}");
    let text = failure.to_string();
    assert!(text.starts_with(&format!("failed to carry bytes from the gyro across {path}: ")));
    assert!(text.contains("\"speed\" went in and \"stray"), "{text}");
    let mut more = Transmit::Bytes(packet(b"more"));
    assert!(!kernel.carry(NOW, 0, 0, &mut more));
    assert!(kernel.failure().is_none(), "it is told once");
}

#[test]
fn a_port_that_hangs_up_is_named() {
    let Ends { master, path, .. } = Ends::open().unwrap();
    let other = Ends::open().unwrap();
    // The slave of this master is closed; another takes its place.
    let wire = PtyWire::of("table".into(), Ends { master, slave: other.slave, path }, SOON);
    let failure = wire.carry(Toward::Device, &mut packet(b"x")).unwrap_err();
    assert!(matches!(failure.how(), How::Read(_)), "{failure}");
}
