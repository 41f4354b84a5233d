//! The driver of the base on either transport: selects what to send and keeps what was received.

use crate::config::{BaseConfig, Transport};
use crate::displacement_watch::DisplacementWatch;
use crate::mutant::Planted;
use crate::ordered::Ordered;
use heapless::Deque;
use wire::base::serial_link::{Host, HostEvent, quiet_time};
use wire::base::{Motion, Reply, Request, can_link};
use wire::can::CanFrame;
use wire::packet::Packet;
use wire::time::{Span, Timestamp};
use wire::units::{AngularRate, Speed};

/// Capacity of the request queue; further requests are refused and counted.
const REQUESTS_MAX: usize = 8;

/// Attempts per request on the serial line.
const TRIES_MAX: u8 = 3;

/// A moving base that stayed silent for this many exchanges receives no velocity: each command would restart the
/// base's own time-out, which stops it when commands no longer arrive.
const UNHEARD_EXCHANGES: i64 = 2;

/// An order to stand.
const STAND: Request = Request::SetVelocity { drive: Speed::ZERO, steer: AngularRate::ZERO };

/// Polls per time-out while the base moves without being commanded.
const POLLS_PER_TIMEOUT: i64 = 3;

/// Output to the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Outgoing {
    Frame(CanFrame),
    Bytes(Packet),
}

#[derive(Debug, Clone)]
enum Line {
    Can,
    Serial(SerialLine),
}

/// The serial line: one exchange at a time.
#[derive(Debug, Clone)]
struct SerialLine {
    host: Host,
    /// The exchange in progress: its request and the number of attempts so far.
    under_way: Option<(Request, u8)>,
    /// When the last exchange began.
    asked: Timestamp,
    abandon_at: Timestamp,
    /// The line rests until this time, so that a late answer cannot be taken for the next one's.
    quiet_until: Timestamp,
    poll_at: Timestamp,
    repeat: Option<(Request, u8)>,
}

/// The host's side of the base.
#[derive(Debug, Clone)]
pub(crate) struct BaseDriver {
    config: BaseConfig,
    line: Line,
    /// Only the newest velocity counts: it replaces an older one still in the queue.
    velocity: Option<Request>,
    requests: Deque<Request, REQUESTS_MAX>,
    refused: u32,
    motion: Option<(Timestamp, Motion)>,
    ordered: Ordered,
    path: DisplacementWatch,
    planted: Planted,
}

impl BaseDriver {
    pub(crate) fn new(config: BaseConfig, planted: Planted) -> Self {
        let line = match config.transport {
            Transport::Can => Line::Can,
            Transport::Serial => Line::Serial(SerialLine {
                host: Host::default(),
                under_way: None,
                asked: Timestamp::ZERO,
                abandon_at: Timestamp::MAX,
                quiet_until: Timestamp::ZERO,
                poll_at: Timestamp::ZERO,
                repeat: None,
            }),
        };
        Self {
            config,
            line,
            velocity: None,
            requests: Deque::new(),
            refused: 0,
            motion: None,
            ordered: Ordered::new(matches!(config.transport, Transport::Serial)),
            path: DisplacementWatch::new(&config),
            planted,
        }
    }

    /// The last motion message and its arrival time.
    pub(crate) const fn motion(&self) -> Option<(Timestamp, Motion)> {
        self.motion
    }

    /// True unless the base said that it stands, and said so after it was last ordered to.
    pub(crate) fn may_move(&self) -> bool {
        self.ordered.since().is_some() || self.motion.is_none_or(|(_, motion)| motion.moving)
    }

    pub(crate) const fn ordered(&self) -> &Ordered {
        &self.ordered
    }

    /// True if the last motion message restarted the displacement count.
    pub(crate) const fn counts_anew(&self) -> bool {
        self.path.counts_anew()
    }

    /// Number of requests refused because the queue was full.
    pub(crate) const fn refused(&self) -> u32 {
        self.refused
    }

    /// Sends `request` as soon as the line is free. A stop goes first and replaces all queued velocities.
    pub(crate) fn request(&mut self, request: Request) {
        match request {
            Request::SetVelocity { .. } => self.velocity = Some(request),
            Request::Stop => {
                self.velocity = None;
                // One stop in the queue is enough.
                if self.requests.front() == Some(&Request::Stop) {
                    return;
                }
                if self.requests.is_full() {
                    self.requests.pop_back();
                    self.refused = self.refused.saturating_add(1);
                }
                // Cannot fail: a full queue was shortened above.
                let _ = self.requests.push_front(request);
            }
            _ => {
                if self.requests.push_back(request).is_err() {
                    self.refused = self.refused.saturating_add(1);
                }
            }
        }
    }

    /// Sends `request` again, before all that waits, on CAN: there nothing shows that it arrived.
    pub(crate) fn request_again(&mut self, request: Request) {
        if matches!(self.line, Line::Can) && self.requests.push_front(request).is_err() {
            self.refused = self.refused.saturating_add(1);
        }
    }

    /// Requests the motion now if the base does not send it unprompted.
    pub(crate) fn poll(&mut self, now: Timestamp) {
        if let Line::Serial(line) = &mut self.line {
            line.poll_at = now;
        }
    }

    /// Takes a frame; returns its motion message, if any.
    pub(crate) fn receive_frame(&mut self, now: Timestamp, frame: &CanFrame) -> Option<Motion> {
        if !matches!(self.line, Line::Can) {
            return None;
        }
        match can_link::parse_reply(frame) {
            Some(Reply::Motion(motion)) => self.hear(now, now, motion),
            Some(Reply::Pose(_)) | None => None,
        }
    }

    /// Takes bytes; returns the motion message that they complete, if any.
    pub(crate) fn receive_bytes(&mut self, now: Timestamp, bytes: &[u8]) -> Option<Motion> {
        let Line::Serial(line) = &mut self.line else { return None };
        let mut heard = None;
        let mut garbled = false;
        line.host.feed(bytes, |event| match event {
            HostEvent::Reply(Reply::Motion(motion)) => heard = Some(motion),
            HostEvent::BadChecksum(_) => garbled = true,
            HostEvent::Reply(Reply::Pose(_)) | HostEvent::Written(_) | HostEvent::Unexpected(_) => {
            }
        });
        if !line.host.busy() {
            let failed = line.under_way.take().filter(|_| garbled);
            line.abandon_at = Timestamp::MAX;
            line.failed(now, failed);
        }
        let asked = line.asked;
        let heard = heard.and_then(|motion| self.hear(now, asked, motion));
        if heard.is_some() {
            let poll_at = now + self.poll_period();
            if let Line::Serial(line) = &mut self.line {
                line.poll_at = line.poll_at.min(poll_at);
            }
        }
        heard
    }

    /// Takes a motion message that was sampled at `sampled` or later, if it is credible.
    fn hear(&mut self, now: Timestamp, sampled: Timestamp, motion: Motion) -> Option<Motion> {
        if !self.path.believes(now, &motion, self.ordered.since()) {
            return None;
        }
        self.motion = Some((now, motion));
        self.ordered.hears(sampled, &motion);
        if self.ordered.waits_for_answer() && self.ordered.since().is_none() {
            self.velocity = Some(STAND);
        }
        Some(motion)
    }

    /// Abandons an exchange that has taken too long.
    pub(crate) fn wake(&mut self, now: Timestamp) {
        if let Line::Serial(line) = &mut self.line
            && now >= line.abandon_at
        {
            line.host.abandon();
            line.abandon_at = Timestamp::MAX;
            let failed = line.under_way.take();
            line.failed(now, failed);
        }
    }

    /// True if [`Self::transmit`] cannot have anything to send.
    #[inline]
    pub(crate) fn has_nothing_to_send(&self, now: Timestamp) -> bool {
        let is_quiet = match &self.line {
            Line::Can => true,
            Line::Serial(line) => line.repeat.is_none() && now < line.poll_at,
        };
        is_quiet && self.velocity.is_none() && self.requests.is_empty()
    }

    /// The base moves, or was ordered to, and has not been heard since.
    fn is_unheard(&self, now: Timestamp) -> bool {
        let limit = self.config.exchange_timeout * UNHEARD_EXCHANGES;
        let since =
            self.motion.map(|(heard, _)| self.ordered.since().map_or(heard, |at| at.max(heard)));
        self.may_move() && since.is_some_and(|since| now - since > limit)
    }

    /// The next output, if the line is free.
    pub(crate) fn transmit(&mut self, now: Timestamp) -> Option<Outgoing> {
        if self.is_unheard(now) && !self.planted.blinds_second_looks() {
            self.velocity = None;
        }
        let before = self.motion.map(|(_, motion)| motion);
        let mut serial_turn = None;
        match &mut self.line {
            Line::Can => {}
            Line::Serial(line) if line.host.busy() || now < line.quiet_until => return None,
            Line::Serial(line) => serial_turn = Some((line.repeat.take(), now >= line.poll_at)),
        }
        let Some((repeat, poll_due)) = serial_turn else {
            while let Some(request) = self.next_request() {
                if let Some(frame) = can_link::request_frame(&request) {
                    self.ordered.sends(now, &request, before);
                    return Some(Outgoing::Frame(frame));
                }
            }
            return None;
        };
        // A stop takes precedence over everything.
        let stop = matches!(self.requests.front(), Some(Request::Stop));
        let mut repeat = repeat.filter(|_| !stop);
        loop {
            let (request, tries) = match repeat.take() {
                Some(repeat) => repeat,
                None => match self.next_request() {
                    Some(request) => (request, 0),
                    None if poll_due => (Request::ReadMotion, 0),
                    None => return None,
                },
            };
            let poll_at = now + self.poll_period();
            let Line::Serial(line) = &mut self.line else { return None };
            let poll = matches!(request, Request::ReadMotion);
            if poll {
                line.poll_at = poll_at;
            }
            if let Some(packet) = line.host.start(&request) {
                line.under_way = Some((request, tries + 1));
                line.asked = now;
                line.abandon_at = now + self.config.exchange_timeout;
                self.ordered.sends(now, &request, before);
                return Some(Outgoing::Bytes(packet));
            }
            // The request cannot be encoded: drop it and take the next one.
            if poll {
                return None;
            }
        }
    }

    /// Time at which [`Self::wake`] or [`Self::transmit`] has work even if nothing arrives.
    pub(crate) fn next_wakeup(&self) -> Timestamp {
        match &self.line {
            Line::Can => Timestamp::MAX,
            Line::Serial(line) if line.host.busy() => line.abandon_at,
            Line::Serial(line) => {
                let waiting =
                    line.repeat.is_some() || self.velocity.is_some() || !self.requests.is_empty();
                if waiting { line.quiet_until } else { line.poll_at.max(line.quiet_until) }
            }
        }
    }

    /// Time between two polls that the driver adds by itself. A moving base has a shorter time-out than a stationary
    /// one and is polled more often.
    fn poll_period(&self) -> Span {
        match self.motion {
            Some((_, motion)) if motion.moving => self.config.timeout_moving / POLLS_PER_TIMEOUT,
            _ => self.config.poll_at_rest,
        }
    }

    fn next_request(&mut self) -> Option<Request> {
        self.requests.pop_front().or_else(|| self.velocity.take())
    }
}

impl SerialLine {
    /// An exchange failed: the line rests. The driver repeats a request a few times, except velocities, which are
    /// renewed anyway, and pose writes, which have their own retries.
    fn failed(&mut self, now: Timestamp, failed: Option<(Request, u8)>) {
        let Some((request, tries)) = failed else { return };
        self.quiet_until = now + quiet_time();
        let repeatable = matches!(request, Request::SetAcceleration { .. } | Request::Stop);
        self.repeat = (repeatable && tries < TRIES_MAX).then_some((request, tries));
    }
}

#[cfg(test)]
mod tests {
    use super::{
        AngularRate, BaseConfig, BaseDriver, Motion, Outgoing, Planted, Reply, Request, Span,
        Speed, Timestamp, Transport, can_link,
    };
    use wire::base::serial_link::{Device, DeviceEvent, write_answer};

    #[test]
    fn an_answer_that_was_asked_for_before_the_stop_does_not_show_that_the_base_stands() {
        let mut base = BaseDriver::new(BaseConfig::new(Transport::Serial), Planted::default());
        let mut device = Device::default();
        let at = |ms| Timestamp::ZERO + Span::from_millis(ms);
        // What the base answers to the packet that is sent at this time: it stands.
        let mut exchange = |base: &mut BaseDriver, ms| {
            let Some(Outgoing::Bytes(packet)) = base.transmit(at(ms)) else { panic!("{ms} ms") };
            let mut answer = None;
            device.feed(packet.as_slice(), |event| {
                answer = match event {
                    DeviceEvent::Write { answer, .. } => Some(write_answer(answer)),
                    DeviceEvent::Read(read) => read.packet(&Reply::Motion(Motion::default())),
                    DeviceEvent::Refused(_) => None,
                };
            });
            answer.unwrap()
        };
        let drive = Speed::from_m_per_s(0.4);
        base.request(Request::SetVelocity { drive, steer: AngularRate::ZERO });
        let answer = exchange(&mut base, 0);
        base.receive_bytes(at(10), answer.as_slice());
        base.poll(at(20));
        let late = exchange(&mut base, 20);
        base.request(Request::Stop);
        assert!(base.receive_bytes(at(30), late.as_slice()).is_some() && base.may_move());
        let answer = exchange(&mut base, 31);
        base.receive_bytes(at(40), answer.as_slice());
        assert!(base.may_move());
        base.poll(at(41));
        let asked_since = exchange(&mut base, 41);
        base.receive_bytes(at(50), asked_since.as_slice());
        assert!(!base.may_move());
    }

    #[test]
    fn a_base_that_moves_unheard_is_told_to_stop_and_nothing_else() {
        let at = |ms| Timestamp::ZERO + Span::from_millis(ms);
        let drive = Speed::from_m_per_s(0.4);
        let on = Request::SetVelocity { drive, steer: AngularRate::ZERO };
        // One that was heard to stand may have moved since the order.
        for moving in [true, false] {
            let mut base = BaseDriver::new(BaseConfig::new(Transport::Can), Planted::default());
            let said = Motion { moving, ..Motion::default() };
            let frame = can_link::reply_frame(&Reply::Motion(said));
            assert!(base.receive_frame(at(if moving { 1_000 } else { 600 }), &frame).is_some());
            for (ms, is_sent) in [(1_000, true), (1_119, true), (1_121, false)] {
                base.request(on);
                assert_eq!(base.transmit(at(ms)).is_some(), is_sent, "{moving} {ms} ms");
            }
            base.request(on);
            base.request(Request::Stop);
            let stop = can_link::request_frame(&Request::Stop).unwrap();
            assert_eq!(base.transmit(at(1_200)), Some(Outgoing::Frame(stop)));
        }
    }
}
