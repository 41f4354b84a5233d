//! Programs of nodes under test in virtual time: anybody's, unmodified. `docs/virtual-time.md` says what that guarantees.

use crate::hosted::NodeDevice;
use crate::plan::Rig;
#[cfg(feature = "programs")]
use crate::plan::rig::{NodePart, RigNode, UnderTest};
#[cfg(feature = "programs")]
use described::Medium;
#[cfg(feature = "programs")]
use lockstep::{Lockstep, Output, Program};
#[cfg(feature = "programs")]
use std::collections::BTreeMap;
use std::path::PathBuf;
#[cfg(feature = "programs")]
use wire::device::{Device, PortId, Transmit};
#[cfg(feature = "programs")]
use wire::time::{Span, Timestamp};

/// What a program has to end after SIGTERM, as on a bench.
#[cfg(feature = "programs")]
const STOPPING: Span = Span::from_secs(3);

/// The longest name of an interface (`IFNAMSIZ`).
#[cfg(feature = "programs")]
const INTERFACE_BYTES_MAX: usize = 15;

/// Name of the file that keeps what the device under test printed, or its stderr where its stdout is for reports.
pub const DEVICE_LOG: &str = "device-under-test.log";

/// The programs of one run.
#[derive(Debug, Clone, Default)]
pub struct Programs {
    /// Where what they print is kept; nowhere without.
    log: Option<PathBuf>,
}

impl Programs {
    /// What they print is kept in this file; with several programs in one beside it each.
    pub(crate) const fn logging(log: PathBuf) -> Self {
        Self { log: Some(log) }
    }

    /// Starts the program of a node by its place; none where nothing is to be started.
    #[cfg(not(feature = "programs"))]
    pub(crate) fn start(&self, _: &Rig, _: usize) -> Option<Result<Box<dyn NodeDevice>, String>> {
        let _ = &self.log;
        None
    }

    /// Starts the program of a node by its place; none where nothing is to be started.
    #[cfg(feature = "programs")]
    pub(crate) fn start(
        &self,
        rig: &Rig,
        place: usize,
    ) -> Option<Result<Box<dyn NodeDevice>, String>> {
        let node = &rig.nodes[place];
        let NodePart::UnderTest(UnderTest::Command(words)) = &node.part else { return None };
        let started = self.started(rig, node, words);
        Some(started.map(|running| Box::new(running) as Box<dyn NodeDevice>))
    }

    #[cfg(feature = "programs")]
    fn started(&self, rig: &Rig, node: &RigNode, words: &[String]) -> Result<InStep, String> {
        let ports = ports(rig);
        let words = crate::live::command::fill(words, &ports).map_err(|error| error.to_string())?;
        let mut program = Program::new(words);
        // What it draws from the system would differ from run to run.
        if std::env::var_os("PYTHONHASHSEED").is_none() {
            program = program.env("PYTHONHASHSEED", "0");
        }
        for line in &node.lines {
            let name = &ports[rig.line_name(*line)];
            program = match rig.lines.get(*line).map(|line| line.medium) {
                Some(Medium::Serial(_)) => program.serial(name),
                Some(Medium::Can) | None => program.can(name),
            };
        }
        if let Some(log) = &self.log {
            let is_alone = rig.under_test().count() == 1;
            let log = match is_alone {
                true => log.clone(),
                false => log.with_extension(format!("{}.log", node.name)),
            };
            program = program.output(Output::File(log));
        }
        let running = program.start().map_err(|error| {
            let cause = std::error::Error::source(&error).map(|cause| format!(": {cause}"));
            format!("failed to start `{}`: {error}{}", node.name, cause.unwrap_or_default())
        })?;
        Ok(InStep { running, now: Timestamp::ZERO, is_told: false })
    }
}

/// What programs open: the port of each line by the line's name. No such file or interface need exist.
#[cfg(feature = "programs")]
fn ports(rig: &Rig) -> BTreeMap<String, String> {
    let port = |(place, line): (usize, &crate::plan::rig::RigLine)| {
        let port = match line.medium {
            Medium::Serial(_) => format!("/dev/ttyHIL{place}"),
            Medium::Can if line.name.len() <= INTERFACE_BYTES_MAX => line.name.clone(),
            Medium::Can => format!("hil{place}"),
        };
        (line.name.clone(), port)
    };
    rig.lines.iter().enumerate().map(port).collect()
}

/// A program in step with the world.
#[cfg(feature = "programs")]
#[derive(Debug)]
struct InStep {
    running: Lockstep,
    now: Timestamp,
    /// Its end was asked for.
    is_told: bool,
}

#[cfg(feature = "programs")]
impl Device for InStep {
    fn receive(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        self.now = now;
        self.running.receive(now, port, what);
    }

    fn wake(&mut self, now: Timestamp) {
        self.now = now;
        self.running.wake(now);
    }

    fn next_wakeup(&self) -> Timestamp {
        // At once: its end is news.
        let has_news = !self.is_told && self.running.ended().is_some();
        if has_news { Timestamp::ZERO } else { self.running.next_wakeup() }
    }

    fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        self.running.transmit(now)
    }
}

#[cfg(feature = "programs")]
impl NodeDevice for InStep {
    fn ended(&mut self) -> Option<String> {
        let ended = self.running.ended().filter(|_| !self.is_told)?;
        self.is_told = true;
        let words = self.running.last_words();
        let last = words.lines().rfind(|line| !line.trim().is_empty());
        let last = last.map(|line| format!("; its last words: {line}")).unwrap_or_default();
        Some(format!("{ended}{last}"))
    }
}

/// As on a bench: it may put its things in order, and is killed where it does not.
#[cfg(feature = "programs")]
impl Drop for InStep {
    fn drop(&mut self) {
        self.running.stop(self.now, STOPPING);
    }
}
