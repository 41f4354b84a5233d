//! Unmodified programs that play nodes under test in virtual time. `docs/virtual-time.md` states the guarantees.

use crate::plan::Rig;
use ::controller::config::Config;
use ::controller::mission::{Mission, Report};
use ::controller::{Input, Output, Port};
use rig::hosted::{ControllerProgram, HostedController, News, NodeDevice};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use wire::time::Timestamp;

/// File name for the output of the device under test, or for its stderr if its stdout carries reports.
pub const DEVICE_LOG: &str = "device-under-test.log";

/// The programs of one run.
#[derive(Debug, Clone, Default)]
pub struct Programs {
    /// File for their output; `None` discards it.
    log: Option<PathBuf>,
    /// Set when the run is to end: a program that does not wait is killed.
    stop: Arc<AtomicBool>,
}

impl Programs {
    /// Keeps their output in this file; with several programs, each has its own file beside it.
    pub(crate) fn logging(&self, log: PathBuf) -> Self {
        Self { log: Some(log), ..self.clone() }
    }

    /// Kills a program that does not wait as soon as this is set.
    pub fn until(stop: Arc<AtomicBool>) -> Self {
        Self { log: None, stop }
    }

    /// Starts the program of a node by its place; `None` if the node is not a program.
    #[cfg(feature = "programs")]
    pub(crate) fn start(
        &self,
        rig: &Rig,
        place: usize,
    ) -> Option<Result<Box<dyn NodeDevice>, String>> {
        live::program::start_node((self.log.as_deref(), &self.stop), rig, place)
    }

    /// Starts nothing: this build has no support for programs.
    #[cfg(not(feature = "programs"))]
    pub(crate) fn start(&self, _: &Rig, _: usize) -> Option<Result<Box<dyn NodeDevice>, String>> {
        let _ = (&self.log, &self.stop);
        None
    }

    /// Starts the program of a controller for the devices in `config`.
    pub(crate) fn controller(
        &self,
        program: &ControllerProgram,
        config: &Config,
    ) -> Box<dyn HostedController> {
        self.started(program, config).unwrap_or_else(|why| Box::new(Absent(Some(why))))
    }

    #[cfg(feature = "programs")]
    fn started(
        &self,
        program: &ControllerProgram,
        config: &Config,
    ) -> Result<Box<dyn HostedController>, String> {
        live::program::start_controller((self.log.as_deref(), &self.stop), program, config)
    }

    #[cfg(not(feature = "programs"))]
    fn started(
        &self,
        program: &ControllerProgram,
        config: &Config,
    ) -> Result<Box<dyn HostedController>, String> {
        Err(format!("{program:?} of {config:?}: built without `programs`"))
    }
}

/// A controller that did not start; it only reports why.
#[derive(Debug)]
struct Absent(Option<String>);

impl HostedController for Absent {
    fn receive(&mut self, _: Timestamp, _: Port, _: Input<'_>) {}

    fn command(&mut self, _: Timestamp, _: Mission) {}

    fn wake(&mut self, _: Timestamp) {}

    fn next_wakeup(&self) -> Timestamp {
        Timestamp::MAX
    }

    fn transmit(&mut self, _: Timestamp) -> Option<Output> {
        None
    }

    fn report(&mut self) -> Option<Report> {
        None
    }

    fn news(&mut self) -> Option<News> {
        self.0.take().map(News::NotStarted)
    }
}
