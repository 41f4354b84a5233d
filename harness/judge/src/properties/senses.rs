//! Interprets events: decodes bytes, and remembers orders until they are answered.

use super::Limits;
use super::limits::BRIDGED_MAX;
use super::seen::{Seen, Truth};
use controller::config::Transport;
use controller::health::Health;
use controller::mission::{Command, HeadingSource, MissionId, Report, State};
use controller::{Output, Port};
use std::collections::VecDeque;
use wire::base::serial_link::{Device, DeviceEvent, Host, HostEvent};
use wire::base::{Motion, Reply, Request, can_link};
use wire::gyro::{GyroDecoder, GyroOutput, GyroSample};
use wire::time::Timestamp;
use wire::units::{Angle, Length};

/// Missions that wait for an answer; the oldest is dropped first. The controller answers at once or runs one mission,
/// so more means that it does not answer.
const ORDERS_MAX: usize = 64;

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
    LapBegan,
    LapEnded,
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
    Lap,
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
            Self::LapBegan | Self::LapEnded | Self::Placed => Topic::Lap,
            Self::Faults => Topic::Faults,
            Self::BusOff => Topic::BusOff,
        }
    }
}

#[derive(Debug, Clone)]
enum BaseEars {
    None,
    Can,
    /// The base's decoder, and the controller's decoder of its replies.
    Serial(Device, Host),
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
    /// The first fault that has begun and that no input of the controller shows, and when.
    pub(super) unseen: Option<(&'static str, Timestamp)>,
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
            unseen: None,
            gyro: GyroDecoder::new(limits.gyro),
            base: match limits.base.map(|base| base.transport) {
                None => BaseEars::None,
                Some(Transport::Can) => BaseEars::Can,
                Some(Transport::Serial) => BaseEars::Serial(Device::default(), Host::default()),
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
                let BaseEars::Serial(_, host) = &mut self.base else { return };
                let mut motion: Option<Motion> = None;
                host.feed(bytes, |event| {
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
            Seen::LapBegan => facts.push(Fact::LapBegan),
            Seen::LapEnded => facts.push(Fact::LapEnded),
            Seen::Placed => facts.push(Fact::Placed),
            Seen::Faults { active, unseen } => {
                self.faults = *active;
                self.unseen = self.unseen.or(unseen.map(|fault| (fault, now)));
                facts.push(Fact::Faults);
            }
            Seen::BusOff => facts.push(Fact::BusOff),
            Seen::Message { .. } => {}
        }
    }

    fn motion(&mut self, now: Timestamp, motion: Option<Motion>, facts: &mut Vec<Fact>) {
        if motion.is_some() {
            self.base_heard = Some(now);
            facts.push(Fact::Motion);
        }
    }

    fn sent(&mut self, output: &Output, facts: &mut Vec<Fact>) {
        match (output, &mut self.base) {
            (Output::Frame(frame), _) => {
                facts.extend(can_link::parse_request(frame).map(Fact::Request));
            }
            (Output::Bytes(Port::Base, packet), BaseEars::Serial(device, host)) => {
                device.feed(packet.as_slice(), |event| {
                    let request = match event {
                        DeviceEvent::Write { request, .. } => request,
                        DeviceEvent::Read(_) => Request::ReadMotion,
                        DeviceEvent::Refused(_) => return,
                    };
                    // The controller begins an exchange only after it has finished the previous one.
                    host.abandon();
                    let _ = host.start(&request);
                    facts.push(Fact::Request(request));
                });
            }
            _ => {}
        }
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
