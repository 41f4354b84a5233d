//! Hand-made events for a monitor.

use crate::properties::{Limits, Monitor, PropertyVerdict, Seen, Truth};
use controller::Output;
use controller::config::{BaseConfig, Config, GyroConfig, MotionConfig, Transport};
use controller::health::{Causes, Health};
use controller::mission::{Activity, Command, Mission, MissionId, Report, State};
use wire::base::{Motion, Reply, Request, can_link};
use wire::gyro::{GyroEncoder, GyroOutput, GyroSample, GyroStatus};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Length, Pose, Speed};

/// A monitor with a clock and short methods for its events.
pub(super) struct Scene {
    pub(super) monitor: Monitor,
    encoder: GyroEncoder,
    health: Health,
    pub(super) now: Timestamp,
}

impl Scene {
    pub(super) fn new() -> Self {
        let gyro = GyroConfig::default();
        let base = BaseConfig::new(Transport::Can);
        let limits = Limits::of(&Config::new(gyro, Some(base), MotionConfig::default()));
        Self {
            monitor: Monitor::new(&[], Some(&limits), &[]),
            encoder: GyroEncoder::new(gyro.stream),
            health: Health::default(),
            now: Timestamp::ZERO,
        }
    }

    pub(super) fn see(&mut self, seen: &Seen<'_>) -> &mut Self {
        self.monitor.see(self.now, seen);
        self
    }

    pub(super) fn after(&mut self, millis: i64) -> &mut Self {
        self.now += Span::from_millis(millis);
        self
    }

    pub(super) fn gyro(&mut self) -> &mut Self {
        let packet = self.encoder.encode(&GyroSample {
            output: GyroOutput::Rate(AngularRate::ZERO),
            valid: true,
            status: GyroStatus::default(),
            temperature: None,
            sequence: None,
        });
        self.see(&Seen::GyroBytes(packet.as_slice()))
    }

    pub(super) fn motion(&mut self) -> &mut Self {
        let frame = can_link::reply_frame(&Reply::Motion(Motion::default()));
        self.see(&Seen::BaseFrame(&frame))
    }

    pub(super) fn request(&mut self, request: &Request) -> &mut Self {
        let frame = can_link::request_frame(request).expect("it fits the wire");
        self.see(&Seen::Sent(&Output::Frame(frame)))
    }

    pub(super) fn velocity(&mut self, speed: f64) -> &mut Self {
        let drive = Speed::from_m_per_s(speed);
        self.request(&Request::SetVelocity { drive, steer: AngularRate::ZERO })
    }

    pub(super) fn truth(&mut self, heading_deg: f64, speed: f64) -> &mut Self {
        let pose = Pose { heading: Angle::from_deg(heading_deg), ..Pose::default() };
        let speed = Speed::from_m_per_s(speed);
        self.see(&Seen::Truth(Truth {
            pose,
            speed,
            wheels: speed,
            followed: (speed, AngularRate::ZERO),
            ..Truth::default()
        }))
    }

    pub(super) fn state(&mut self, heading_deg: f64, samples: u64) -> &mut Self {
        let heading = Angle::from_deg(heading_deg);
        let pose = Pose { heading, ..Pose::default() };
        let health = self.health;
        self.report(Report::State(State {
            pose,
            gyro_heading: heading,
            samples,
            health,
            ..state()
        }))
    }

    pub(super) fn health(&mut self, causes: Causes) -> &mut Self {
        self.health = Health::new(false, causes);
        self.report(Report::Health(self.health))
    }

    /// From now on, the states tell this health, and nothing else does.
    pub(super) fn health_by_states(&mut self, causes: Causes) -> &mut Self {
        self.health = Health::new(false, causes);
        self
    }

    pub(super) fn report(&mut self, report: Report) -> &mut Self {
        self.see(&Seen::Report(&report))
    }

    pub(super) fn tell(&mut self, id: MissionId, command: Command) -> &mut Self {
        self.see(&Seen::Told(&Mission { id, command }))
    }

    pub(super) fn verdict(self, name: &str) -> PropertyVerdict {
        let verdicts = self.monitor.verdicts(self.now);
        verdicts.into_iter().find(|verdict| verdict.name == name).expect("all are judged")
    }
}

pub(super) fn state() -> State {
    State {
        activity: Activity::Idle,
        pose: Pose::default(),
        gyro_heading: Angle::ZERO,
        odometry_heading: Angle::ZERO,
        displacement: Length::ZERO,
        heading_error: None,
        raw_rate: AngularRate::ZERO,
        bias: AngularRate::ZERO,
        temperature: None,
        moving: false,
        samples: 0,
        samples_lost: 0,
        clock_ratio: None,
        health: Health::default(),
        uncertainty: None,
    }
}
