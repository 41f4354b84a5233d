//! A heading unit: it integrates the samples of a KVH DSP-3000, subtracts the bias measured at rest, and reports lost
//! samples.
//!
//! It knows nothing of the harness except [`HostedController`], which its tests need. In your own project that
//! implementation belongs in the tests, and calls what the firmware calls.

use harness::HostedController;
use harness::controller::config::Config;
use harness::controller::health::{Causes, Health, Level};
use harness::controller::mission::{
    Activity, BiasTestResult, Command, Mission, MissionId, MissionResult, Refusal, Report, State,
};
use harness::controller::{Input, Output, Port};
use harness::wire::gyro::{GyroDecoder, GyroOutput, GyroStream, dsp3000_command};
use harness::wire::time::{Span, Timestamp};
use harness::wire::units::{Angle, AngularRate, Length, Pose};
use std::collections::VecDeque;

/// A larger gap between two samples means that one was lost: one and a half periods.
const GAP_MAX: Span = Span::from_millis(15);
/// Period of unprompted state reports.
const STATE_PERIOD: Span = Span::from_secs(1);

/// A bias test in progress.
#[derive(Debug, Default)]
struct BiasTest {
    id: MissionId,
    until: Timestamp,
    sum: f64,
    sum_of_squares: f64,
    samples: u32,
}

/// The unit.
#[derive(Debug)]
pub struct HeadingUnit {
    stream: GyroStream,
    decoder: GyroDecoder,
    /// Command to the gyro: send increments.
    command: Option<Output>,
    heading: Angle,
    /// Bias of one sample.
    bias: Angle,
    test: Option<BiasTest>,
    heard_at: Option<Timestamp>,
    samples: u64,
    gaps: u64,
    state_at: Timestamp,
    reports: VecDeque<Report>,
}

impl HeadingUnit {
    /// A unit without any input yet.
    pub fn new(config: &Config) -> Self {
        let stream = config.gyro.stream;
        let command = dsp3000_command::Command::Output(stream.mode).encode();
        Self {
            stream,
            decoder: GyroDecoder::new(stream),
            command: Some(Output::Bytes(Port::Gyro, command)),
            heading: Angle::ZERO,
            bias: Angle::ZERO,
            test: None,
            heard_at: None,
            samples: 0,
            gaps: 0,
            state_at: Timestamp::ZERO + STATE_PERIOD,
            reports: VecDeque::new(),
        }
    }

    fn hear(&mut self, now: Timestamp, increment: Angle) {
        let late = self.heard_at.is_some_and(|heard_at| now - heard_at > GAP_MAX);
        self.heard_at = Some(now);
        self.samples += 1;
        self.heading += increment - self.bias;
        if let Some(test) = &mut self.test {
            test.sum += increment.rad();
            test.sum_of_squares += increment.rad() * increment.rad();
            test.samples += 1;
        }
        if late {
            self.gaps += 1;
            self.reports.push_back(Report::Health(self.health()));
        }
    }

    fn health(&self) -> Health {
        let lost = self.gaps > 0;
        Health {
            level: if lost { Level::Degraded } else { Level::Ok },
            causes: Causes { samples_lost: lost, ..Causes::default() },
        }
    }

    fn rate(&self, of_a_sample: f64) -> AngularRate {
        AngularRate::from_rad_per_s(of_a_sample / self.stream.format.period().as_secs_f64())
    }

    fn state(&self) -> State {
        State {
            activity: if self.test.is_some() { Activity::BiasTest } else { Activity::Idle },
            pose: Pose { heading: self.heading, ..Pose::default() },
            gyro_heading: self.heading,
            odometry_heading: Angle::ZERO,
            displacement: Length::from_m(0.0),
            heading_error: None,
            raw_rate: AngularRate::ZERO,
            bias: self.rate(self.bias.rad()),
            temperature: None,
            moving: false,
            samples: self.samples,
            samples_lost: self.gaps,
            clock_ratio: None,
            health: self.health(),
            uncertainty: None,
        }
    }

    /// The mean sample at rest becomes the bias.
    fn finish(&mut self, test: &BiasTest) {
        if test.samples == 0 {
            self.reports.push_back(Report::Refused { id: test.id, reason: Refusal::NoGyro });
            return;
        }
        let count = f64::from(test.samples);
        let mean = test.sum / count;
        let variance = (test.sum_of_squares / count - mean * mean).max(0.0);
        self.bias = Angle::from_rad(mean);
        // Earlier losses do not matter any more.
        self.gaps = 0;
        let result = BiasTestResult {
            mean: self.rate(mean),
            spread: self.rate(variance.sqrt()),
            samples: test.samples,
            temperature: None,
            table: None,
        };
        let result = MissionResult::BiasTest(result);
        self.reports.push_back(Report::Done { id: test.id, result });
    }
}

impl HostedController for HeadingUnit {
    fn receive(&mut self, now: Timestamp, port: Port, input: Input<'_>) {
        let (Port::Gyro, Input::Bytes(bytes)) = (port, input) else { return };
        let mut heard = Vec::new();
        self.decoder.feed(bytes, |sample| match sample.output {
            GyroOutput::Increment(increment) if sample.valid => heard.push(increment),
            _ => {}
        });
        for increment in heard {
            self.hear(now, increment);
        }
    }

    fn command(&mut self, now: Timestamp, mission: Mission) {
        let id = mission.id;
        let result = MissionResult::Applied;
        match mission.command {
            Command::BiasTest(order) if self.test.is_none() => {
                let until = now + Span::from_secs_f64(order.duration_s);
                self.test = Some(BiasTest { id, until, ..BiasTest::default() });
            }
            Command::BiasTest(_) => {
                self.reports.push_back(Report::Refused { id, reason: Refusal::Busy });
            }
            Command::RequestState => {
                self.reports.push_back(Report::State(self.state()));
                self.reports.push_back(Report::Done { id, result });
            }
            Command::Stop => self.reports.push_back(Report::Done { id, result }),
            // It carries nothing that could move, and has only one kind of bias.
            _ => self.reports.push_back(Report::Refused { id, reason: Refusal::NoBase }),
        }
    }

    fn wake(&mut self, now: Timestamp) {
        if let Some(test) = self.test.take_if(|test| test.until <= now) {
            self.finish(&test);
        }
        if now >= self.state_at {
            self.state_at = now + STATE_PERIOD;
            self.reports.push_back(Report::State(self.state()));
        }
    }

    fn next_wakeup(&self) -> Timestamp {
        self.test.as_ref().map_or(self.state_at, |test| test.until.min(self.state_at))
    }

    fn transmit(&mut self, _: Timestamp) -> Option<Output> {
        self.command.take()
    }

    fn report(&mut self) -> Option<Report> {
        self.reports.pop_front()
    }
}
