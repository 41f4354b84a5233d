//! The command set on CAN: one data frame with a standard identifier per message.
//!
//! The base sends motion and pose unprompted, so the two reads have no frame. Frames of other nodes, extended, remote
//! or CAN FD frames and frames of another length are ignored (`None`): on a shared bus they are not errors of this
//! link.

use super::payload::{Payload, decode_reply, decode_request, encode_reply, encode_request};
use super::{Message, Reply, Request};
use crate::can::CanFrame;

/// The frame of a request; `None` for [`Request::ReadMotion`] and [`Request::ReadPose`], and for a value that
/// [`super::payload`] refuses.
pub fn request_frame(request: &Request) -> Option<CanFrame> {
    let (message, payload) = encode_request(request)?;
    data_frame(message, &payload)
}

/// The request in a frame; `None` unless it is a host's message of the right length.
pub fn parse_request(frame: &CanFrame) -> Option<Request> {
    decode_request(message_of(frame)?, frame.data())
}

/// The frame of a reply.
pub fn reply_frame(reply: &Reply) -> CanFrame {
    let (message, payload) = encode_reply(reply);
    data_frame(message, &payload).expect("a payload is no longer than a frame's data")
}

/// The reply in a frame; `None` unless it is the base's message of the right length.
pub fn parse_reply(frame: &CanFrame) -> Option<Reply> {
    decode_reply(message_of(frame)?, frame.data())
}

fn data_frame(message: Message, payload: &Payload) -> Option<CanFrame> {
    CanFrame::new(message.can_id(), payload.as_slice())
}

fn message_of(frame: &CanFrame) -> Option<Message> {
    let is_other = frame.is_remote() || frame.fd_flags().is_some();
    if is_other { None } else { Message::from_can_id(frame.id()) }
}

#[cfg(test)]
mod tests {
    use super::{parse_reply, parse_request, reply_frame, request_frame};
    use crate::base::payload::tests::{any_reply, any_request, carried_reply, carried_request};
    use crate::base::{Message, Request};
    use crate::can::{CanFrame, DATA_BYTES_MAX, ExtendedId, StandardId};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_sent_arrives(request in any_request(), reply in any_reply()) {
            if let Some(frame) = request_frame(&request) {
                prop_assert_eq!(parse_request(&frame), carried_request(&request));
                prop_assert_eq!(parse_reply(&frame), None);
            }
            let frame = reply_frame(&reply);
            prop_assert_eq!(parse_reply(&frame), Some(carried_reply(&reply)));
            prop_assert_eq!(parse_request(&frame), None);
        }

        #[test]
        fn a_frame_is_read_only_at_its_own_length(
            id in 0x0F0u16..0x1A0,
            data in prop::collection::vec(any::<u8>(), 0..=DATA_BYTES_MAX),
        ) {
            let id = StandardId::new(id).unwrap();
            let frame = CanFrame::new(id, &data).unwrap();
            let message = Message::from_can_id(id.into());
            let expected = message.filter(|message| message.payload_bytes() == data.len());
            if let Some(request) = parse_request(&frame) {
                prop_assert!(expected.is_some_and(|message| !message.is_reply()));
                // Encoding the request again gives the received bytes, except for bits that are not read.
                let again = request_frame(&request).unwrap();
                prop_assert_eq!(parse_request(&again), Some(request));
            }
            prop_assert_eq!(
                parse_reply(&frame).is_some(),
                expected.is_some_and(|message| message.is_reply())
            );
        }
    }

    #[test]
    fn extended_and_remote_frames_are_passed_over() {
        let stop = request_frame(&Request::Stop).unwrap();
        assert_eq!(parse_request(&stop), Some(Request::Stop));
        let extended = ExtendedId::new(0x104).unwrap();
        assert_eq!(parse_request(&CanFrame::new(extended, stop.data()).unwrap()), None);
        for message in Message::ALL {
            let length = message.payload_bytes();
            let remote =
                <CanFrame as embedded_can::Frame>::new_remote(message.can_id(), length).unwrap();
            assert_eq!(parse_request(&remote), None);
            assert_eq!(parse_reply(&remote), None);
        }
    }

    #[test]
    fn a_read_has_no_frame() {
        assert_eq!(request_frame(&Request::ReadMotion), None);
        assert_eq!(request_frame(&Request::ReadPose), None);
    }
}
