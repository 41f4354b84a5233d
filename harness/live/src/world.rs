//! The live world: the real clock, ptys or real ports, and the device under test in this process, in its own process,
//! or running already.
//!
//! Emulated devices, engine and line pacing are those of the simulated world, here driven by the real clock. Bytes and
//! frames go through the kernel: what an emulated device sends goes to its port once its line time has passed, and what
//! arrives there is put on its line. A role with a real port has no emulator: the device under test opens that port
//! itself.
//!
//! | role | emulated | real |
//! |---|---|---|
//! | gyro, base | the harness has the near end of the port, the device under test the far one | the device under test has the port; on a bus of the kernel the harness listens |
//! | table | within the harness, or with both ends of a pty there | the harness has the port |
//!
//! Faults strike emulated devices and the lines up to their ports ([`Setting::reaches`]); properties are judged by what
//! the bench shows ([`Setting::sight`]).
//!
//! A port that goes away is awaited as long as the plan's limits allow. Clock and select loop are the only ones in the
//! harness.

mod bench_work;
mod clock;
mod commands;
mod device_under_test;
mod error;
mod eyes;
mod flood;
mod heard;
mod histogram;
mod in_process;
mod journal;
mod lateness;
mod losses;
mod machine_watch;
mod placement;
pub mod ports;
mod programs;
mod realtime;
pub(crate) mod role_port;
mod setting;
mod strike;
mod talk;
mod traffic;
mod verdict;

pub use bench_work::{BenchWork, NoCommand};
pub use device_under_test::DeviceUnderTest;
#[cfg(feature = "programs")]
pub use device_under_test::controller_words;
pub use device_under_test::our_program;
pub use error::{LiveError, StartError};
pub use lateness::LATE_MAX_DEFAULT;
pub use placement::{Placement, PlacementError, Player, line_port, player, usual_port};
pub use ports::{BASE, GYRO, PortPlan, PortPlans, TABLE, base_traffic};
pub use programs::Program;
pub use realtime::Scheduling;
pub use role_port::Traffic;
pub use setting::{LineSite, OutOfReach, Setting, Site, Unfit};
pub use verdict::LiveEnd;

use self::ports::Ports;
use crate::lines;
use ::ports::PortError;
pub use clock::{Alarm, Clock, SPIN_MAX};
use commands::Commands;
use controller::config::Config;
use device_under_test::Running;
use eyes::{Ear, Eyes};
use flood::FloodWatch;
use heard::Heard;
use journal::Journal;
use judge::properties::{Limits, Property, View};
use lateness::{Course, Lateness};
use machine_watch::MachineWatch;
use plan::Speaker;
use programs::Programs;
use record::Device;
use rig::Rig;
use rig::director::Director;
use rig::ended::Ended;
use rig::engine::{Ending, Engine};
use rig::faults::Faults;
use rig::simulate::look_up;
use rig::talk::START_LIMIT;
use rig::{Keep, Pulse, Sink};
use role_port::PortEvent;
use std::path::Path;
use wire::time::{Span, Timestamp};

/// Default time limit for the first report of an attached device under test. Assumption: the user has the program at
/// hand, and starts it in another terminal.
pub const ATTACH_MAX_DEFAULT: Span = Span::from_secs(60);
/// Time for the last messages to leave. Assumption: a message of 64 bytes takes 67 ms at 9,600 baud.
const LAST_WORDS: Span = Span::from_millis(100);
/// Time between two checks outside the world.
const PULSE_PERIOD: Span = Span::from_millis(100);

#[derive(Debug)]
pub struct LiveWorld {
    rig: Rig,
    director: Director,
    setting: Setting,
    plans: PortPlans,
    /// The controller's configuration; `None` if no node takes missions.
    config: Option<Config>,
    journal: Journal,
    lateness: Lateness,
    /// Frames of an emulated device that another node has sent.
    clashes: u64,
    /// Frames on the bus of the base that are not in the base's command set.
    foreign: FloodWatch,
    /// Faults of the plan; `None` if it schedules no faults.
    faults: Option<Box<Faults>>,
    /// Monitor of properties; `None` if none are to be judged.
    eyes: Option<Box<Eyes>>,
}

enum Awaited {
    Due,
    Port(usize, PortEvent),
    Device(Heard),
    Command(commands::Ended),
    Machine,
}

impl LiveWorld {
    /// A rig at these ports; the plan's faults draw from `seed`. [`Setting::reaches`] must have accepted them.
    pub fn new(
        (mut rig, plans): (Rig, PortPlans),
        director: Director,
        setting: Setting,
        seed: u64,
    ) -> Self {
        let faults = Faults::of(&director.engine.plan().faults, seed, &mut rig);
        let config = rig.robot().map(|robot| robot.bench.controller_config());
        let mut lateness = Lateness::new(setting.late_max);
        // A reaction begins in any step.
        let measured = &director.engine.plan().measurements;
        if measured.iter().any(|declared| declared.quantity.reaction().is_some()) {
            lateness.judge_throughout();
        }
        Self {
            rig,
            director,
            setting,
            plans,
            config,
            journal: Journal::default(),
            lateness,
            clashes: 0,
            foreign: FloodWatch::default(),
            faults,
            eyes: None,
        }
    }

    /// Adds a monitor of these properties, as far as this bench shows their data.
    pub fn with_monitor(mut self, properties: &[Property], speakers: &[Speaker]) -> Self {
        let limits = self.config.as_ref().map(Limits::of);
        let ear = match self.setting.device_under_test {
            DeviceUnderTest::InProcess => Ear::Controller,
            _ => Ear::Lines,
        };
        let sight = self.setting.sight();
        let eyes = Eyes::new(properties, limits.as_ref(), speakers, (&sight, ear));
        if eyes.judge() {
            self.lateness.judge_throughout();
        }
        self.eyes = (!properties.is_empty()).then(|| Box::new(eyes));
        self
    }

    fn engine(&self) -> &Engine {
        &self.director.engine
    }

    /// Runs the plan to its end. The stderr of the device under test goes into `log`.
    ///
    /// # Errors
    /// When the run cannot begin. A run that has begun ends with an outcome.
    pub fn run(
        &mut self,
        log: &Path,
        sink: Sink<'_>,
        keep: Keep<'_>,
        pulse: Pulse<'_>,
    ) -> Result<LiveEnd, LiveError> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        runtime.block_on(self.run_in_runtime(log, sink, keep, pulse))
    }

    /// What the bench does before and after goes around the run, however that ends.
    async fn run_in_runtime(
        &mut self,
        log: &Path,
        sink: Sink<'_>,
        keep: Keep<'_>,
        pulse: Pulse<'_>,
    ) -> Result<LiveEnd, LiveError> {
        let mut commands = Commands::new(self.setting.work.clone(), log);
        let mut ended = match self.set_up(&mut commands, sink, pulse).await {
            Ok(()) => self.run_set_up((log, &mut commands), sink, keep, pulse).await,
            Err(error) => Err(error),
        };
        let at = ended.as_ref().map_or(Timestamp::ZERO, |ended| ended.run.end);
        let torn_down = self.tear_down(&mut commands, sink, at).await;
        match (&mut ended, torn_down) {
            (Ok(ended), torn_down) => {
                ended.run.commands = std::mem::take(&mut self.director.commands);
                ended.artifacts = commands.files().collect();
                if let Err(why) = torn_down {
                    let ending = ended.run.ending.clone();
                    ended.run.ending = journal::blame_bench(ending, &why);
                }
            }
            (Err(_), Err(why)) => tracing::error!("after the run: {why}"),
            (Err(_), Ok(())) => {}
        }
        ended
    }

    async fn run_set_up(
        &mut self,
        (log, commands): (&Path, &mut Commands),
        sink: Sink<'_>,
        keep: Keep<'_>,
        pulse: Pulse<'_>,
    ) -> Result<LiveEnd, LiveError> {
        let mut ports = Ports::open(std::mem::take(&mut self.plans)).await?;
        commands.places = ports.wiring()?.places;
        let _told = lines::Kept::or_warn(&commands.places);
        let clock = Clock::start();
        let (mut device, mut programs) = self.start(log, sink, &clock, &mut ports).await?;
        // Only now: programs would inherit the scheduling.
        let scheduling = realtime::ask(self.setting.scheduling);
        let machine = MachineWatch::new(clock.now(), self.lateness.late_max());
        let mut machine = machine.map_err(PortError::from)?;
        let alarm = Alarm::new(clock)?;
        let (mut events, mut pulse_at, mut until) = (0, clock.now(), None);

        let ending = loop {
            let now = clock.now();
            events += 1;
            if now >= pulse_at {
                pulse_at = now + PULSE_PERIOD;
                self.look_up(now, sink, pulse);
                let processes = device.process().into_iter().chain(programs.processes());
                self.lateness.add_machine(now, machine.look(processes));
                if let Some(why) = ports.wrong_rate(now) {
                    self.director.engine.broke(now, &why);
                }
                let limit = self.start_limit();
                // Other reports do not count: the first step waits for a state.
                if !self.engine().is_heard() && now - Timestamp::ZERO > limit {
                    let why = device.why_silent(limit, &self.director.talk);
                    match device.is_missing() {
                        true => self.director.engine.broke(now, &why),
                        false => self.director.engine.failed(now, &why),
                    }
                }
            }
            self.strike(now, sink, &mut device, &clock);
            self.deliver(now, sink, &mut ports);
            self.wake(now);
            device.wake(&clock, now);
            machine.wake(now);
            commands.wake(now);
            self.transmit(now, sink, keep, (&mut device, commands), &clock);
            self.switch(now, &mut programs);
            self.overhear(now, sink, &mut device);
            self.lateness.reach(self.course());
            if self.director.engine.is_ending() && !self.lateness.is_broken_off() {
                self.lateness.add_machine(now, machine.late(now));
                self.lateness.break_off();
            }
            if let Some(ending) = self.over(now, &mut until) {
                break ending;
            }
            let due = self.next_due().min(device.next_wakeup()).min(pulse_at);
            let due = due.min(machine.next_wakeup()).min(commands.next_wakeup());
            let due = due.min(until.unwrap_or(Timestamp::MAX));
            let awaited = tokio::select! {
                rung = alarm.at(due) => rung.map(|()| Awaited::Due)?,
                (place, event) = ports.next() => Awaited::Port(place, event),
                heard = device.heard(&clock) => Awaited::Device(heard),
                heard = programs.heard() => Awaited::Device(heard),
                ended = commands.ended() => Awaited::Command(ended),
                () = machine.arrives() => Awaited::Machine,
            };
            let then = clock.now();
            if then >= due {
                let late = then - due.max(now);
                self.lateness.add(then, late);
                self.director.engine.heard_late(then, late);
            }
            match awaited {
                Awaited::Due => {}
                Awaited::Port(place, event) => self.hear(then, sink, &ports, place, event),
                Awaited::Device(heard) => self.hear_device(then, sink, &device, heard),
                Awaited::Command(ended) => self.hear_command(then, sink, &ended),
                Awaited::Machine => self.lateness.add_machine(then, machine.arrived(then)),
            }
        };
        let end = clock.now();
        self.lateness.end_step(self.course());
        let losses = self.losses(&ports, &device);
        let mut notes = self.end_notes(end, sink, &losses);
        let (faults, dropped) = self.end_faults(end, sink, &mut device);
        let eyes = self.eyes.take();
        let (properties, unjudged) = eyes.map(|eyes| eyes.close(end)).unwrap_or_default();
        let ending = self.judge(ending, end, &ports, &losses);
        let ending = verdict::excuse(ending, &properties, &self.lateness);
        let bus_to_command = device.in_process().map(|here| here.bus_to_command().spread());
        let timing = self.lateness.timing(bus_to_command, scheduling);
        let port_summaries = self.port_summaries(&ports, &device);
        for note in [self.journal.unnoted(), self.director.talk.unnoted()].into_iter().flatten() {
            journal::note(sink, end, Device::Plan, note);
        }
        device.end().await;
        for note in programs.end().await {
            journal::note(sink, end, Device::Plan, note.clone());
            notes.push(note);
        }
        if let Some(ended) = commands.end().await {
            self.hear_command(end, sink, &ended);
        }
        let ports = port_summaries;
        let run = Ended {
            end,
            events,
            observations: self.director.engine.take_observations(),
            dropped,
            faults,
            properties,
            unjudged,
            no_truth: self.setting.sight().why_not(View::Truth),
            notes,
            announced: self.engine().has_announced(),
            ..Ended::at_once(ending)
        };
        Ok(LiveEnd { run, timing, ports, artifacts: Vec::new() })
    }

    /// Starts the device under test. Meanwhile the ports are served: an emulated adapter must answer when it is opened.
    async fn start(
        &mut self,
        log: &Path,
        sink: Sink<'_>,
        clock: &Clock,
        ports: &mut Ports,
    ) -> Result<(Running, Programs), LiveError> {
        let Setting { device_under_test, programs, .. } = self.setting.clone();
        let wiring = ports.wiring()?;
        let is_alone = programs.len() == 1 && self.config.is_none();
        let config = (self.config, self.faults.is_some());
        let mut starting = std::pin::pin!(Running::start(&device_under_test, config, &wiring, log));
        loop {
            tokio::select! {
                started = &mut starting => {
                    let started = started?;
                    return Ok((started, Programs::start(&programs, is_alone, &wiring, log)?));
                }
                (place, event) = ports.next() => {
                    self.hear(clock.now(), sink, ports, place, event);
                }
            }
        }
    }

    /// Checks for a stop request, whether the disk still takes the record, and what a person has typed.
    fn look_up(&mut self, now: Timestamp, sink: Sink<'_>, pulse: Pulse<'_>) {
        if let Some(eyes) = &self.eyes {
            eyes.tell(sink);
        }
        look_up(&mut self.director.engine, now, sink, pulse);
        self.director.listen_to_operator(now, sink);
    }

    /// How the run ended, once the plan's last messages have left.
    fn over(&self, now: Timestamp, until: &mut Option<Timestamp>) -> Option<Ending> {
        let ending = self.director.engine.ending()?;
        if self.config.is_none() && now < *until.get_or_insert(now + LAST_WORDS) {
            return None;
        }
        Some(ending.clone())
    }

    /// Time limit for the first report of the device under test.
    const fn start_limit(&self) -> Span {
        match self.setting.device_under_test {
            DeviceUnderTest::Attached(_) => self.setting.attach_max,
            _ => START_LIMIT,
        }
    }

    fn course(&self) -> Course {
        let observations = self.director.engine.observations().len();
        Course { steps: self.director.engine.progress().0, observations }
    }
}
