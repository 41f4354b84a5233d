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
    /// In their order.
    exchanges: VecDeque<Exchange>,
    wanted: Option<Wanted>,
    reply: Option<Reply>,
}

/// A request that was heard.
#[derive(Debug, Clone)]
struct Exchange {
    request: Vec<u8>,
    response: Option<Vec<u8>>,
    /// When it or a response pending was heard last.
    at: Timestamp,
    is_pending: bool,
}

/// What was asked for.
#[derive(Debug, Clone)]
struct Wanted {
    request: Request,
    /// When it is no longer waited for, if it is not heard.
    until: Timestamp,
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
    /// within P2*. From then on its response has the time that a client would give it.
    pub fn ask(&mut self, now: Timestamp, request: &Request) {
        self.reply = None;
        self.wanted = Some(Wanted { request: request.clone(), until: now + request.p2_star });
        self.settle(now);
    }

    /// Takes a frame of either end.
    pub fn receive(&mut self, now: Timestamp, frame: &CanFrame) {
        if let Some(request) = self.server.receive(now, frame) {
            let (request, response, is_pending) = (request.data, None, false);
            self.exchanges.push_back(Exchange { request, response, at: now, is_pending });
            if self.exchanges.len() > EXCHANGES_MAX {
                self.exchanges.pop_front();
            }
        }
        if let Some(response) = self.client.receive(now, frame) {
            self.hear(now, response.data);
        }
        for end in [&mut self.server, &mut self.client] {
            while end.transmit().is_some() {}
        }
        self.settle(now);
    }

    fn hear(&mut self, now: Timestamp, response: Vec<u8>) {
        let Some(exchange) = self.exchanges.back_mut() else { return };
        let asked = exchange.request.first().copied().unwrap_or_default();
        let (is_its, is_pending) = match response.as_slice() {
            [sid::NEGATIVE, service, code, ..] => {
                (*service == asked, *code == nrc::RESPONSE_PENDING)
            }
            [service, ..] => (*service == asked | sid::POSITIVE, false),
            [] => (false, false),
        };
        if is_its && is_pending {
            (exchange.at, exchange.is_pending) = (now, true);
        } else if is_its {
            exchange.response.get_or_insert(response);
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
            (None, Some(wanted)) => self.place(wanted).map_or(wanted.until, |(_, _, over)| over),
            (None, None) => Timestamp::MAX,
        }
    }

    /// What became of the request that was asked for, once.
    pub const fn reply(&mut self) -> Option<Reply> {
        self.reply.take()
    }

    /// The exchange that was asked for, and when its response is no longer waited for.
    fn place(&self, wanted: &Wanted) -> Option<(usize, &Exchange, Timestamp)> {
        let Request { data, p2, p2_star, .. } = &wanted.request;
        let place = self.exchanges.iter().position(|exchange| exchange.request == *data)?;
        let exchange = self.exchanges.get(place)?;
        let over = exchange.at + if exchange.is_pending { *p2_star } else { *p2 };
        Some((place, exchange, over))
    }

    fn settle(&mut self, now: Timestamp) {
        let Some(wanted) = &self.wanted else { return };
        let found = self.place(wanted);
        let reply = match found {
            Some((_, Exchange { response: Some(response), .. }, _)) => {
                Reply::Response(response.clone())
            }
            // Another request has followed: nothing answers this one any more.
            Some((place, _, over)) if now >= over || place + 1 < self.exchanges.len() => {
                Reply::Silence
            }
            None if now >= wanted.until => Reply::Silence,
            _ => return,
        };
        let taken = found.map_or(0, |(place, ..)| place + 1);
        self.exchanges.drain(..taken);
        (self.wanted, self.reply) = (None, Some(reply));
    }
}
