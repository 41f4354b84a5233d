//! A controller of one's own in the simulated world, in the place of ours.
//!
//! [`HostedController`] is all that the world asks of one. [`Controller`] satisfies it; who brings another says by
//! [`Hosting`] how it is started for a run.

use controller::config::Config;
use controller::mission::{Mission, Report};
use controller::{Controller, Input, Output, Port};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use wire::device::{Device, PortId, Transmit};
use wire::time::Timestamp;

/// A controller without IO and without a clock: it is fed and emptied, and time is an argument.
///
/// After each of [`receive`](Self::receive), [`command`](Self::command) and [`wake`](Self::wake) the world takes what it
/// has to send and to tell, until there is none, and asks when it wants to be woken. All times are on one scale, which
/// begins with the run; only a fault of the controller's own clock makes them jump.
///
/// A plan begins once the controller has reported a [state](Report::State) of itself, and each table turn and lap asks for
/// one: a controller tells its state unasked too, once a second say.
pub trait HostedController: fmt::Debug + Send {
    /// Takes what arrived at a port: bytes of a serial line, as they come, or a CAN frame.
    fn receive(&mut self, now: Timestamp, port: Port, input: Input<'_>);

    /// Takes a mission. Each is answered once: done, refused or aborted.
    fn command(&mut self, now: Timestamp, mission: Mission);

    /// Does what is due `now`.
    fn wake(&mut self, now: Timestamp);

    /// When [`Self::wake`] has something to do, if nothing arrives before; [`Timestamp::MAX`]: never. A time that has
    /// passed means at once, which ends the run in an error where it goes on without end.
    fn next_wakeup(&self) -> Timestamp;

    /// What goes out next.
    fn transmit(&mut self, now: Timestamp) -> Option<Output>;

    /// The next report, oldest first.
    fn report(&mut self) -> Option<Report>;

    /// What is to be noted beside reports; asked behind them. A controller in Rust has nothing to note.
    fn news(&mut self) -> Option<News> {
        None
    }
}

/// What a controller that is a program may bring about beside reports.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum News {
    /// It said something that is no report.
    Note(String),
    /// It has ended, or never began: how.
    Ended(String),
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

/// The program of a controller in virtual time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ControllerProgram {
    /// `k2a-controller`.
    Ours,
    /// These words, with `{gyro}` and `{base}` for the ports.
    Words(Vec<String>),
}

type Start = dyn Fn(&Config) -> Box<dyn HostedController> + Send + Sync;

impl Hosting {
    /// `start` makes a controller for each run, at time zero; it is told the gyro's stream, how the base is connected,
    /// and the limits of motion.
    pub fn of<C>(start: impl Fn(&Config) -> C + Send + Sync + 'static) -> Self
    where
        C: HostedController + 'static,
    {
        Self(How::Own(Arc::new(move |config| Box::new(start(config)))))
    }

    /// A program plays it, started afresh for each run: missions go to its standard input, reports come from its standard
    /// output (`docs/virtual-time.md`).
    pub const fn program(program: ControllerProgram) -> Self {
        Self(How::Program(program))
    }

    /// As a summary names it.
    pub fn name(&self) -> String {
        match &self.0 {
            How::Ours | How::Own(_) => "in-process".to_owned(),
            How::Program(ControllerProgram::Ours) => "process".to_owned(),
            How::Program(ControllerProgram::Words(words)) => words.join(" "),
        }
    }

    /// The controller of one run; `program` starts one that is a program.
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

/// Devices of a test's own, in this process: what plays a node of a rig that is under test, by the node's name.
#[derive(Clone, Default)]
pub struct OwnDevices(BTreeMap<String, Arc<StartDevice>>);

type StartDevice = dyn Fn() -> Box<dyn NodeDevice> + Send + Sync;

/// What plays a node under test.
pub trait NodeDevice: Device + Send {
    /// It has ended by itself: how. Told once.
    fn ended(&mut self) -> Option<String>;
}

/// Rust code of a test, which does not end.
#[derive(Debug)]
struct Endless<D>(D);

impl<D: Device> Device for Endless<D> {
    fn receive(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        self.0.receive(now, port, what);
    }

    fn wake(&mut self, now: Timestamp) {
        self.0.wake(now);
    }

    fn next_wakeup(&self) -> Timestamp {
        self.0.next_wakeup()
    }

    fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        self.0.transmit(now)
    }
}

impl<D: Device> NodeDevice for Endless<D> {
    fn ended(&mut self) -> Option<String> {
        None
    }
}

impl OwnDevices {
    /// Adds what plays `node`; `start` makes one for each run, at time zero.
    pub fn add<D: Device + 'static>(
        &mut self,
        node: &str,
        start: impl Fn() -> D + Send + Sync + 'static,
    ) {
        self.0.insert(node.to_owned(), Arc::new(move || Box::new(Endless(start()))));
    }

    /// Somebody plays this node.
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

/// The controller of one run. Ours is known by its type: what happens with every byte costs no indirect call.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one in a run, and ours is the usual one")]
pub enum Hosted {
    Ours(Controller),
    Own(Box<dyn HostedController>),
}

impl Hosted {
    /// Ours.
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
