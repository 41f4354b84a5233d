//! A client: sends requests and waits for responses (ISO 14229-2).

use super::{nrc, sid};
use crate::isotp::{Channel, End, IsoTp};
use wire::can::CanFrame;
use wire::time::{Span, Timestamp};

/// A request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// Service identifier and what follows it.
    pub data: Vec<u8>,
    /// To all servers.
    pub functional: bool,
    /// Wait for a response to begin.
    pub p2: Span,
    /// The same after a response pending.
    pub p2_star: Span,
}

/// What became of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Reply {
    /// The response.
    Response(Vec<u8>),
    /// No response within P2 or P2*.
    Silence,
    /// It could not be sent or received, and why.
    Failed(String),
}

/// One end of a channel that asks.
#[derive(Debug, Clone)]
pub struct UdsClient {
    channel: Channel,
    /// The request that waits for its response, and until when. That is open until the request is sent.
    waiting: Option<(Request, Timestamp)>,
    reply: Option<Reply>,
}

impl UdsClient {
    /// The client of a server on this channel.
    pub fn new(channel: &IsoTp) -> Self {
        Self { channel: Channel::new(channel.clone(), End::Client), waiting: None, reply: None }
    }

    /// Sends a request, in place of one that is under way.
    pub fn ask(&mut self, now: Timestamp, request: Request) {
        self.channel.reset();
        self.reply = None;
        let is_sent = match request.functional {
            true => self.channel.send_to_all(&request.data),
            false => self.channel.send(now, &request.data),
        };
        if is_sent {
            self.waiting = Some((request, Timestamp::MAX));
            self.sent(now);
        } else {
            self.waiting = None;
            let text = "a request to all servers goes in a single frame, and one to a server has 1 to 4095 bytes";
            self.reply = Some(Reply::Failed(text.to_owned()));
        }
    }

    /// Takes a frame from the bus.
    pub fn receive(&mut self, now: Timestamp, frame: &CanFrame) {
        let received = self.channel.receive(now, frame);
        self.sent(now);
        self.fail();
        let Some((request, until)) = &mut self.waiting else { return };
        // A response that has begun is in time.
        if self.channel.is_receiving() {
            *until = Timestamp::MAX;
        }
        let Some(received) = received else { return };
        let asked = request.data.first().copied().unwrap_or_default();
        match received.data.as_slice() {
            [sid::NEGATIVE, service, nrc::RESPONSE_PENDING] if *service == asked => {
                *until = now + request.p2_star;
            }
            [sid::NEGATIVE, service, ..] if *service == asked => self.end(received.data),
            [service, ..] if *service == asked | sid::POSITIVE => self.end(received.data),
            // The response to an earlier request.
            _ => *until = now + request.p2,
        }
    }

    /// Does the work due at `now`.
    pub fn wake(&mut self, now: Timestamp) {
        self.channel.wake(now);
        self.sent(now);
        self.fail();
        if self.waiting.take_if(|(_, until)| *until <= now).is_some() {
            self.reply = Some(Reply::Silence);
        }
    }

    /// Time of the next wake-up if nothing arrives before.
    pub fn next_wakeup(&self) -> Timestamp {
        if self.reply.is_some() {
            return Timestamp::ZERO;
        }
        let until = self.waiting.as_ref().map_or(Timestamp::MAX, |(_, until)| *until);
        self.channel.next_wakeup().min(until)
    }

    /// The next frame for the bus.
    pub fn transmit(&mut self) -> Option<CanFrame> {
        self.channel.transmit()
    }

    /// What became of the request, once.
    pub const fn reply(&mut self) -> Option<Reply> {
        self.reply.take()
    }

    fn end(&mut self, response: Vec<u8>) {
        self.waiting = None;
        self.reply = Some(Reply::Response(response));
    }

    /// P2 begins once the request is out: its last frame is queued.
    fn sent(&mut self, now: Timestamp) {
        if let Some((request, until)) = &mut self.waiting
            && *until == Timestamp::MAX
            && !self.channel.is_sending()
            && !self.channel.is_receiving()
        {
            *until = now + request.p2;
        }
    }

    fn fail(&mut self) {
        if let (Some(why), true) = (self.channel.failure(), self.waiting.is_some()) {
            self.waiting = None;
            self.reply = Some(Reply::Failed(why.to_owned()));
        }
    }
}
