//! The paper's robot or table in virtual time, with orders from code instead of a plan.
//!
//! A plan says what is done and judged. Here a test sends missions one by one, advances time in spans, and alters what
//! crosses a line. Lines, devices, controller and order of events are those of every other run.

use super::Rig;
use super::build;
use super::director::Director;
use super::line::EndId;
use super::node::Part;
use super::robot::Robot;
use super::simulate::Simulation;
use super::touched::Touched;
use crate::bench::{Bench, Carrier};
use crate::crossing::{Crossing, CrossingFailure};
use crate::engine::{Ending, Engine};
use crate::hosted::Hosted;
use crate::operator::{Answers, Operator};
use controller::Controller;
use controller::config::Config;
use controller::mission::{Mission, Report};
use emulators::device_file::Devices;
use emulators::gyro::GyroEmulator;
use judge::properties::{Limits, Monitor, PropertyVerdict, Seen};
use plan::Plan;
use record::sink::{Level, RecordSink};
use record::{Device, Record, RecordKind};
use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wire::can::CanFrame;
use wire::device::Transmit;
use wire::time::Timestamp;
use wire::units::Angle;

/// The engine waits beside the test and does nothing, for as long as a plan may last.
const NO_PLAN: &str = r#"
name = "by-hand"
title = "Orders come from code."
devices = "none"
steps = [{ wait = { duration_s = 2_678_400 } }]
"#;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Direction {
    /// The gyro's stream.
    GyroToController,
    /// Commands to a gyro that accepts them.
    ControllerToGyro,
    /// Motion, pose and answers.
    BaseToController,
    /// Requests.
    ControllerToBase,
}

/// Replaces what has arrived with what the receiver gets.
pub type Tap = Box<dyn FnMut(Timestamp, Transmit) -> Vec<Transmit> + Send>;

/// Controller and emulated devices on their lines, advanced by hand.
pub struct ByHand {
    simulation: Simulation,
    taps: SharedTaps,
    heard: Heard,
}

impl ByHand {
    /// Starts at time zero. `change` may alter the controller's configuration before the start.
    ///
    /// # Errors
    /// Never: the built-in plan always parses.
    pub fn new(
        devices: &Devices,
        seed: u64,
        change: impl FnOnce(&mut Config),
    ) -> Result<Self, toml::de::Error> {
        let plan = Arc::new(NO_PLAN.parse::<Plan>()?);
        let bench = Bench::new(devices.clone(), seed);
        let mut config = bench.controller_config();
        change(&mut config);
        let controller = Hosted::Ours(Controller::new(config, Timestamp::ZERO));
        let rig = build::paper(bench, Some(controller));
        let operator = Operator::simulated(Answers::default());
        let director = Director::new(Engine::new(plan, Timestamp::ZERO), operator);
        let monitor = Monitor::new(&[], Some(&Limits::of(&config)), &[]);
        let crossing = Taps::default();
        let taps = Arc::clone(&crossing.taps);
        let mut by_hand = Self {
            simulation: Simulation::new(Some(Box::new(crossing)), rig, director, seed)
                .with_monitor(Some(monitor)),
            taps,
            heard: Heard::default(),
        };
        by_hand.settle();
        Ok(by_hand)
    }

    pub const fn now(&self) -> Timestamp {
        self.simulation.now
    }

    /// Advances to the next event, or to `until` if that comes first; returns `false` at `until`.
    ///
    /// # Errors
    /// When the run is over: time stands still, or two devices answer each other endlessly.
    pub fn step(&mut self, until: Timestamp) -> Result<bool, Ending> {
        // The test may have changed a device since the last step.
        self.settle();
        let next = self.simulation.next_event();
        if next > until {
            self.simulation.now = self.now().max(until);
            return Ok(false);
        }
        match self.simulation.step(next, &mut self.heard, &mut |_| ()) {
            Some(ending) => Err(ending),
            None => self.simulation.director.engine.ending().cloned().map_or(Ok(true), Err),
        }
    }

    pub fn command(&mut self, mission: Mission) {
        self.simulation.show(&Seen::Told(&mission));
        self.simulation.order(mission);
        self.simulation.touched = Touched::ALL;
        self.settle();
    }

    /// Takes the controller's reports since the last call, with their times.
    pub fn take_reports(&mut self) -> Vec<(Timestamp, Report)> {
        std::mem::take(&mut self.heard.0)
    }

    /// Sets the tap of a direction; `None` removes it.
    pub fn tap(&mut self, direction: Direction, tap: Option<Tap>) {
        let Some((line, from)) = from(&self.simulation.rig, direction) else { return };
        let mut taps = lock(&self.taps);
        match tap {
            Some(tap) => _ = taps.insert((line, from.place()), tap),
            None => _ = taps.remove(&(line, from.place())),
        }
    }

    /// Delivers `what` now, as if it had crossed the line.
    pub fn inject(&mut self, direction: Direction, what: &Transmit) {
        if let Some((line, from)) = from(&self.simulation.rig, direction) {
            self.simulation.delivered(&mut self.heard, line, from, what);
            self.settle();
        }
    }

    pub fn begin_step(&mut self) {
        self.simulation.show(&Seen::StepBegan);
    }

    pub fn verdicts(self) -> Vec<PropertyVerdict> {
        let now = self.now();
        let watch = self.simulation.watch;
        watch.map(|watch| watch.into_monitor().verdicts(now)).unwrap_or_default()
    }

    /// The controller under test.
    pub fn controller(&self) -> Option<&Controller> {
        self.simulation.rig.nodes.iter().find_map(|node| match &node.part {
            Part::Controller(machine) => match &machine.host.guest {
                Hosted::Ours(controller) => Some(controller),
                Hosted::Own(_) => None,
            },
            _ => None,
        })
    }

    pub fn gyro(&mut self) -> Option<&mut GyroEmulator> {
        Some(&mut self.robot()?.bench.gyro)
    }

    pub fn carrier(&mut self) -> Option<&mut Carrier> {
        Some(&mut self.robot()?.bench.carrier)
    }

    /// True heading of the carrier, not wrapped.
    pub fn heading(&self) -> Option<Angle> {
        let robot = self.simulation.rig.robot()?;
        Some(robot.bench.carrier.heading_at(self.now()))
    }

    fn robot(&mut self) -> Option<&mut Robot> {
        self.simulation.touched = Touched::ALL;
        self.simulation.rig.robot_mut()
    }

    fn settle(&mut self) {
        self.simulation.transmit(&mut self.heard, &mut |_| ());
    }
}

/// The line of a direction, and the sending end; `None` if the rig has no such line.
fn from(rig: &Rig, direction: Direction) -> Option<(usize, EndId)> {
    let (name, who) = match direction {
        Direction::GyroToController => ("gyro", Device::Gyro),
        Direction::ControllerToGyro => ("gyro", Device::Controller),
        Direction::BaseToController => ("base", Device::Base),
        Direction::ControllerToBase => ("base", Device::Controller),
    };
    let line = rig.line_names.iter().position(|line| &**line == name)?;
    let place = rig.lines[line].ends().iter().position(|end| end.who == who)?;
    Some((line, EndId::of(place)))
}

/// Keeps the controller's reports.
#[derive(Debug, Default)]
struct Heard(Vec<(Timestamp, Report)>);

impl RecordSink for Heard {
    fn record(&mut self, record: Record) {
        if let RecordKind::Report(report) = record.kind {
            self.0.push((record.at, report));
        }
    }

    fn bytes(&mut self, _: Timestamp, _: Device, _: &[u8]) {}

    fn frame(&mut self, _: Timestamp, _: Device, _: CanFrame) {}

    fn level(&self) -> Level {
        Level::Full
    }

    fn failed(&self) -> Option<&io::Error> {
        None
    }

    fn finish(&mut self) {}
}

/// The taps, by line and end: [`ByHand`] sets them, and the crossing uses them.
type SharedTaps = Arc<Mutex<BTreeMap<(usize, usize), Tap>>>;

fn lock(taps: &SharedTaps) -> MutexGuard<'_, BTreeMap<(usize, usize), Tap>> {
    taps.lock().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Default)]
struct Taps {
    taps: SharedTaps,
    more: VecDeque<Transmit>,
}

impl Crossing for Taps {
    fn carry(&mut self, now: Timestamp, line: usize, from: usize, what: &mut Transmit) -> bool {
        let mut taps = lock(&self.taps);
        let Some(tap) = taps.get_mut(&(line, from)) else { return true };
        self.more.extend(tap(now, *what));
        self.more.pop_front().map(|first| *what = first).is_some()
    }

    fn more(&mut self) -> Option<Transmit> {
        self.more.pop_front()
    }

    fn failure(&mut self) -> Option<CrossingFailure> {
        None
    }

    fn bus(&self) -> &'static str {
        "memory"
    }
}
