//! Talks to the base on either transport: what to send next, and what has been heard.

use crate::config::{BaseConfig, Transport};
use heapless::Deque;
use wire::base::serial_link::{Host, HostEvent};
use wire::base::{Motion, Reply, Request, can_link};
use wire::can::CanFrame;
use wire::packet::Packet;
use wire::time::Timestamp;

/// Requests that wait for the line; more are refused and counted.
const REQUESTS_MAX: usize = 8;

/// What goes out to the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Outgoing {
    Frame(CanFrame),
    Bytes(Packet),
}

#[derive(Debug, Clone)]
enum Line {
    Can,
    Serial { host: Host, abandon_at: Timestamp, poll_at: Timestamp },
}

/// The host's side of the base.
#[derive(Debug, Clone)]
pub(crate) struct BaseDriver {
    config: BaseConfig,
    line: Line,
    /// Only the newest velocity counts: an older one that still waits is replaced.
    velocity: Option<Request>,
    requests: Deque<Request, REQUESTS_MAX>,
    refused: u32,
    abandoned: u32,
    motion: Option<(Timestamp, Motion)>,
}

impl BaseDriver {
    pub(crate) const fn new(config: BaseConfig) -> Self {
        let line = match config.transport {
            Transport::Can => Line::Can,
            Transport::Serial => Line::Serial {
                host: Host::new(),
                abandon_at: Timestamp::MAX,
                poll_at: Timestamp::ZERO,
            },
        };
        Self {
            config,
            line,
            velocity: None,
            requests: Deque::new(),
            refused: 0,
            abandoned: 0,
            motion: None,
        }
    }

    /// The last motion message and when it came.
    pub(crate) const fn motion(&self) -> Option<(Timestamp, Motion)> {
        self.motion
    }

    /// Requests that found the queue full.
    pub(crate) const fn refused(&self) -> u32 {
        self.refused
    }

    /// Sends `request` as soon as the line is free. A stop goes first and takes the place of every
    /// velocity that waits.
    pub(crate) fn request(&mut self, request: Request) {
        match request {
            Request::SetVelocity { .. } => self.velocity = Some(request),
            Request::Stop => {
                self.velocity = None;
                if self.requests.is_full() {
                    self.requests.pop_back();
                    self.refused = self.refused.saturating_add(1);
                }
                // There is room: one was taken out above if there was none.
                let _ = self.requests.push_front(request);
            }
            _ => {
                if self.requests.push_back(request).is_err() {
                    self.refused = self.refused.saturating_add(1);
                }
            }
        }
    }

    /// Asks for the motion now, where it does not come by itself.
    pub(crate) fn poll(&mut self, now: Timestamp) {
        if let Line::Serial { poll_at, .. } = &mut self.line {
            *poll_at = now;
        }
    }

    /// Takes a frame; gives the motion message if it is one.
    pub(crate) fn receive_frame(&mut self, now: Timestamp, frame: &CanFrame) -> Option<Motion> {
        if !matches!(self.line, Line::Can) {
            return None;
        }
        match can_link::parse_reply(frame) {
            Some(Reply::Motion(motion)) => {
                self.motion = Some((now, motion));
                Some(motion)
            }
            Some(Reply::Pose(_)) | None => None,
        }
    }

    /// Takes bytes; gives the motion message if they complete one.
    pub(crate) fn receive_bytes(&mut self, now: Timestamp, bytes: &[u8]) -> Option<Motion> {
        let Line::Serial { host, abandon_at, .. } = &mut self.line else { return None };
        let mut heard = None;
        host.feed(bytes, |event| {
            if let HostEvent::Reply(Reply::Motion(motion)) = event {
                heard = Some(motion);
            }
        });
        if !host.busy() {
            *abandon_at = Timestamp::MAX;
        }
        if let Some(motion) = heard {
            self.motion = Some((now, motion));
        }
        heard
    }

    /// Gives up an exchange that has taken too long.
    pub(crate) fn wake(&mut self, now: Timestamp) {
        if let Line::Serial { host, abandon_at, .. } = &mut self.line
            && now >= *abandon_at
        {
            host.abandon();
            *abandon_at = Timestamp::MAX;
            self.abandoned = self.abandoned.saturating_add(1);
        }
    }

    /// What goes out next, if the line is free.
    pub(crate) fn transmit(&mut self, now: Timestamp) -> Option<Outgoing> {
        if matches!(self.line, Line::Can) {
            while let Some(request) = self.next_request() {
                if let Some(frame) = can_link::request_frame(&request) {
                    return Some(Outgoing::Frame(frame));
                }
            }
            return None;
        }
        if matches!(&self.line, Line::Serial { host, .. } if host.busy()) {
            return None;
        }
        let poll_due = matches!(&self.line, Line::Serial { poll_at, .. } if now >= *poll_at);
        let request = match self.next_request() {
            Some(request) => request,
            None if poll_due => Request::ReadMotion,
            None => return None,
        };
        let Line::Serial { host, abandon_at, poll_at } = &mut self.line else { return None };
        if matches!(request, Request::ReadMotion) {
            *poll_at = now + self.config.poll_at_rest;
        }
        let packet = host.start(&request)?;
        *abandon_at = now + self.config.exchange_timeout;
        Some(Outgoing::Bytes(packet))
    }

    /// When [`Self::wake`] or [`Self::transmit`] has something to do without anything being heard.
    pub(crate) fn next_wakeup(&self) -> Timestamp {
        match &self.line {
            Line::Can => Timestamp::MAX,
            Line::Serial { host, abandon_at, poll_at } => {
                if host.busy() { *abandon_at } else { *poll_at }
            }
        }
    }

    fn next_request(&mut self) -> Option<Request> {
        self.requests.pop_front().or_else(|| self.velocity.take())
    }
}
