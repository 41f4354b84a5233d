//! A controller and emulated devices, joined by paced lines and stepped by hand.
//!
//! Time is virtual and jumps from event to event. At equal times the order is that of the simulated
//! world: deliver, wake, transmit. A [`Tap`] stands at the receiver's end of a direction: it sees each
//! packet or frame when it has arrived and says what is received in its place.

mod carrier;
mod links;
mod orders;
mod watch;

pub use carrier::Carrier;
pub use links::{Direction, Piece, Tap};

use controller::config::{BaseConfig, Config, GyroConfig, MotionConfig, Transport};
use controller::health::Health;
use controller::mission::{
    AbortReason, Command, Mission, MissionId, MissionResult, Refusal, Report, State,
};
use controller::{Controller, Input, Output, Port};
use emulators::base::{self, BaseEmulator};
use emulators::device_file::Devices;
use emulators::gyro::GyroEmulator;
use emulators::table::TableEmulator;
use judge::properties::Seen;
use links::{Arrived, Links};
use std::collections::BTreeMap;
use watch::Watch;
use wire::time::{Span, Timestamp};

/// No mission of a scenario takes longer: the controller's own limits are far below.
const ANSWER_LIMIT: Span = Span::from_secs(3_600);
/// Rounds of transmitting at one instant; more means that two devices answer each other for ever.
const ROUNDS_MAX: u32 = 1_000;
/// Events at one instant; more means that somebody wants to be woken again and again without need.
const EVENTS_AT_ONCE_MAX: u32 = 1_000;

/// What became of a mission.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// It is complete.
    Done(MissionResult),
    /// It was not begun.
    Refused(Refusal),
    /// It was broken off.
    Aborted(AbortReason),
}

/// The controller, its devices and the lines between them.
pub struct Rig {
    now: Timestamp,
    /// The code under test.
    pub controller: Controller,
    /// The gyro.
    pub gyro: GyroEmulator,
    /// What carries it.
    pub carrier: Carrier,
    links: Links,
    watch: Watch,
    events_at_once: u32,
    next_id: MissionId,
    answers: BTreeMap<MissionId, (Timestamp, Answer)>,
    health_changes: Vec<(Timestamp, Health)>,
    state: Option<(Timestamp, State)>,
}

impl Rig {
    /// The controller with its defaults on these devices, at time zero.
    pub fn new(devices: &Devices, seed: u64) -> Self {
        Self::with_config(devices, seed, |_| {})
    }

    /// The same, with a configuration that `change` had in its hands.
    pub fn with_config(devices: &Devices, seed: u64, change: impl FnOnce(&mut Config)) -> Self {
        let (stream, gyro) = devices.gyro.clone();
        let transport = devices.base.as_ref().map(|(transport, _)| match transport {
            base::Transport::Can => Transport::Can,
            base::Transport::Serial => Transport::Serial,
        });
        let mut config = Config::new(
            GyroConfig::new(stream),
            transport.map(BaseConfig::new),
            MotionConfig::default(),
        );
        change(&mut config);
        let carrier = match &devices.base {
            Some((transport, parameters)) => Carrier::Base(Box::new(BaseEmulator::new(
                parameters.clone(),
                *transport,
                seed,
                "base",
            ))),
            None => Carrier::Table(Box::new(TableEmulator::new(
                devices.table.clone().unwrap_or_default(),
            ))),
        };
        let now = Timestamp::ZERO;
        let mut rig = Self {
            now,
            controller: Controller::new(config, now),
            gyro: GyroEmulator::new(gyro, stream, seed, "gyro"),
            carrier,
            links: Links::new(stream, transport),
            watch: Watch::new(&config),
            events_at_once: 0,
            next_id: 1,
            answers: BTreeMap::new(),
            health_changes: Vec::new(),
            state: None,
        };
        rig.transmit();
        rig
    }

    /// Bench time.
    pub const fn now(&self) -> Timestamp {
        self.now
    }

    /// From now on `tap` says what is received in this direction.
    pub fn tap(
        &mut self,
        direction: Direction,
        tap: impl FnMut(Timestamp, Piece) -> Vec<Piece> + 'static,
    ) {
        self.links.tap(direction, Some(Box::new(tap)));
    }

    /// From now on nothing is received in this direction.
    pub fn silence(&mut self, direction: Direction) {
        self.tap(direction, |_, _| Vec::new());
    }

    /// The direction is as it was before it was tapped.
    pub fn untap(&mut self, direction: Direction) {
        self.links.tap(direction, None);
    }

    /// These bytes or this frame are received now, from nobody.
    pub fn inject(&mut self, direction: Direction, piece: Piece) {
        self.receive(direction, &piece);
        self.transmit();
    }

    /// Goes on for `span`.
    pub fn run_for(&mut self, span: Span) {
        let until = self.now + span;
        while self.step(until) {}
    }

    /// Goes on until `holds`, which is asked after every event; false when it did not within `limit`.
    pub fn run_until(&mut self, limit: Span, mut holds: impl FnMut(&mut Self) -> bool) -> bool {
        let until = self.now + limit;
        loop {
            if holds(self) {
                return true;
            }
            if !self.step(until) {
                return false;
            }
        }
    }

    /// Gives the controller a mission.
    pub fn begin(&mut self, command: Command) -> MissionId {
        let id = self.next_id;
        self.next_id += 1;
        let mission = Mission { id, command };
        self.watch.look(self.now, &self.carrier);
        self.watch.see(self.now, &Seen::Told(&mission));
        self.controller.command(self.now, mission);
        self.transmit();
        id
    }

    /// What became of a mission, and when; `None` while it runs.
    pub fn answer(&self, id: MissionId) -> Option<(Timestamp, Answer)> {
        self.answers.get(&id).copied()
    }

    /// Goes on until the mission is answered.
    ///
    /// # Panics
    ///
    /// When it is not: the controller owes every mission an answer.
    pub fn finish(&mut self, id: MissionId) -> Answer {
        let answered = self.run_until(ANSWER_LIMIT, |rig| rig.answers.contains_key(&id));
        assert!(answered, "mission {id} was never answered: {:?}", self.controller);
        self.answers[&id].1
    }

    /// Gives the controller a mission and goes on until it is answered.
    pub fn command(&mut self, command: Command) -> Answer {
        let id = self.begin(command);
        self.finish(id)
    }

    /// Every change of the controller's health so far.
    pub fn health_changes(&self) -> &[(Timestamp, Health)] {
        &self.health_changes
    }

    /// The controller's health.
    pub const fn health(&self) -> Health {
        self.controller.health()
    }

    /// The controller's state, asked for now.
    ///
    /// # Panics
    ///
    /// When it gives none.
    pub fn state(&mut self) -> State {
        self.state = None;
        self.begin(Command::RequestState);
        self.state.expect("a state that is asked for comes at once").1
    }

    /// The last state that the controller reported, and when.
    pub const fn last_state(&self) -> Option<&(Timestamp, State)> {
        self.state.as_ref()
    }

    /// Goes on to the next event, or to `until` if that comes first; false at `until`.
    fn step(&mut self, until: Timestamp) -> bool {
        let next = self
            .links
            .next_arrival()
            .min(self.gyro.next_wakeup())
            .min(self.carrier.next_wakeup())
            .min(self.controller.next_wakeup());
        if next > until {
            self.now = self.now.max(until);
            return false;
        }
        self.events_at_once = if next > self.now { 0 } else { self.events_at_once + 1 };
        assert!(
            self.events_at_once < EVENTS_AT_ONCE_MAX,
            "time stands still at {:?}: {:?}",
            self.now,
            self.controller
        );
        self.now = self.now.max(next);
        while let Some(Arrived { direction, piece }) = self.links.arrived(self.now) {
            for piece in self.links.through_tap(self.now, direction, piece) {
                self.receive(direction, &piece);
            }
        }
        self.wake();
        self.watch.look_again(self.now, &self.carrier);
        self.transmit();
        true
    }

    fn receive(&mut self, direction: Direction, piece: &Piece) {
        let now = self.now;
        self.watch.receive(now, direction, piece);
        match (direction, piece) {
            (Direction::GyroToController, Piece::Bytes(bytes)) => {
                self.controller.receive(now, Port::Gyro, Input::Bytes(bytes));
            }
            (Direction::GyroToController, Piece::Frame(frame)) => {
                self.controller.receive(now, Port::Gyro, Input::Frame(*frame));
            }
            (Direction::ControllerToGyro, Piece::Bytes(bytes)) => self.gyro.receive(now, bytes),
            (Direction::BaseToController, Piece::Bytes(bytes)) => {
                self.controller.receive(now, Port::Base, Input::Bytes(bytes));
            }
            (Direction::BaseToController, Piece::Frame(frame)) => {
                self.controller.receive(now, Port::Base, Input::Frame(*frame));
            }
            (Direction::ControllerToBase, piece) => self.carrier.receive(now, piece),
            (Direction::ControllerToGyro, Piece::Frame(_)) => {}
        }
    }

    fn wake(&mut self) {
        let now = self.now;
        if self.carrier.next_wakeup() <= now {
            self.carrier.wake(now);
        }
        while self.gyro.next_wakeup() <= now {
            let heading = self.carrier.heading_at(now);
            if let Some(packet) = self.gyro.wake(now, heading) {
                self.links.gyro.send(now, packet);
            }
        }
        if self.controller.next_wakeup() <= now {
            self.controller.wake(now);
        }
    }

    fn transmit(&mut self) {
        for _ in 0..ROUNDS_MAX {
            let mut quiet = true;
            while let Some(output) = self.controller.transmit(self.now) {
                quiet = false;
                self.watch.look(self.now, &self.carrier);
                self.watch.see(self.now, &Seen::Sent(&output));
                match output {
                    Output::Bytes(Port::Gyro, packet) => {
                        self.links.gyro_commands.send(self.now, packet);
                    }
                    Output::Bytes(Port::Base, packet) => self.links.send_to_base(self.now, packet),
                    Output::Frame(frame) => self.links.send_frame(self.now, frame),
                }
            }
            while let Some(report) = self.controller.report() {
                quiet = false;
                self.watch.look(self.now, &self.carrier);
                self.watch.see(self.now, &Seen::Report(&report));
                self.take(report);
            }
            while let Some(output) = self.carrier.transmit() {
                quiet = false;
                self.links.send_from_base(self.now, output);
            }
            if quiet {
                return;
            }
        }
        panic!("two devices answer each other without end at {:?}", self.now);
    }

    fn take(&mut self, report: Report) {
        let (id, answer) = match report {
            Report::Done { id, result } => (id, Answer::Done(result)),
            Report::Refused { id, reason } => (id, Answer::Refused(reason)),
            Report::Aborted { id, reason } => (id, Answer::Aborted(reason)),
            Report::State(state) => {
                self.state = Some((self.now, state));
                return;
            }
            Report::Health(health) => {
                self.health_changes.push((self.now, health));
                return;
            }
        };
        let before = self.answers.insert(id, (self.now, answer));
        assert_eq!(before, None, "mission {id} was answered twice, again by {answer:?}");
    }
}
