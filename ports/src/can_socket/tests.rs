//! Tests that work on a kernel without CAN. `harness/tests/can_port.rs` has the rest.

use super::frame::{Heard, from_socket, to_socket};
use super::{CanSocketPort, kernel_has_can};
use crate::error::PortError;
use proptest::prelude::*;
use socketcan::{CanAnyFrame, CanFdFrame, CanRawFrame, EmbeddedFrame as _};
use wire::can::{CanFrame, ExtendedId, FdFlags, Id, StandardId};
use wire::can_error::CanErrorEvent;

fn raw(frame: &CanAnyFrame) -> CanRawFrame {
    CanRawFrame::Classic(*match frame {
        CanAnyFrame::Fd(frame) => return CanRawFrame::Fd(*frame.as_ref()),
        CanAnyFrame::Normal(frame) => frame.as_ref(),
        CanAnyFrame::Remote(frame) => frame.as_ref(),
        CanAnyFrame::Error(frame) => frame.as_ref(),
    })
}

fn any_id() -> impl Strategy<Value = Id> {
    prop_oneof![
        (0..=0x7ffu16).prop_map(|id| Id::Standard(StandardId::new(id).unwrap())),
        (0..=0x1fff_ffffu32).prop_map(|id| Id::Extended(ExtendedId::new(id).unwrap())),
    ]
}

proptest! {
    #[test]
    fn frames_cross_unchanged(id in any_id(), data in prop::collection::vec(any::<u8>(), 0..=8)) {
        let frame = CanFrame::new(id, &data).unwrap();
        let remote = CanFrame::new_remote(id, data.len()).unwrap();
        for frame in [frame, remote] {
            prop_assert_eq!(from_socket(&raw(&to_socket(&frame).unwrap())), Heard::Frame(frame));
        }
    }

    #[test]
    fn fd_frames_cross_unchanged(id in any_id(), flags in 0..4u8, data in prop::collection::vec(any::<u8>(), 0..=64)) {
        let flags = FdFlags::from_bits(flags);
        match CanFrame::fd(id, flags, &data) {
            Some(frame) => {
                prop_assert_eq!(from_socket(&raw(&to_socket(&frame).unwrap())), Heard::Frame(frame));
            }
            None => {
                let mut fd = *CanFdFrame::new(id, &[]).unwrap().as_ref();
                fd.len = data.len() as u8;
                prop_assert_eq!(from_socket(&CanRawFrame::Fd(fd)), Heard::Unsupported);
            }
        }
    }

    #[test]
    fn whatever_a_driver_hands_up_is_taken(id: u32, length: u8, data: [u8; 8]) {
        let empty = to_socket(&CanFrame::new(StandardId::ZERO, &[]).unwrap()).unwrap();
        let CanRawFrame::Classic(mut frame) = raw(&empty) else { unreachable!() };
        (frame.can_id, frame.can_dlc, frame.data) = (id, length, data);
        from_socket(&CanRawFrame::Classic(frame));
    }
}

#[test]
fn an_error_frame_is_an_event_of_the_bus() {
    let event = CanErrorEvent { bus_off: true, ..CanErrorEvent::default() };
    let frame = socketcan::CanErrorFrame::new_error(0x2000_0040, &[0; 8]).unwrap();
    assert_eq!(from_socket(&CanRawFrame::Classic(*frame.as_ref())), Heard::Error(event));
}

#[test]
fn a_missing_interface_is_told_from_a_kernel_without_can() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let error = runtime.block_on(async { CanSocketPort::open("nocan7").unwrap_err() });
    match error {
        PortError::NoInterface { .. } => assert!(kernel_has_can().is_ok()),
        PortError::NoCan { .. } => assert!(kernel_has_can().is_err()),
        other => panic!("{other}"),
    }
}
