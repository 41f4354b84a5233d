//! A device of the user's own in real time: a real one at a port, or the emulated one at a port that the plan opens at its
//! other end.
//!
//! | device | the harness has |
//! |---|---|
//! | real | the port that it is at |
//! | emulated | both ends of a pty or of an adapter that is played here, or two sockets on one interface |

use super::clock::Clock;
use super::journal::Journal;
use super::lateness::{Course, Lateness};
use super::placement::{Player, far_spec};
use super::realtime::{self, Scheduling};
use super::role_port::{PortEvent, RolePort, Traffic, next};
use super::setting::LiveError;
use super::verdict::{LiveEnd, blame_bench};
use super::{Awaited, PULSE_PERIOD};
use crate::engine::{Ending, Engine};
use crate::operator::Operator;
use crate::outcome::{Outcome, PortSide, PortSummary};
use crate::plan::Plan;
use crate::port::PortSpec;
use crate::record::Progress;
use crate::record::sink::RecordSink;
use crate::record::{Device, Record, RecordKind};
use crate::world::described::{DeviceStage, Emulated, End, record as record_crossed};
use crate::world::simulated::look_up;
use described::{Description, Medium};
use std::sync::Arc;
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

/// Name of the role.
pub(super) const DEVICE: &str = "device";
/// The emulated device's own end of its line; the other is the plan's.
const EMULATED: &str = "emulated device";
/// What is sent last has so long to leave. Assumption: a message of 64 bytes takes 67 ms at 9,600 baud.
const LAST_WORDS: Span = Span::from_millis(100);

/// Where and how a plan of a device is run in real time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceSetting {
    /// The device, and where it is.
    pub player: Player,
    /// How late the harness may be with anything.
    pub late_max: Span,
    /// What the scheduler is asked for.
    pub scheduling: Scheduling,
}

/// A device in real time.
#[derive(Debug)]
pub struct DescribedLive {
    stage: DeviceStage,
    medium: Medium,
    setting: DeviceSetting,
    journal: Journal,
    lateness: Lateness,
}

/// The ports of a run.
#[derive(Debug)]
struct Ends {
    plan: RolePort,
    device: Option<RolePort>,
}

impl Ends {
    async fn open(player: &Player, medium: Medium) -> Result<Self, LiveError> {
        let traffic = match medium {
            Medium::Can => Traffic::Frames,
            Medium::Serial(settings) => Traffic::Bytes(settings),
        };
        match player {
            Player::Real(spec) => {
                Ok(Self { plan: RolePort::open(spec, traffic).await?, device: None })
            }
            Player::Emulated(spec) => {
                let mut device = RolePort::open(spec, traffic).await?;
                let far = device.far_path().map(|path| far_spec(spec, path));
                let far = far.unwrap_or_else(|| spec.clone());
                // An adapter that is played here answers whoever opens it.
                let plan = {
                    let mut opening = std::pin::pin!(RolePort::open(&far, traffic));
                    loop {
                        tokio::select! {
                            plan = &mut opening => break plan?,
                            _ = device.next() => {}
                        }
                    }
                };
                Ok(Self { plan, device: Some(device) })
            }
        }
    }

    async fn next(&mut self) -> (&'static str, PortEvent) {
        tokio::select! {
            event = self.plan.next() => (DEVICE, event),
            event = next(self.device.as_mut()) => (EMULATED, event),
        }
    }
}

fn send(port: &mut RolePort, now: Timestamp, what: &Transmit) {
    match what {
        Transmit::Frame(frame) => port.send_frame(now, frame),
        Transmit::Bytes(packet) => port.send_bytes(packet.as_slice()),
    }
}

impl DescribedLive {
    /// A run of `plan`, random numbers from `seed`; `operator` answers what the plan asks a person.
    pub fn new(
        plan: Arc<Plan>,
        description: &Arc<Description>,
        operator: Operator,
        setting: DeviceSetting,
        seed: u64,
    ) -> Self {
        let is_emulated = matches!(setting.player, Player::Emulated(_));
        let emulated = is_emulated.then(|| Emulated::new(description, seed));
        Self {
            stage: DeviceStage::new(plan, description, emulated, operator, seed),
            medium: description.layout().medium(),
            journal: Journal::default(),
            lateness: Lateness::new(setting.late_max),
            setting,
        }
    }

    /// Everything observed is the engine's.
    pub const fn engine(&self) -> &Engine {
        &self.stage.engine
    }

    /// Runs the plan to its end.
    ///
    /// # Errors
    ///
    /// When a port cannot be opened. A run that has begun ends with an outcome.
    pub fn run(
        &mut self,
        sink: &mut impl RecordSink,
        pulse: &mut impl FnMut(Progress) -> bool,
    ) -> Result<LiveEnd, LiveError> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        runtime.block_on(self.run_in_runtime(sink, pulse))
    }

    async fn run_in_runtime(
        &mut self,
        sink: &mut impl RecordSink,
        pulse: &mut impl FnMut(Progress) -> bool,
    ) -> Result<LiveEnd, LiveError> {
        let mut ends = Ends::open(&self.setting.player, self.medium).await?;
        let scheduling = realtime::ask(self.setting.scheduling);
        let clock = Clock::start();
        let (mut events, mut pulse_at, mut until) = (0, clock.now(), Timestamp::MAX);
        loop {
            let now = clock.now();
            events += 1;
            if now >= pulse_at {
                pulse_at = now + PULSE_PERIOD;
                look_up(&mut self.stage.engine, now, sink, pulse);
                self.stage.listen_to_operator(now, sink);
            }
            self.step(now, sink, &mut ends);
            self.lateness.reach(self.course());
            if self.stage.engine.is_ending() && until == Timestamp::MAX {
                self.lateness.break_off();
                until = now + LAST_WORDS;
            }
            if now >= until {
                break;
            }
            let due = self.stage.next_due().min(pulse_at).min(until);
            let awaited = tokio::select! {
                () = clock.sleep_until(due) => Awaited::Due,
                (role, event) = ends.next() => Awaited::Port(role, event),
            };
            let then = clock.now();
            if then >= due {
                self.lateness.add(then, then - due.max(now));
            }
            if let Awaited::Port(role, event) = awaited {
                self.hear(then, sink, &ends, role, event);
            }
        }
        let end = clock.now();
        self.lateness.end_step(self.course());
        let ending = self.judge(end);
        let faults = self.stage.finish(end, sink);
        if self.journal.unnoted() > 0 {
            let unnoted = self.journal.unnoted();
            note_down(sink, end, format!("{unnoted} more events of ports are not noted"));
        }
        Ok(LiveEnd {
            ending,
            end,
            events,
            timing: self.lateness.timing(None, scheduling),
            ports: self.port_summaries(&ends),
            dropped: self.stage.dropped(),
            faults,
            properties: Vec::new(),
            unjudged: Vec::new(),
        })
    }

    /// All that is to be done now.
    fn step(&mut self, now: Timestamp, sink: &mut impl RecordSink, ends: &mut Ends) {
        self.stage.strike(now, sink);
        if let (Some(emulated), Some(port)) = (&mut self.stage.emulated, &mut ends.device) {
            emulated.deliver(now, &mut |from, what| {
                if from != End::Host {
                    send(port, now, what);
                }
            });
        }
        self.stage.note_confinement(now, sink);
        self.stage.wake(now, sink);
        if let Some(emulated) = &mut self.stage.emulated {
            emulated.transmit(now);
        }
        while let Some(sent) = self.stage.tester.transmit() {
            record_crossed(sink, now, End::Host, &sent);
            send(&mut ends.plan, now, &sent);
        }
    }

    /// Takes what a port tells.
    fn hear(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        ends: &Ends,
        role: &'static str,
        event: PortEvent,
    ) {
        let what = match event {
            PortEvent::Bytes(packet) => Transmit::Bytes(packet),
            PortEvent::Frame(frame) => Transmit::Frame(frame),
            event => {
                let (port, side) = match (role, &ends.device) {
                    (EMULATED, Some(port)) => (port, PortSide::Bench),
                    _ => (&ends.plan, PortSide::Plan),
                };
                if let Some(note) = self.journal.take(now, (DEVICE, side), port.name(), &event) {
                    note_down(sink, now, note);
                }
                return;
            }
        };
        if role == EMULATED {
            if let Some(emulated) = &mut self.stage.emulated {
                emulated.receive(now, what);
            }
            return;
        }
        record_crossed(sink, now, End::Device, &what);
        self.stage.tester.hear(&what, now, &mut self.stage.engine);
    }

    /// The ending, with what the port and the machine have to do with it.
    fn judge(&self, end: Timestamp) -> Ending {
        let ended =
            Ending { outcome: Outcome::Error, reason: Some("the run did not end".to_owned()) };
        let ending = self.stage.engine.ending().cloned().unwrap_or(ended);
        let ending = self.journal.explain(ending, end);
        let late = self.lateness.verdict();
        let why = match ending.outcome {
            Outcome::Passed => late,
            Outcome::Failed | Outcome::Timeout => late.or(self.lateness.verdict_on_broken_step()),
            Outcome::Error | Outcome::Aborted => None,
        };
        match why {
            Some(why) => blame_bench(ending, &why),
            None => ending,
        }
    }

    fn port_summaries(&self, ends: &Ends) -> Vec<PortSummary> {
        let plan = self.journal.summary((DEVICE, PortSide::Plan), &ends.plan);
        let device = ends.device.as_ref();
        let device = device.map(|port| self.journal.summary((DEVICE, PortSide::Bench), port));
        [Some(plan), device].into_iter().flatten().collect()
    }

    fn course(&self) -> Course {
        let observations = self.stage.engine.observations().values().map(Vec::len).sum();
        Course { steps: self.stage.engine.progress().0, observations }
    }
}

fn note_down(sink: &mut impl RecordSink, at: Timestamp, note: String) {
    sink.record(Record { at, device: Device::Device, kind: RecordKind::Note(note) });
}

impl DeviceSetting {
    /// Can the faults of the plan be injected here?
    ///
    /// # Errors
    ///
    /// The first that cannot: the line of a real device is not the harness's.
    pub fn reaches(&self, plan: &Plan) -> Result<(), super::OutOfReach> {
        let (Player::Real(spec), Some(fault)) = (&self.player, plan.faults.faults.first()) else {
            return Ok(());
        };
        Err(super::OutOfReach {
            index: 0,
            name: fault.to_string(),
            why: format!("the device is real ({spec}): its line is not carried by the harness"),
            help: "emulate it: leave [device] out of the bench file, or the fault out of the plan"
                .to_owned(),
        })
    }
}

/// Where a port of this medium is that nobody has named.
pub(crate) fn usual_port(medium: Medium, can: &PortSpec) -> PortSpec {
    match medium {
        Medium::Can => can.clone(),
        Medium::Serial(_) => PortSpec::Pty { link: None },
    }
}
