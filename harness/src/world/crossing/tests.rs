//! Lines across the kernel: what comes out, and what is said when it does not.

use super::{Crossing as _, How, Kernel, KernelBus, KernelError, Line, Toward, pty_wire::PtyWire};
use crate::made::Made;
use crate::operator::Answers;
use crate::outcome::Outcome;
use crate::port::pty::Ends;
use crate::record::sink::NullSink;
use crate::run::{Prepared, Simulated, simulate_across};
use controller::config::Transport;
use socketcan::EmbeddedFrame as _;
use std::os::fd::OwnedFd;
use std::time::Duration;
use wire::can::{CanFrame, ExtendedId, StandardId};
use wire::packet::Packet;
use wire::time::Timestamp;

/// What never comes is not waited for longer than this in a test.
const SOON: Duration = Duration::from_millis(50);
const NOW: Timestamp = Timestamp::ZERO;

fn packet(bytes: &[u8]) -> Packet {
    Packet::from_slice(bytes).unwrap()
}

/// A line whose two ends are not joined, and the ends that they are joined to: with those closed it would
/// hang up.
fn stuck(line: Line) -> (PtyWire, [OwnedFd; 2]) {
    let (one, other) = (Ends::open().unwrap(), Ends::open().unwrap());
    let ends = Ends { master: one.master, slave: other.slave, path: one.path };
    (PtyWire::of(line, ends, SOON), [one.slave, other.master])
}

#[test]
fn every_byte_crosses_both_ways() {
    let mut kernel = Kernel::open(KernelBus::Pty, Some(Transport::Serial)).unwrap();
    let all: Vec<u8> = (0..=255).collect();
    for line in [Line::Gyro, Line::Base] {
        for toward in [Toward::Device, Toward::Host] {
            for part in all.chunks(63) {
                let mut carried = packet(part);
                assert!(kernel.bytes(line, toward, &mut carried), "{:?}", kernel.failure());
                assert_eq!(carried, packet(part));
            }
        }
    }
    assert!(kernel.bytes(Line::Gyro, Toward::Host, &mut Packet::new()), "nothing is something");
    assert!(kernel.failure().is_none());
}

#[test]
fn frames_cross_as_lines() {
    let mut kernel = Kernel::open(KernelBus::Slcan, Some(Transport::Can)).unwrap();
    assert_eq!(kernel.bus(), "slcan");
    let frames = [
        CanFrame::new(StandardId::new(0x123).unwrap(), b"12345678").unwrap(),
        CanFrame::new(ExtendedId::new(0x1fff_ffff).unwrap(), b"").unwrap(),
        CanFrame::new_remote(StandardId::MAX, 4).unwrap(),
    ];
    for frame in frames {
        for toward in [Toward::Device, Toward::Host] {
            let mut carried = frame;
            assert!(kernel.frame(NOW, toward, &mut carried), "{:?}", kernel.failure());
            assert_eq!(carried, frame);
        }
    }
}

#[test]
fn a_bench_has_the_lines_that_it_needs() {
    let serial = Kernel::open(KernelBus::Vcan, Some(Transport::Serial)).unwrap();
    assert_eq!(serial.bus(), "pty", "no frame crosses anything");
    let mut table = Kernel::open(KernelBus::Slcan, None).unwrap();
    assert!(table.bytes(Line::Table, Toward::Device, &mut packet(b"A")));
    let refused = Kernel::open(KernelBus::Pty, Some(Transport::Can));
    assert!(matches!(refused, Err(KernelError::NoFrames)));
}

#[test]
fn what_is_lost_or_changed_is_named_and_the_line_is_dead() {
    let (lost, _far) = stuck(Line::Gyro);
    let mut sent = packet(b"speed");
    let failure = lost.carry(Toward::Device, &mut sent).unwrap_err();
    assert!(matches!(failure.how(), How::Late { .. }), "{failure}");

    let Ends { master, slave, path } = Ends::open().unwrap();
    rustix::io::write(&master, b"stray").unwrap();
    let changed = PtyWire::of(Line::Gyro, Ends { master, slave, path: path.clone() }, SOON);
    let mut kernel = Kernel::open(KernelBus::Pty, None).unwrap().with_wire(Line::Gyro, changed);
    assert!(!kernel.bytes(Line::Gyro, Toward::Host, &mut packet(b"speed")));
    let failure = kernel.failure().unwrap();
    assert!(matches!(failure.how(), How::Changed { .. }), "{failure}");
    let text = failure.to_string();
    assert!(text.starts_with(&format!("failed to carry bytes from the gyro across {path}: ")));
    assert!(text.contains("\"speed\" went in and \"stray"), "{text}");
    assert!(!kernel.bytes(Line::Gyro, Toward::Host, &mut packet(b"more")));
    assert!(kernel.failure().is_none(), "it is told once");
}

#[test]
fn a_port_that_hangs_up_is_named() {
    let Ends { master, path, .. } = Ends::open().unwrap();
    let other = Ends::open().unwrap();
    // The slave of this master is closed; the other stands in its place.
    let wire = PtyWire::of(Line::Table, Ends { master, slave: other.slave, path }, SOON);
    let failure = wire.carry(Toward::Device, &mut packet(b"x")).unwrap_err();
    assert!(matches!(failure.how(), How::Read(_)), "{failure}");
}

fn table_run(kernel: Kernel) -> Simulated {
    let prepared = Prepared::load("live-table-run", &Made::default()).unwrap();
    simulate_across(kernel, &prepared, 1, &Answers::default(), &mut NullSink, &mut |_| true)
}

#[test]
fn a_stuck_port_ends_the_run_in_error() {
    for line in [Line::Gyro, Line::Table] {
        let (wire, _far) = stuck(line);
        let kernel = Kernel::open(KernelBus::Pty, None).unwrap().with_wire(line, wire);
        let run = table_run(kernel);
        assert_eq!(run.ending.outcome, Outcome::Error);
        let reason = run.ending.reason.unwrap();
        assert!(reason.contains(&format!("the {line} across /dev/pts/")), "{reason}");
        assert!(reason.contains("nothing of "), "{reason}");
    }
}
