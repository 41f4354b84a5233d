//! The live world: the real clock, ptys or real ports, the device under test in this process or in its
//! own.
//!
//! The emulated devices, the engine and the pacing of lines are those of the simulated world; here they
//! are asked when the real clock says so. Bytes cross a real tty: what the emulators send is written to
//! a pty once its line time has passed, what the device under test writes is read from there. A role
//! with a real port has no emulator: the device under test opens that port itself.
//!
//! Clock and select loop are the only ones in the harness.

mod device_under_test;

pub use device_under_test::DeviceUnderTest;
pub(crate) use device_under_test::our_program;

use super::bench::{Bench, Carrier};
use super::lines::BaseLink;
use super::simulated::Progress;
use super::stage::Stage;
use crate::engine::{Action, Ending, Engine};
use crate::operator::Operator;
use crate::port::pty::{Pty, PtyError};
use crate::record::Device;
use crate::record::sink::RecordSink;
use controller::config::Transport;
use device_under_test::{Heard, Running, StartError};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;
use tokio::time::Instant;
use wire::packet::{BYTES_MAX, Packet};
use wire::time::{Span, Timestamp};

/// Names of the roles that ports play.
pub const GYRO: &str = "gyro";
/// See [`GYRO`].
pub const BASE: &str = "base";

/// The device under test must be heard within this. Assumption: the slowest interpreter starts in 2 s.
const START_LIMIT: Span = Span::from_secs(10);
/// Between two looks beyond the world.
const PULSE_PERIOD: Span = Span::from_millis(100);

/// Why a live run cannot begin.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LiveError {
    /// The base is on CAN, which a pty is not.
    #[error("the plan's base is on CAN, and the live world has serial lines only")]
    #[diagnostic(help("choose a device file whose base has `transport = \"serial\"`"))]
    NoCan,
    /// No pty.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Pty(#[from] PtyError),
    /// The device under test does not start.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Start(#[from] StartError),
    /// No runtime for the select loop.
    #[error("failed to start the event loop: {0}")]
    Runtime(#[from] std::io::Error),
}

/// What a live run ended with.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveEnd {
    /// How the plan ended.
    pub ending: Ending,
    /// Bench time at the end.
    pub end: Timestamp,
    /// Times that the loop went round.
    pub events: u64,
    /// Longest time by which something was done too late.
    pub late_max: Span,
    /// Bytes that a pty had no room for.
    pub overrun_bytes: u64,
}

/// A bench in real time.
#[derive(Debug)]
pub struct LiveWorld {
    stage: Stage,
    device_under_test: DeviceUnderTest,
    /// Real ports by role.
    ports: BTreeMap<String, String>,
}

impl LiveWorld {
    /// A live world; `ports` are real ports by role ([`GYRO`], [`BASE`]), `operator` answers what the plan
    /// asks a person.
    ///
    /// # Errors
    ///
    /// When the bench needs a CAN bus.
    pub fn new(
        bench: Bench,
        engine: Engine,
        operator: Operator,
        device_under_test: DeviceUnderTest,
        ports: BTreeMap<String, String>,
    ) -> Result<Self, LiveError> {
        if bench.base_transport() == Some(Transport::Can) && !ports.contains_key(BASE) {
            return Err(LiveError::NoCan);
        }
        let mut stage = Stage::new(bench, engine);
        stage.operator = operator;
        Ok(Self { stage, device_under_test, ports })
    }

    /// Everything observed and made is the engine's.
    pub const fn engine(&self) -> &Engine {
        &self.stage.engine
    }

    /// Runs the plan to its end. What the device under test writes to stderr goes into `log`.
    ///
    /// # Errors
    ///
    /// When the run cannot begin. Once begun it ends with an outcome.
    pub fn run(
        &mut self,
        log: &Path,
        sink: &mut impl RecordSink,
        keep: &mut impl FnMut(&Action),
        pulse: &mut impl FnMut(Progress) -> bool,
    ) -> Result<LiveEnd, LiveError> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        runtime.block_on(self.run_in_runtime(log, sink, keep, pulse))
    }

    async fn run_in_runtime(
        &mut self,
        log: &Path,
        sink: &mut impl RecordSink,
        keep: &mut impl FnMut(&Action),
        pulse: &mut impl FnMut(Progress) -> bool,
    ) -> Result<LiveEnd, LiveError> {
        let emulated = |role: &str| !self.ports.contains_key(role);
        let mut gyro = if emulated(GYRO) { Some(Pty::open()?) } else { None };
        let with_base = self.stage.bench.base_transport().is_some();
        let mut base = if with_base && emulated(BASE) { Some(Pty::open()?) } else { None };
        let mut ports = self.ports.clone();
        let opened = [(GYRO, &gyro), (BASE, &base)];
        ports.extend(
            opened
                .into_iter()
                .filter_map(|(role, pty)| Some((role.to_owned(), pty.as_ref()?.path().to_owned()))),
        );
        let clock = Clock::start();
        let config = self.stage.bench.controller_config();
        let mut device = Running::start(&self.device_under_test, config, &ports, log)?;
        let mut late_max = Span::ZERO;
        let mut heard_any = false;
        let (mut events, mut pulse_at) = (0, Timestamp::ZERO);
        let (mut from_gyro_port, mut from_base_port) = ([0; BYTES_MAX], [0; BYTES_MAX]);

        let ending = loop {
            let now = clock.now();
            events += 1;
            if now >= pulse_at {
                pulse_at = now + PULSE_PERIOD;
                self.look_up(now, sink, pulse);
                if !heard_any && now - Timestamp::ZERO > START_LIMIT {
                    let why = format!(
                        "the device under test said nothing within {} s{}",
                        START_LIMIT.as_secs_f64(),
                        device.last_words(),
                    );
                    self.stage.engine.broke(now, &why);
                }
            }
            self.deliver(now, sink, gyro.as_mut(), base.as_mut());
            self.wake(now, gyro.is_some());
            device.wake(now);
            self.transmit(now, sink, keep, &mut device);
            if let Some(ending) = self.stage.engine.ending() {
                break ending.clone();
            }
            let due = self.next_due(gyro.is_some()).min(device.next_wakeup()).min(pulse_at);
            tokio::select! {
                () = clock.sleep_until(due) => {
                    late_max = late_max.max(clock.now() - due.max(now));
                }
                count = read(gyro.as_ref(), &mut from_gyro_port) => {
                    let now = clock.now();
                    if let Some(bytes) = packets(&from_gyro_port, count) {
                        self.stage.lines.gyro_commands.send(now, bytes);
                    }
                }
                count = read(base.as_ref(), &mut from_base_port) => {
                    let now = clock.now();
                    if let BaseLink::Serial { to_base, .. } = &mut self.stage.lines.base
                        && let Some(bytes) = packets(&from_base_port, count)
                    {
                        to_base.send(now, bytes);
                    }
                }
                heard = device.heard(&clock) => {
                    let now = clock.now();
                    match heard {
                        Heard::Report(report) => {
                            heard_any = true;
                            self.stage.record_report(now, sink, &report);
                            self.stage.engine.report(now, &report);
                        }
                        Heard::Nothing => {}
                        Heard::BadLine(what) => self.stage.note(now, sink, what),
                        Heard::Ended(how) => self.stage.engine.lost_controller(now, &how),
                    }
                }
            }
        };
        let end = clock.now();
        device.end().await;
        let overrun = |pty: &Option<Pty>| pty.as_ref().map_or(0, Pty::overrun_bytes);
        let overrun_bytes = overrun(&gyro) + overrun(&base);
        Ok(LiveEnd { ending, end, events, late_max, overrun_bytes })
    }

    /// Does anybody want the run to stop, does the disk still take the record, has a person said something?
    fn look_up(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        pulse: &mut impl FnMut(Progress) -> bool,
    ) {
        let (steps_done, steps) = self.stage.engine.progress();
        if !pulse(Progress { now, steps_done, steps }) {
            self.stage.engine.abort(now);
        }
        if let Some(error) = sink.failed() {
            self.stage.engine.broke(now, &format!("failed to write the record: {error}"));
        }
        self.stage.listen_to_operator(now, sink);
    }

    /// Hands over what has passed its line by now.
    fn deliver(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        gyro: Option<&mut Pty>,
        base: Option<&mut Pty>,
    ) {
        // The gyro's outputs first, each at its own instant: they must not see what the base does later.
        self.stage.wake_gyro(now);
        while let Some(packet) = self.stage.lines.gyro_commands.arrived(now) {
            sink.bytes(now, Device::Controller, packet.as_slice());
            self.stage.bench.gyro.receive(now, packet.as_slice());
        }
        if let Some(pty) = gyro {
            while let Some(packet) = self.stage.lines.gyro.arrived(now) {
                sink.bytes(now, Device::Gyro, packet.as_slice());
                pty.write(packet.as_slice());
            }
        }
        let Stage { lines, bench, .. } = &mut self.stage;
        if let (BaseLink::Serial { to_base, to_controller }, Carrier::Base(emulator), Some(pty)) =
            (&mut lines.base, &mut bench.carrier, base)
        {
            while let Some(packet) = to_base.arrived(now) {
                sink.bytes(now, Device::Controller, packet.as_slice());
                emulator.receive_bytes(now, packet.as_slice());
            }
            while let Some(packet) = to_controller.arrived(now) {
                sink.bytes(now, Device::Base, packet.as_slice());
                pty.write(packet.as_slice());
            }
        }
        self.stage.deliver_table(now, sink);
    }

    fn wake(&mut self, now: Timestamp, gyro_emulated: bool) {
        if !gyro_emulated {
            // Nobody listens to an emulator whose role a real port plays.
            while self.stage.lines.gyro.arrived(Timestamp::MAX).is_some() {}
        }
        if self.stage.bench.carrier.next_wakeup() <= now {
            self.stage.bench.carrier.wake(now);
        }
        if self.stage.engine.next_wakeup() <= now {
            self.stage.engine.wake(now);
        }
    }

    fn transmit(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        keep: &mut impl FnMut(&Action),
        device: &mut Running,
    ) {
        loop {
            let mut quiet = true;
            while let Some(sent) = self.stage.bench.carrier.transmit() {
                self.stage.carry(now, sent);
            }
            while let Some(action) = self.stage.engine.action() {
                quiet = false;
                if let Some(mission) = self.stage.act(now, sink, keep, action)
                    && !device.command(now, mission)
                {
                    self.stage.engine.lost_controller(now, "it takes no more missions");
                }
            }
            if quiet {
                return;
            }
        }
    }

    fn next_due(&self, gyro_emulated: bool) -> Timestamp {
        let gyro = if gyro_emulated { self.stage.bench.gyro.next_wakeup() } else { Timestamp::MAX };
        self.stage
            .lines
            .next_arrival()
            .min(gyro)
            .min(self.stage.bench.carrier.next_wakeup())
            .min(self.stage.engine.next_wakeup())
    }
}

/// Bytes from the other side of a pty; without one, never.
async fn read(pty: Option<&Pty>, buffer: &mut [u8; BYTES_MAX]) -> usize {
    match pty {
        // An error of a pty whose both sides we hold open is none that a retry could not meet.
        Some(pty) => pty.read(buffer).await.unwrap_or(0),
        None => std::future::pending().await,
    }
}

fn packets(buffer: &[u8; BYTES_MAX], count: usize) -> Option<Packet> {
    Packet::from_slice(buffer.get(..count)?).filter(|packet| !packet.is_empty())
}

/// The real clock, zero when the run began.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    began: Instant,
}

impl Clock {
    #[expect(clippy::disallowed_methods, reason = "the live world is where the real clock is read")]
    pub(crate) fn start() -> Self {
        Self { began: Instant::now() }
    }

    pub(crate) fn now(&self) -> Timestamp {
        let nanos = self.began.elapsed().as_nanos();
        Timestamp::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
    }

    pub(crate) async fn sleep_until(&self, at: Timestamp) {
        let nanos = u64::try_from(at.as_nanos()).unwrap_or(0);
        tokio::time::sleep_until(self.began + Duration::from_nanos(nanos)).await;
    }
}
