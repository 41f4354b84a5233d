//! A controller and emulated devices in virtual time, stepped by hand, for scenarios that a plan cannot express.

mod orders;

pub use rig::by_hand::Direction;

use controller::config::Config;
use controller::health::Health;
use controller::mission::{
    AbortReason, Command, Mission, MissionId, MissionResult, Refusal, Report, State,
};
use emulators::base::{BaseEmulator, BaseTruth};
use emulators::device_file::Devices;
use emulators::gyro::GyroEmulator;
use emulators::table::TableEmulator;
use judge::properties::PropertyVerdict;
use rig::bench::Carrier;
use rig::by_hand::ByHand;
use std::collections::BTreeMap;
use wire::device::Transmit;
use wire::packet::{BYTES_MAX, Packet};
use wire::time::{Span, Timestamp};
use wire::units::Angle;

/// Time limit for the answer to a mission: the controller's own limits are far below.
const ANSWER_LIMIT: Span = Span::from_secs(3_600);

/// Answer to a mission.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// Completed.
    Done(MissionResult),
    /// Not begun.
    Refused(Refusal),
    /// Broken off.
    Aborted(AbortReason),
}

/// The controller, its devices and the lines between them.
pub struct Rig {
    by_hand: ByHand,
    next_id: MissionId,
    answers: BTreeMap<MissionId, (Timestamp, Answer)>,
    health_changes: Vec<(Timestamp, Health)>,
    state: Option<(Timestamp, State)>,
}

/// Splits bytes as they cross a line: several pieces if they are too many for one.
pub fn bytes(bytes: &[u8]) -> Vec<Transmit> {
    let packet = |piece| Packet::from_slice(piece).expect("no longer than a packet");
    bytes.chunks(BYTES_MAX).map(|piece| Transmit::Bytes(packet(piece))).collect()
}

impl Rig {
    /// Creates a controller with default configuration on these devices, at time zero.
    pub fn new(devices: &Devices, seed: u64) -> Self {
        Self::with_config(devices, seed, |_| {})
    }

    /// Creates a controller with a configuration that `change` modifies.
    ///
    /// # Panics
    ///
    /// Never: the embedded devices ship.
    pub fn with_config(devices: &Devices, seed: u64, change: impl FnOnce(&mut Config)) -> Self {
        let mut rig = Self {
            by_hand: ByHand::new(devices, seed, change).expect("it takes any devices"),
            next_id: 1,
            answers: BTreeMap::new(),
            health_changes: Vec::new(),
            state: None,
        };
        rig.hear();
        rig
    }

    /// Bench time.
    pub const fn now(&self) -> Timestamp {
        self.by_hand.now()
    }

    /// From now on `tap` determines what is received in this direction.
    pub fn tap(
        &mut self,
        direction: Direction,
        tap: impl FnMut(Timestamp, Transmit) -> Vec<Transmit> + Send + 'static,
    ) {
        self.by_hand.tap(direction, Some(Box::new(tap)));
    }

    /// From now on nothing is received in this direction.
    pub fn silence(&mut self, direction: Direction) {
        self.tap(direction, |_, _| Vec::new());
    }

    /// Removes the tap of this direction.
    pub fn untap(&mut self, direction: Direction) {
        self.by_hand.tap(direction, None);
    }

    /// Delivers `what` now, without a sender.
    pub fn inject(&mut self, direction: Direction, what: &Transmit) {
        self.by_hand.inject(direction, what);
        self.hear();
    }

    /// Runs for `span`.
    pub fn run_for(&mut self, span: Span) {
        let until = self.now() + span;
        while self.step(until) {}
    }

    /// Runs until `holds`, which is called after every event; returns `false` if it did not within `limit`.
    pub fn run_until(&mut self, limit: Span, mut holds: impl FnMut(&mut Self) -> bool) -> bool {
        let until = self.now() + limit;
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
        self.by_hand.command(Mission { id, command });
        self.hear();
        id
    }

    /// Returns the answer to a mission and its time; `None` while it runs.
    pub fn answer(&self, id: MissionId) -> Option<(Timestamp, Answer)> {
        self.answers.get(&id).copied()
    }

    /// Runs until the mission is answered.
    ///
    /// # Panics
    ///
    /// When it is not answered: the controller must answer every mission.
    pub fn finish(&mut self, id: MissionId) -> Answer {
        let answered = self.run_until(ANSWER_LIMIT, |rig| rig.answers.contains_key(&id));
        assert!(answered, "mission {id} was never answered: {:?}", self.by_hand.controller());
        self.answers[&id].1
    }

    /// Gives the controller a mission and runs until it is answered.
    pub fn command(&mut self, command: Command) -> Answer {
        let id = self.begin(command);
        self.finish(id)
    }

    /// Returns every change of the controller's health so far.
    pub fn health_changes(&self) -> &[(Timestamp, Health)] {
        &self.health_changes
    }

    /// Returns the controller's health.
    ///
    /// # Panics
    ///
    /// Never: the controller is ours.
    pub fn health(&self) -> Health {
        self.by_hand.controller().expect("the controller is ours").health()
    }

    /// Requests the controller's current state.
    ///
    /// # Panics
    ///
    /// When it reports none.
    pub fn state(&mut self) -> State {
        self.state = None;
        self.begin(Command::RequestState);
        self.state.expect("a state that is asked for comes at once").1
    }

    /// Returns the last state that the controller reported, and its time.
    pub const fn last_state(&self) -> Option<&(Timestamp, State)> {
        self.state.as_ref()
    }

    /// Returns the gyro.
    ///
    /// # Panics
    ///
    /// Never: every rig has one.
    pub fn gyro(&mut self) -> &mut GyroEmulator {
        self.by_hand.gyro().expect("every rig has a gyro")
    }

    /// Returns the base.
    ///
    /// # Panics
    ///
    /// When the gyro is on a table.
    pub fn base(&mut self) -> &mut BaseEmulator {
        match self.by_hand.carrier() {
            Some(Carrier::Base(base)) => base,
            _ => panic!("this rig has no base"),
        }
    }

    /// Returns the table.
    ///
    /// # Panics
    ///
    /// When the gyro is on a base.
    pub fn table(&mut self) -> &mut TableEmulator {
        match self.by_hand.carrier() {
            Some(Carrier::Table(table)) => table,
            _ => panic!("this rig has no table"),
        }
    }

    /// Returns the current truth of the base.
    ///
    /// # Panics
    ///
    /// When the gyro is on a table.
    pub fn truth(&mut self) -> BaseTruth {
        let now = self.now();
        let base = self.base();
        base.wake(now);
        base.truth_at(now)
    }

    /// Returns the true heading of the gyro's carrier, not wrapped.
    ///
    /// # Panics
    ///
    /// Never: every rig has a carrier.
    pub fn heading(&self) -> Angle {
        self.by_hand.heading().expect("something carries the gyro")
    }

    /// Returns the verdict on every property since the rig was created. Ends the rig.
    pub fn verdicts(self) -> Vec<PropertyVerdict> {
        self.by_hand.verdicts()
    }

    /// Marks the begin of a lap for the properties; without any, the scenario is one lap.
    pub fn begin_step(&mut self) {
        self.by_hand.begin_step();
    }

    /// Runs to the next event, or to `until` if that is earlier; returns `false` at `until`.
    fn step(&mut self, until: Timestamp) -> bool {
        match self.by_hand.step(until) {
            Ok(goes_on) => {
                self.hear();
                goes_on
            }
            Err(ending) => panic!("{ending:?}: {:?}", self.by_hand.controller()),
        }
    }

    fn hear(&mut self) {
        for (at, report) in self.by_hand.take_reports() {
            let (id, answer) = match report {
                Report::Done { id, result } => (id, Answer::Done(result)),
                Report::Refused { id, reason } => (id, Answer::Refused(reason)),
                Report::Aborted { id, reason } => (id, Answer::Aborted(reason)),
                Report::State(state) => {
                    self.state = Some((at, state));
                    continue;
                }
                Report::Health(health) => {
                    self.health_changes.push((at, health));
                    continue;
                }
            };
            let before = self.answers.insert(id, (at, answer));
            assert_eq!(before, None, "mission {id} was answered twice, again by {answer:?}");
        }
    }
}
