//! A message being sent in several frames.

use super::{CONSECUTIVE, CONTINUE, Channel, OVERFLOW, WAIT};
use wire::time::{Span, Timestamp};

/// Waits in a row that a sender accepts (N_WFTmax). Assumption: the standard leaves it to the sender.
const WAITS_MAX: u8 = 10;

#[derive(Debug, Clone)]
pub(super) struct Going {
    /// What has not been sent.
    rest: Vec<u8>,
    /// Sequence number of the next frame.
    number: u8,
    /// Frames until the next flow control; `None` if none follows.
    in_block: Option<u8>,
    separation: Span,
    /// False while it waits for a flow control.
    may_send: bool,
    waits: u8,
    /// Time of the next frame, or of giving up.
    pub(super) due: Timestamp,
}

impl Going {
    /// The first frame is out, and `rest` follows it once the receiver allows that.
    pub(super) const fn new(rest: Vec<u8>, due: Timestamp) -> Self {
        let separation = Span::ZERO;
        Self { rest, number: 1, in_block: None, separation, may_send: false, waits: 0, due }
    }
}

/// The separation time of a flow control (9.6.5.4); reserved values mean the longest.
pub(super) const fn separation(st_min: u8) -> Span {
    match st_min {
        0..=0x7F => Span::from_millis(st_min as i64),
        0xF1..=0xF9 => Span::from_micros((st_min - 0xF0) as i64 * 100),
        _ => Span::from_millis(0x7F),
    }
}

impl Channel {
    pub(super) fn flow_control(
        &mut self,
        now: Timestamp,
        status: u8,
        (block_size, st_min): (u8, u8),
    ) {
        let Some(going) = self.going.as_mut().filter(|going| !going.may_send) else { return };
        match status {
            CONTINUE => {
                going.in_block = (block_size > 0).then_some(block_size);
                going.separation = separation(st_min);
                (going.may_send, going.waits, going.due) = (true, 0, now);
                self.go_on(now);
            }
            WAIT if going.waits < WAITS_MAX => {
                going.waits += 1;
                going.due = now + self.settings.n_bs;
            }
            _ => {
                self.going = None;
                self.fail(match status {
                    WAIT => "the receiver asked for too many waits",
                    OVERFLOW => "the message is too long for the receiver",
                    _ => "a flow control with an invalid flow status",
                });
            }
        }
    }

    /// Sends the consecutive frames that are due, or gives up.
    pub(super) fn go_on(&mut self, now: Timestamp) {
        let (id, room) = (self.id(), self.settings.frame_bytes() - 1);
        while let Some(going) = self.going.as_mut().filter(|going| going.due <= now) {
            if !going.may_send {
                self.going = None;
                self.fail("no flow control within N_Bs");
                return;
            }
            let count = room.min(going.rest.len());
            let mut content = vec![CONSECUTIVE << 4 | going.number];
            content.extend(going.rest.drain(..count));
            going.number = (going.number + 1) & 0xF;
            going.in_block = going.in_block.map(|left| left - 1);
            let separation = match self.slowness.separation {
                Span::ZERO => going.separation,
                slow => slow,
            };
            going.due = now + separation;
            if going.in_block == Some(0) {
                (going.may_send, going.due) = (false, now + self.settings.n_bs);
            }
            let is_last = going.rest.is_empty();
            self.push(id, &content);
            if is_last {
                self.going = None;
            }
        }
    }
}
