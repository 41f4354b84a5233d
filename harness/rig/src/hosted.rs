//! Your own controller in the simulated world, in place of ours.
//!
//! [`HostedController`] is all that the world requires of a controller. [`Controller`] implements it; [`Hosting`] says
//! how another controller is started for a run.

use controller::config::Config;
use controller::mission::{Mission, Report};
use controller::{Controller, Input, Output, Port};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use wire::device::{Device, PortId, Transmit};
use wire::time::{Span, Timestamp};

/// A controller without IO and without a clock: the world feeds and drains it, and passes the time as an argument.
///
/// After each call of [`receive`](Self::receive), [`command`](Self::command) and [`wake`](Self::wake) the world takes
/// all outputs and reports, then asks for the next wake-up. All times are on one scale, which begins with the run; only
/// a fault of the controller's own clock makes them jump.
///
/// A plan begins once the controller has reported its [state](Report::State), and each table turn and lap asks for one:
/// a controller should also report its state unasked, about once a second.
pub trait HostedController: fmt::Debug + Send {
    /// Takes input at a port: bytes of a serial line, as they arrive, or a CAN frame.
    fn receive(&mut self, now: Timestamp, port: Port, input: Input<'_>);

    /// Takes a mission. The controller answers each mission once: done, refused or aborted.
    fn command(&mut self, now: Timestamp, mission: Mission);

    /// Does what is due `now`.
    fn wake(&mut self, now: Timestamp);

    /// When [`Self::wake`] has something to do, if nothing arrives earlier; [`Timestamp::MAX`] for never. A time in the
    /// past means at once, and ends the run with an error if it is returned endlessly.
    fn next_wakeup(&self) -> Timestamp;

    fn transmit(&mut self, now: Timestamp) -> Option<Output>;

    /// Returns the next report, oldest first.
    fn report(&mut self) -> Option<Report>;

    /// Returns the next note, taken after the reports. A controller in Rust returns no notes.
    fn news(&mut self) -> Option<News> {
        None
    }
}

/// What a controller program may produce besides reports.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum News {
    /// A line that is not a report.
    Note(String),
    /// A line that should have been a report on which the run depends: the run fails.
    Misreport(String),
    /// The program did not start; why.
    NotStarted(String),
    /// The program has ended, or takes no more missions. What it did, to stand behind its name:
    /// `exited during the run (status 0)`.
    Ended(String),
    /// The program was killed because the run is to be aborted.
    GivenUp,
}

impl HostedController for Controller {
    fn receive(&mut self, now: Timestamp, port: Port, input: Input<'_>) {
        Self::receive(self, now, port, input);
    }

    fn command(&mut self, now: Timestamp, mission: Mission) {
        Self::command(self, now, mission);
    }

    fn wake(&mut self, now: Timestamp) {
        Self::wake(self, now);
    }

    fn next_wakeup(&self) -> Timestamp {
        Self::next_wakeup(self)
    }

    fn transmit(&mut self, now: Timestamp) -> Option<Output> {
        Self::transmit(self, now)
    }

    fn report(&mut self) -> Option<Report> {
        Self::report(self)
    }
}

/// How the controller of a run is started. The default is ours.
#[derive(Clone, Default)]
pub struct Hosting(How);

#[derive(Clone, Default)]
enum How {
    #[default]
    Ours,
    Own(Arc<Start>),
    Program(ControllerProgram),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ControllerProgram {
    /// `k2a-controller`.
    Ours,
    /// A command line, with `{gyro}` and `{base}` for the ports.
    Words(Vec<String>),
}

type Start = dyn Fn(&Config) -> Box<dyn HostedController> + Send + Sync;

impl Hosting {
    /// `start` makes a controller for each run, at time zero, from the gyro's stream, the connection of the base, and
    /// the limits of motion.
    pub fn of<C>(start: impl Fn(&Config) -> C + Send + Sync + 'static) -> Self
    where
        C: HostedController + 'static,
    {
        Self(How::Own(Arc::new(move |config| Box::new(start(config)))))
    }

    /// Runs a program, started afresh for each run: missions go to its standard input, reports come from its standard
    /// output (`docs/virtual-time.md`).
    pub const fn program(program: ControllerProgram) -> Self {
        Self(How::Program(program))
    }

    pub fn name(&self) -> String {
        match &self.0 {
            How::Ours | How::Own(_) => "in-process".to_owned(),
            How::Program(ControllerProgram::Ours) => "process".to_owned(),
            How::Program(ControllerProgram::Words(words)) => words.join(" "),
        }
    }

    /// Starts the controller of one run; `program` starts a controller program.
    pub fn start(
        &self,
        config: &Config,
        program: impl FnOnce(&ControllerProgram, &Config) -> Box<dyn HostedController>,
    ) -> Hosted {
        match &self.0 {
            How::Ours => Hosted::ours(config),
            How::Own(start) => Hosted::Own(start(config)),
            How::Program(words) => Hosted::Own(program(words, config)),
        }
    }
}

impl fmt::Debug for Hosting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Hosting({})", self.name())
    }
}

/// A test's own devices in this process, each under the name of the node under test that it plays.
#[derive(Clone, Default)]
pub struct OwnDevices(BTreeMap<String, Arc<StartDevice>>);

type StartDevice = dyn Fn() -> Box<dyn NodeDevice> + Send + Sync;

/// A device that plays a node under test.
pub trait NodeDevice: Device + Send {
    /// What the device did when it ended by itself, to stand behind its name: `exited during the run (status 0)`.
    /// Returned once.
    fn ended(&mut self) -> Option<String>;

    /// Why nothing that it does on its lines would happen on real ones. Returned once.
    fn wrong(&mut self) -> Option<String> {
        None
    }

    /// A CAN controller of it has changed its error state: a SocketCAN error frame at this port.
    fn error_frame(&mut self, _now: Timestamp, _port: PortId, _id: u32, _data: [u8; 8]) {}

    /// Sets its wall clock; `false` if it has no other clock than that of its machine.
    fn set_wall_clock(&mut self, _by: Span) -> bool {
        false
    }

    /// Switches its supply off, or on again: it starts anew, at `now`. Called when that changes.
    fn power(&mut self, now: Timestamp, on: bool);

    /// Ends a device in this process that does what no device can, with these words behind its name.
    fn disown(&mut self, _how: String) {}

    /// Asks it to end, at the end of the run. Returns what it did if it did not end in order, to stand behind its name:
    /// `ended with status 7 when it was asked to end`.
    fn stop(&mut self) -> Option<String> {
        None
    }

    /// Whether it did not end by itself, but was killed because the run is to be aborted.
    fn is_given_up(&self) -> bool {
        false
    }
}

/// Most messages of a device of a test at one instant. Assumption: a bus of 1 Mbit/s carries as many in ten seconds.
const SENT_AT_ONCE_MAX: u32 = 100_000;

/// Rust code of a test, which never ends by itself.
struct Endless<D> {
    /// `None` while it is off.
    device: Option<D>,
    start: Arc<dyn Fn() -> D + Send + Sync>,
    /// When it was last started.
    since: Span,
    /// The last instant at which it sent, and how much it sent then.
    sent: (Timestamp, u32),
    /// Why it was ended, to be told.
    disowned: Option<String>,
}

impl<D: fmt::Debug> fmt::Debug for Endless<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.device.fmt(f)
    }
}

impl<D: Device> Device for Endless<D> {
    fn receive(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        if let Some(device) = &mut self.device {
            device.receive(now - self.since, port, what);
        }
    }

    fn wake(&mut self, now: Timestamp) {
        if let Some(device) = &mut self.device {
            device.wake(now - self.since);
        }
    }

    fn next_wakeup(&self) -> Timestamp {
        if self.disowned.is_some() {
            return Timestamp::ZERO;
        }
        let due = self.device.as_ref().map_or(Timestamp::MAX, Device::next_wakeup);
        if due == Timestamp::MAX { due } else { due + self.since }
    }

    fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        let what = self.device.as_mut()?.transmit(now - self.since)?;
        let (at, times) = self.sent;
        self.sent = (now, if at == now { times + 1 } else { 1 });
        if self.sent.1 > SENT_AT_ONCE_MAX {
            self.disown(format!(
                "sends without an end: {SENT_AT_ONCE_MAX} messages at one instant"
            ));
            return None;
        }
        Some(what)
    }
}

impl<D: Device> NodeDevice for Endless<D> {
    fn ended(&mut self) -> Option<String> {
        self.disowned.take()
    }

    fn disown(&mut self, how: String) {
        self.device = None;
        self.disowned = Some(how);
    }

    /// Its clock starts with it.
    fn power(&mut self, now: Timestamp, on: bool) {
        self.device = on.then(|| (self.start)());
        self.since = now - Timestamp::ZERO;
    }
}

impl OwnDevices {
    /// Adds the device that plays `node`; `start` makes one for each run, and each time that its supply comes back. Each
    /// begins at time zero.
    pub fn add<D: Device + 'static>(
        &mut self,
        node: &str,
        start: impl Fn() -> D + Send + Sync + 'static,
    ) {
        let start: Arc<dyn Fn() -> D + Send + Sync> = Arc::new(start);
        let begun = move || Endless {
            device: Some(start()),
            start: Arc::clone(&start),
            since: Span::ZERO,
            sent: (Timestamp::ZERO, 0),
            disowned: None,
        };
        self.0.insert(node.to_owned(), Arc::new(move || Box::new(begun())));
    }

    /// The nodes that they play.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// Whether a device plays this node.
    pub fn has(&self, node: &str) -> bool {
        self.0.contains_key(node)
    }

    pub fn start(&self, node: &str) -> Option<Box<dyn NodeDevice>> {
        self.0.get(node).map(|start| start())
    }
}

impl fmt::Debug for OwnDevices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.0.keys()).finish()
    }
}

/// The controller of one run. Ours has its own variant, which saves an indirect call for every byte.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one in a run, and ours is the usual one")]
pub enum Hosted {
    Ours(Controller),
    Own(Box<dyn HostedController>),
}

impl Hosted {
    pub fn ours(config: &Config) -> Self {
        Self::Ours(Controller::new(*config, Timestamp::ZERO))
    }
}

macro_rules! of_either {
    ($self:ident, $controller:ident => $call:expr) => {
        match $self {
            Self::Ours($controller) => $call,
            Self::Own($controller) => $call,
        }
    };
}

impl HostedController for Hosted {
    #[inline]
    fn receive(&mut self, now: Timestamp, port: Port, input: Input<'_>) {
        of_either!(self, controller => controller.receive(now, port, input));
    }

    #[inline]
    fn command(&mut self, now: Timestamp, mission: Mission) {
        of_either!(self, controller => controller.command(now, mission));
    }

    #[inline]
    fn wake(&mut self, now: Timestamp) {
        of_either!(self, controller => controller.wake(now));
    }

    #[inline]
    fn next_wakeup(&self) -> Timestamp {
        of_either!(self, controller => controller.next_wakeup())
    }

    #[inline]
    fn transmit(&mut self, now: Timestamp) -> Option<Output> {
        of_either!(self, controller => controller.transmit(now))
    }

    #[inline]
    fn report(&mut self) -> Option<Report> {
        of_either!(self, controller => controller.report())
    }

    #[inline]
    fn news(&mut self) -> Option<News> {
        of_either!(self, controller => controller.news())
    }
}
