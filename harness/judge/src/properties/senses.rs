//! Interprets events: decodes bytes, and remembers orders until they are answered.

use super::Limits;
use super::hidden::Hidden;
use super::limits::BRIDGED_MAX;
use super::seen::{Seen, Truth};
use controller::config::Transport;
use controller::health::Health;
use controller::mission::{Command, HeadingSource, MissionId, Report, State};
use controller::{Output, Port};
use std::collections::VecDeque;
use wire::base::serial_link::{Device, DeviceEvent, Host, HostEvent};
use wire::base::{Motion, Reply, Request, can_link};
use wire::device::Transmit;
use wire::gyro::{GyroDecoder, GyroOutput, GyroSample};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, Length};

/// Missions that wait for an answer; the oldest is dropped first. The controller answers at once or runs one mission,
/// so more means that it does not answer.
const ORDERS_MAX: usize = 64;

/// A message of the base is no older: three of its periods in motion.
const HEARD_JUST_NOW: Span = Span::from_millis(60);

/// A base that said that it stands is known to for this long: its period at rest, and a message on its way.
const RESTS_FOR: Span = Span::from_millis(600);

/// The part of a mission that matters when it is answered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Order {
    Straight(Length),
    Turn(Angle),
    Stop,
    BiasTest,
    Source(HeadingSource),
    /// Makes the believed pose jump: sets a pose or a calibration.
    Setting,
    Other,
}

/// An interpreted event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Fact {
    /// [`Senses::truth`] has changed.
    Truth,
    /// Bytes of the gyro arrived.
    Gyro,
    /// The base's motion arrived.
    Motion,
    /// The controller sent this request to the base.
    Request(Request),
    /// A mission was given.
    Told(MissionId, Order),
    /// The mission was answered.
    Answered(MissionId, Order, Report),
    State(State),
    /// [`Senses::health`] has changed.
    Health,
    StepBegan,
    StepEnded,
    Placed,
    /// [`Senses::faults`] has changed.
    Faults,
    BusOff,
}

/// Topic of a fact; a judge receives the facts of its topics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Topic {
    Truth,
    Gyro,
    Motion,
    Request,
    Mission,
    State,
    Health,
    Step,
    Faults,
    BusOff,
}

impl Topic {
    /// Number of topics.
    pub(super) const COUNT: usize = Self::BusOff as usize + 1;
}

impl Fact {
    pub(super) const fn topic(&self) -> Topic {
        match self {
            Self::Truth => Topic::Truth,
            Self::Gyro => Topic::Gyro,
            Self::Motion => Topic::Motion,
            Self::Request(_) => Topic::Request,
            Self::Told(..) | Self::Answered(..) => Topic::Mission,
            Self::State(_) => Topic::State,
            Self::Health => Topic::Health,
            Self::StepBegan | Self::StepEnded | Self::Placed => Topic::Step,
            Self::Faults => Topic::Faults,
            Self::BusOff => Topic::BusOff,
        }
    }
}

#[derive(Debug, Clone)]
enum BaseEars {
    None,
    Can,
    Serial(Box<SerialEars>),
}

#[derive(Debug, Clone, Default)]
struct SerialEars {
    /// The base's decoder of what the controller sends, and of what has come through the line.
    sent: Device,
    carried: Device,
    /// The controller's decoder of the replies.
    host: Host,
}

/// The current state of knowledge.
#[derive(Debug, Clone)]
pub(super) struct Senses {
    pub(super) now: Timestamp,
    pub(super) truth: Option<Truth>,
    /// When the controller last received a good gyro sample.
    pub(super) gyro_heard: Option<Timestamp>,
    /// When the controller last received the base's motion.
    pub(super) base_heard: Option<Timestamp>,
    pub(super) health: Health,
    pub(super) source: HeadingSource,
    pub(super) faults: usize,
    /// What faults hide from the controller.
    pub(super) hidden: Hidden,
    /// The [truth](Self::truth) is that of the inputs.
    apparent: bool,
    /// The last motion of the base.
    motion: Option<Motion>,
    gyro: GyroDecoder,
    base: BaseEars,
    orders: VecDeque<(MissionId, Order)>,
}

impl Senses {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            now: Timestamp::ZERO,
            truth: None,
            gyro_heard: None,
            base_heard: None,
            health: Health::default(),
            source: HeadingSource::default(),
            faults: 0,
            hidden: Hidden::default(),
            apparent: false,
            motion: None,
            gyro: GyroDecoder::new(limits.gyro),
            base: match limits.base.map(|base| base.transport) {
                None => BaseEars::None,
                Some(Transport::Can) => BaseEars::Can,
                Some(Transport::Serial) => BaseEars::Serial(Box::default()),
            },
            orders: VecDeque::new(),
        }
    }

    /// Number of times that the gyro's decoder resynchronised.
    pub(super) const fn resyncs(&self) -> u64 {
        self.gyro.counters().resyncs
    }

    /// The controller reports that odometry bridges a silent gyro, and is permitted to.
    pub(super) fn is_bridged(&self) -> bool {
        self.health.causes.bridging
            && self.gyro_heard.is_some_and(|heard| self.now - heard <= BRIDGED_MAX)
    }

    /// Whether the base truly moves.
    pub(super) fn is_moving(&self) -> bool {
        self.truth.is_some_and(|truth| truth.is_moving())
    }

    /// Takes an event at `now` and appends its facts to `facts`.
    pub(super) fn take(&mut self, now: Timestamp, seen: &Seen<'_>, facts: &mut Vec<Fact>) {
        self.now = now;
        match seen {
            Seen::Truth(truth) => {
                self.truth = Some(*truth);
                let heard = |within| self.base_heard.is_some_and(|heard| now - heard <= within);
                let new = self.motion.filter(|_| heard(HEARD_JUST_NOW));
                let rests = self.motion.is_some_and(|motion| !motion.moving) && heard(RESTS_FOR);
                self.hidden.truth(now, truth, (new.map(|motion| motion.heading), rests));
                facts.push(Fact::Truth);
            }
            Seen::GyroBytes(bytes) => {
                let heard = &mut self.gyro_heard;
                self.gyro.feed(bytes, |sample| {
                    if is_good(&sample) {
                        *heard = Some(now);
                    }
                });
                facts.push(Fact::Gyro);
            }
            Seen::BaseBytes(bytes) => {
                let BaseEars::Serial(ears) = &mut self.base else { return };
                let mut motion: Option<Motion> = None;
                ears.host.feed(bytes, |event| {
                    if let HostEvent::Reply(Reply::Motion(heard)) = event {
                        motion = Some(heard);
                    }
                });
                self.motion(now, motion, facts);
            }
            Seen::BaseFrame(frame) => match can_link::parse_reply(frame) {
                Some(Reply::Motion(motion)) => self.motion(now, Some(motion), facts),
                Some(Reply::Pose(_)) | None => {}
            },
            Seen::Told(mission) => {
                let order = Order::of(&mission.command);
                if self.orders.len() == ORDERS_MAX {
                    self.orders.pop_front();
                }
                self.orders.push_back((mission.id, order));
                facts.push(Fact::Told(mission.id, order));
            }
            Seen::Sent(output) => self.sent(output, facts),
            Seen::Report(report) => self.report(report, facts),
            Seen::StepBegan => facts.push(Fact::StepBegan),
            Seen::StepEnded => facts.push(Fact::StepEnded),
            Seen::Placed => {
                self.hidden.placed();
                facts.push(Fact::Placed);
            }
            Seen::Faults(active) => {
                self.faults = *active;
                facts.push(Fact::Faults);
            }
            Seen::Carried(what) => self.carried(what),
            Seen::Misheard => self.hidden.hears(true),
            Seen::BusOff => facts.push(Fact::BusOff),
            Seen::Message { .. } => {}
        }
    }

    fn motion(&mut self, now: Timestamp, motion: Option<Motion>, facts: &mut Vec<Fact>) {
        if motion.is_some() {
            (self.base_heard, self.motion) = (Some(now), motion);
            self.hidden.hears(false);
            facts.push(Fact::Motion);
        }
    }

    fn sent(&mut self, output: &Output, facts: &mut Vec<Fact>) {
        match (output, &mut self.base) {
            (Output::Frame(frame), _) => {
                if let Some(request) = can_link::parse_request(frame) {
                    self.hidden.sent(self.now, request);
                    facts.push(Fact::Request(request));
                }
            }
            (Output::Bytes(Port::Base, packet), BaseEars::Serial(ears)) => {
                let (now, hidden) = (self.now, &mut self.hidden);
                let SerialEars { sent, host, .. } = &mut **ears;
                sent.feed(packet.as_slice(), |event| {
                    let request = match event {
                        DeviceEvent::Write { request, .. } => request,
                        DeviceEvent::Read(_) => Request::ReadMotion,
                        DeviceEvent::Refused(_) => return,
                    };
                    hidden.sent(now, request);
                    // The controller begins an exchange only after it has finished the previous one.
                    host.abandon();
                    let _ = host.start(&request);
                    facts.push(Fact::Request(request));
                });
            }
            _ => {}
        }
    }

    fn carried(&mut self, what: &Transmit) {
        let (now, hidden) = (self.now, &mut self.hidden);
        match (what, &mut self.base) {
            (Transmit::Frame(frame), BaseEars::Can) => {
                if let Some(request) = can_link::parse_request(frame) {
                    hidden.carried(now, request);
                }
            }
            (Transmit::Bytes(packet), BaseEars::Serial(ears)) => {
                ears.carried.feed(packet.as_slice(), |event| {
                    if let DeviceEvent::Write { request, .. } = event {
                        hidden.carried(now, request);
                    }
                });
            }
            _ => {}
        }
    }

    /// Exchanges the real world for the one that the inputs show while `look` looks.
    pub(super) fn in_apparent(&mut self, look: impl FnOnce(&Self)) {
        let real = self.truth;
        (self.truth, self.apparent) = (self.hidden.apparent().or(real), true);
        look(self);
        (self.truth, self.apparent) = (real, false);
    }

    /// In the world of the inputs: the base obeys an order that the controller did not give, or has withdrawn.
    pub(super) fn is_astray(&self) -> bool {
        self.apparent && self.hidden.is_astray()
    }

    /// Or speeds up and brakes by ramps that it did not give.
    pub(super) fn has_stray_ramps(&self) -> bool {
        self.apparent && self.hidden.has_stray_ramps()
    }

    /// In the world of the inputs: how long the velocity that the base obeys was on its way, if that is unusual.
    pub(super) fn order_late(&self) -> Span {
        if self.apparent { self.hidden.order_late() } else { Span::ZERO }
    }

    /// In the world of the inputs: a message of the base that was changed on its way is believed.
    pub(super) fn is_misheard(&self) -> bool {
        self.apparent && self.hidden.is_misheard()
    }

    /// The motion of the base, if it was heard at `now`.
    pub(super) fn motion_heard(&self, now: Timestamp) -> Option<Motion> {
        self.motion.filter(|_| self.base_heard == Some(now))
    }

    fn report(&mut self, report: &Report, facts: &mut Vec<Fact>) {
        let id = match report {
            Report::State(state) => {
                // A controller may tell its health by its states alone.
                if state.health != self.health {
                    self.health = state.health;
                    facts.push(Fact::Health);
                }
                facts.push(Fact::State(*state));
                return;
            }
            Report::Health(health) => {
                self.health = *health;
                facts.push(Fact::Health);
                return;
            }
            Report::Refused { id, .. } | Report::Done { id, .. } | Report::Aborted { id, .. } => {
                *id
            }
        };
        let place = self.orders.iter().position(|(told, _)| *told == id);
        let order = place.and_then(|place| self.orders.remove(place));
        let order = order.map_or(Order::Other, |(_, order)| order);
        if let (Order::Source(source), Report::Done { .. }) = (order, report) {
            self.source = source;
        }
        if let (Order::Setting, Report::Done { .. }) = (order, report) {
            self.hidden.pose_is_set();
        }
        facts.push(Fact::Answered(id, order, *report));
    }
}

impl Truth {
    /// Whether it drives or steers.
    pub(super) fn is_moving(&self) -> bool {
        self.speed.m_per_s() != 0.0 || self.steer_rate.rad_per_s() != 0.0
    }
}

impl Order {
    fn of(command: &Command) -> Self {
        match command {
            Command::Straight(straight) => Self::Straight(straight.distance),
            Command::Turn(turn) => Self::Turn(turn.angle),
            Command::Stop => Self::Stop,
            Command::BiasTest(_) => Self::BiasTest,
            Command::SetHeadingSource(source) => Self::Source(*source),
            Command::SetPose(_) | Command::SetCalibration(_) => Self::Setting,
            _ => Self::Other,
        }
    }
}

/// Whether the sample may be integrated.
fn is_good(sample: &GyroSample) -> bool {
    let finite = match sample.output {
        GyroOutput::Rate(rate) => rate.is_finite(),
        GyroOutput::Increment(angle) | GyroOutput::Integrated(angle) => angle.is_finite(),
    };
    sample.valid && !sample.status.built_in_test_failed && finite
}
