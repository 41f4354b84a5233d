//! The UDS server of a device: its sessions and their timing (ISO 14229-2). [`answer`] has the services.

mod answer;

use super::Device;
use crate::isotp::{Channel, End, Received, Slowness};
use crate::uds::{DEFAULT_SESSION, Diagnosis, nrc, sid};
use emulators::random::RandomStream;
use std::collections::{BTreeMap, BTreeSet};
use wire::can::CanFrame;
use wire::time::{Span, Timestamp};

/// Share of P2 and P2* after which a server says that a response is pending, in percent. Assumption: it leaves time for
/// the frame.
const PENDING_PERCENT: i64 = 80;
/// Time from the response of an ECU reset to the reset. Assumption: the response has left the node by then.
const RESET_AFTER: Span = Span::from_millis(2);
const DELAY_S_MAX: f64 = 3_600.0;

#[derive(Debug, Clone)]
pub(super) struct Server {
    channel: Channel,
    session: u8,
    /// End of the session without another request.
    session_ends: Timestamp,
    unlocked: Option<u8>,
    /// The level and the seed that was given, until a key comes.
    seed: Option<(u8, Vec<u8>)>,
    /// Wrong keys of each level, and the end of its delay.
    attempts: BTreeMap<u8, (u32, Timestamp)>,
    random: RandomStream,
    /// Ordinary messages are not sent, or not used.
    silent: bool,
    deaf: bool,
    started: BTreeSet<u16>,
    written: BTreeSet<String>,
    /// Texts and bytes that requests have written, for good.
    stored: BTreeMap<u16, Vec<u8>>,
    reset_at: Timestamp,
    pending: Option<Pending>,
}

#[derive(Debug, Clone)]
struct Pending {
    request: Received,
    ready: Timestamp,
    due: Timestamp,
    has_said: bool,
}

/// What a service acts on, and when.
pub(super) struct Case<'a> {
    pub(super) now: Timestamp,
    pub(super) diagnosis: &'a Diagnosis,
    pub(super) device: &'a mut Device,
}

/// What a service answers: the response, unless the request suppresses it.
type Answer = Result<Vec<u8>, u8>;

impl Server {
    pub(super) fn new(diagnosis: &Diagnosis, seed: u64, device: &str) -> Self {
        Self {
            channel: Channel::new(diagnosis.isotp.clone(), End::Server),
            session: DEFAULT_SESSION,
            session_ends: Timestamp::MAX,
            unlocked: None,
            seed: None,
            attempts: BTreeMap::new(),
            random: RandomStream::new(seed, device, "uds seed"),
            silent: false,
            deaf: false,
            started: BTreeSet::new(),
            written: BTreeSet::new(),
            stored: BTreeMap::new(),
            reset_at: Timestamp::MAX,
            pending: None,
        }
    }

    /// Power-on: everything but wrong keys and stored bytes is forgotten.
    pub(super) fn power_on(&mut self) {
        self.channel.reset();
        self.enter(DEFAULT_SESSION);
        self.session_ends = Timestamp::MAX;
        self.started.clear();
        (self.pending, self.reset_at) = (None, Timestamp::MAX);
    }

    pub(super) const fn is_silent(&self) -> bool {
        self.silent
    }

    pub(super) const fn is_deaf(&self) -> bool {
        self.deaf
    }

    /// True once the reset that a request asked for is due; takes the parameters that requests have set.
    pub(super) fn resets(&mut self, now: Timestamp) -> Option<BTreeSet<String>> {
        (self.reset_at <= now).then(|| {
            self.reset_at = Timestamp::MAX;
            std::mem::take(&mut self.written)
        })
    }

    /// Number of messages not sent or received.
    pub(super) const fn dropped(&self) -> u64 {
        self.channel.failures()
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        let pending = self.pending.as_ref().map_or(Timestamp::MAX, |one| one.ready.min(one.due));
        self.channel.next_wakeup().min(pending).min(self.session_ends).min(self.reset_at)
    }

    pub(super) fn transmit(&mut self) -> Option<CanFrame> {
        self.channel.transmit()
    }

    pub(super) fn receive(&mut self, frame: &CanFrame, case: &mut Case<'_>) {
        self.slow_down(case);
        let received = self.channel.receive(case.now, frame);
        if let Some(request) = received {
            self.request(request, case);
        }
    }

    pub(super) fn wake(&mut self, case: &mut Case<'_>) {
        if self.next_wakeup() > case.now {
            return;
        }
        self.slow_down(case);
        self.channel.wake(case.now);
        if let Some(pending) = self.pending.take_if(|pending| pending.ready <= case.now) {
            self.serve(&pending.request, pending.has_said, case);
        }
        if let Some(pending) = self.pending.as_mut().filter(|pending| pending.due <= case.now) {
            pending.due = case.now + share(case.diagnosis.p2_star);
            pending.has_said = true;
            let service = pending.request.data.first().copied().unwrap_or_default();
            self.channel.send(case.now, &[sid::NEGATIVE, service, nrc::RESPONSE_PENDING]);
        }
        if self.session_ends <= case.now {
            // S3 stands still while a request arrives or is answered.
            let is_busy = !self.channel.is_idle() || self.channel.is_receiving();
            match is_busy || self.pending.is_some() {
                true => self.session_ends = case.now + case.diagnosis.s3,
                false => {
                    self.session_ends = Timestamp::MAX;
                    self.enter(DEFAULT_SESSION);
                    case.device.test_codes(true);
                }
            }
        }
    }

    /// A session begins: security is locked, and in the default session the effects of other sessions end.
    pub(super) fn enter(&mut self, session: u8) {
        self.session = session;
        (self.unlocked, self.seed) = (None, None);
        if session == DEFAULT_SESSION {
            (self.silent, self.deaf) = (false, false);
        }
    }

    fn slow_down(&mut self, case: &mut Case<'_>) {
        let mut span = |of| Span::from_secs_f64(case.device.evaluate(of).clamp(0.0, DELAY_S_MAX));
        self.channel.slowness = Slowness {
            flow_control: span(&case.diagnosis.flow_control_delay),
            separation: span(&case.diagnosis.separation),
        };
    }

    fn request(&mut self, request: Received, case: &mut Case<'_>) {
        let Some(service) = request.data.first().copied() else { return };
        self.stay(case);
        if self.pending.is_some() || !self.channel.is_idle() {
            // A response under way is not interrupted. Tester present to all servers needs no answer.
            if self.channel.is_idle() && !request.functional {
                self.channel.send(case.now, &[sid::NEGATIVE, service, nrc::BUSY_REPEAT_REQUEST]);
            }
            return;
        }
        case.device.reach(case.now);
        let delay = self.duration(&request.data, case);
        if delay == Span::ZERO {
            return self.serve(&request, false, case);
        }
        let due = match case.diagnosis.response_pending && delay > case.diagnosis.p2 {
            true => case.now + share(case.diagnosis.p2),
            false => Timestamp::MAX,
        };
        self.pending = Some(Pending { request, ready: case.now + delay, due, has_said: false });
    }

    /// How long the service of a request takes.
    fn duration(&self, data: &[u8], case: &mut Case<'_>) -> Span {
        let service = data.first().and_then(|service| case.diagnosis.services.get(service));
        let mut seconds = service.map_or(0.0, |service| case.device.evaluate(&service.delay));
        match data {
            [sid::READ_DATA, dids @ ..] => {
                for did in dids.as_chunks().0 {
                    let did = case.diagnosis.dids.get(&u16::from_be_bytes(*did));
                    seconds += did.map_or(0.0, |did| case.device.evaluate(&did.delay));
                }
            }
            [sid::WRITE_DATA, high, low, ..] => {
                let did = case.diagnosis.dids.get(&u16::from_be_bytes([*high, *low]));
                seconds += did.map_or(0.0, |did| case.device.evaluate(&did.delay));
            }
            // The highest bit suppresses the response, and the routine takes its time all the same.
            [sid::ROUTINE_CONTROL, 1 | 0x81, high, low, ..] => {
                let routine = case.diagnosis.routines.get(&u16::from_be_bytes([*high, *low]));
                seconds += routine.map_or(0.0, |routine| case.device.evaluate(&routine.delay));
            }
            _ => {}
        }
        Span::from_secs_f64(seconds.clamp(0.0, DELAY_S_MAX))
    }

    fn serve(&mut self, request: &Received, has_said: bool, case: &mut Case<'_>) {
        case.device.reach(case.now);
        let data = &request.data;
        match self.answer(data, case) {
            Ok(response) => {
                // The response to a request whose response was pending is never suppressed.
                if has_said || !is_suppressed(data) {
                    self.channel.send(case.now, &response);
                }
            }
            Err(code) => {
                // To all servers, what one does not have is no error.
                let is_silent = matches!(
                    code,
                    nrc::SERVICE_NOT_SUPPORTED
                        | nrc::SUB_FUNCTION_NOT_SUPPORTED
                        | nrc::REQUEST_OUT_OF_RANGE
                        | nrc::SUB_FUNCTION_NOT_SUPPORTED_IN_SESSION
                        | nrc::SERVICE_NOT_SUPPORTED_IN_SESSION
                );
                if has_said || !(request.functional && is_silent) {
                    let service = data.first().copied().unwrap_or_default();
                    self.channel.send(case.now, &[sid::NEGATIVE, service, code]);
                }
            }
        }
        self.stay(case);
    }

    /// Restarts S3.
    fn stay(&mut self, case: &Case<'_>) {
        self.session_ends = match self.session {
            DEFAULT_SESSION => Timestamp::MAX,
            _ => case.now + case.diagnosis.s3,
        };
    }

    pub(super) fn reset_soon(&mut self, now: Timestamp) {
        self.reset_at = now + RESET_AFTER;
    }
}

fn share(of: Span) -> Span {
    of * PENDING_PERCENT / 100
}

/// True if the request is of a service with sub-functions and suppresses its positive response.
pub(super) fn is_suppressed(data: &[u8]) -> bool {
    let has_sub_function =
        |service: u8| !matches!(service, sid::CLEAR_DTC | sid::READ_DATA | sid::WRITE_DATA);
    matches!(data, [service, sub, ..] if has_sub_function(*service) && sub & 0x80 != 0)
}
