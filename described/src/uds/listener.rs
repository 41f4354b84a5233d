//! A listener: pairs the requests and responses of others on a channel, such as those of a log.

use super::client::{Reply, Request};
use super::{nrc, sid};
use crate::isotp::{Channel, End, IsoTp};
use std::collections::VecDeque;
use wire::can::CanFrame;
use wire::time::Timestamp;

/// Most exchanges that wait to be asked for; the oldest is forgotten.
const EXCHANGES_MAX: usize = 1_024;

/// Hears both ends of a channel, and sends nothing.
#[derive(Debug, Clone)]
pub struct UdsListener {
    server: Channel,
    client: Channel,
    /// Requests in their order, each with its response.
    exchanges: VecDeque<(Vec<u8>, Option<Vec<u8>>)>,
    /// What was asked for, and until when.
    wanted: Option<(Vec<u8>, Timestamp)>,
    reply: Option<Reply>,
}

impl UdsListener {
    /// Listens on this channel.
    pub fn new(channel: &IsoTp) -> Self {
        Self {
            server: Channel::new(channel.clone(), End::Server),
            client: Channel::new(channel.clone(), End::Client),
            exchanges: VecDeque::new(),
            wanted: None,
            reply: None,
        }
    }

    /// Takes the response to the next such request: one that was heard since the last that was asked for, or is heard
    /// within P2*.
    pub fn ask(&mut self, now: Timestamp, request: &Request) {
        self.reply = None;
        self.wanted = Some((request.data.clone(), now + request.p2_star));
        self.settle(now);
    }

    /// Takes a frame of either end.
    pub fn receive(&mut self, now: Timestamp, frame: &CanFrame) {
        if let Some(request) = self.server.receive(now, frame) {
            self.exchanges.push_back((request.data, None));
            if self.exchanges.len() > EXCHANGES_MAX {
                self.exchanges.pop_front();
            }
        }
        if let Some(response) = self.client.receive(now, frame) {
            self.hear(response.data);
        }
        for end in [&mut self.server, &mut self.client] {
            while end.transmit().is_some() {}
        }
        self.settle(now);
    }

    fn hear(&mut self, response: Vec<u8>) {
        let Some((request, known)) = self.exchanges.back_mut() else { return };
        let asked = request.first().copied().unwrap_or_default();
        let is_its = match response.as_slice() {
            [sid::NEGATIVE, service, code, ..] => {
                *service == asked && *code != nrc::RESPONSE_PENDING
            }
            [service, ..] => *service == asked | sid::POSITIVE,
            [] => false,
        };
        if is_its {
            known.get_or_insert(response);
        }
    }

    /// Does the work due at `now`.
    pub fn wake(&mut self, now: Timestamp) {
        self.settle(now);
    }

    /// Time of the next wake-up if nothing arrives before.
    pub fn next_wakeup(&self) -> Timestamp {
        match (&self.reply, &self.wanted) {
            (Some(_), _) => Timestamp::ZERO,
            (None, Some((_, until))) => *until,
            (None, None) => Timestamp::MAX,
        }
    }

    /// What became of the request that was asked for, once.
    pub const fn reply(&mut self) -> Option<Reply> {
        self.reply.take()
    }

    fn settle(&mut self, now: Timestamp) {
        let Some((wanted, until)) = &self.wanted else { return };
        let place = self.exchanges.iter().position(|(request, _)| request == wanted);
        let is_over = now >= *until;
        let reply = match place.and_then(|place| Some((place, self.exchanges.get(place)?))) {
            Some((_, (_, Some(response)))) => Reply::Response(response.clone()),
            // Another request has followed: nothing answers this one any more.
            Some((place, (_, None))) if is_over || place + 1 < self.exchanges.len() => {
                Reply::Silence
            }
            None if is_over => Reply::Silence,
            _ => return,
        };
        self.exchanges.drain(..place.map_or(0, |place| place + 1));
        (self.wanted, self.reply) = (None, Some(reply));
    }
}
