//! A controller program in step with the world: missions go to its standard input, reports come from its standard
//! output, as in real time.

use super::in_step::{STOPPING, in_words, in_words_of};
use crate::command::{can_start, fill};
use crate::process::{Unread, line_of, report_of};
use crate::world::controller_words;
use controller::config::{Config, Transport};
use controller::mission::{Mission, Report};
use controller::{Input, Output, Port};
use lockstep::{Ended, Lockstep, Output as Printed, Said};
use rig::hosted::{ControllerProgram, HostedController, News};
use rig::node::{BASE, GYRO};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use wire::base::serial_link;
use wire::device::{Device as _, PortId, Transmit};
use wire::packet::{BYTES_MAX, Packet};
use wire::time::Timestamp;

/// Path that the program opens for the gyro.
const GYRO_PORT: &str = "/dev/ttyHIL0";
/// Path that the program opens for a base on a serial line.
const BASE_PORT: &str = "/dev/ttyHIL1";
const BASE_INTERFACE: &str = "base";

/// Starts the program; its output other than reports goes to `log`. It is killed once `stop` is set and it does not
/// wait.
pub fn start(
    (log, stop): (Option<&Path>, &Arc<AtomicBool>),
    program: &ControllerProgram,
    config: &Config,
) -> Result<Box<dyn HostedController>, String> {
    let transport = config.base.map(|base| base.transport);
    let words = match program {
        ControllerProgram::Words(words) => words.clone(),
        ControllerProgram::Ours => {
            let base = match transport {
                None => "none",
                Some(Transport::Can) => "can:{base}",
                Some(Transport::Serial) => "serial:{base}",
            };
            controller_words(config, "{gyro}", base)
        }
    };
    let base = match transport {
        None => None,
        Some(Transport::Can) => Some(BASE_INTERFACE),
        Some(Transport::Serial) => Some(BASE_PORT),
    };
    let mut ports = BTreeMap::from([("gyro".to_owned(), GYRO_PORT.to_owned())]);
    ports.extend(base.map(|base| ("base".to_owned(), base.to_owned())));
    let words = fill(&words, &ports).map_err(|error| error.to_string())?;
    can_start(&words).map_err(|reason| format!("failed to start `controller`: {reason}"))?;
    let gyro = config.gyro.stream.format.serial();
    let mut program = in_words(words).serial_at(GYRO_PORT, gyro).talks().until(Arc::clone(stop));
    program = match transport {
        None => program,
        Some(Transport::Can) => program.can(BASE_INTERFACE),
        Some(Transport::Serial) => program.serial_at(BASE_PORT, serial_link::SETTINGS),
    };
    if let Some(log) = log {
        program = program.output(Printed::File(log.to_owned()));
    }
    let running = program.start().map_err(|error| super::in_step::why("controller", &error))?;
    Ok(Box::new(ControllerInStep::new(running)))
}

#[derive(Debug)]
struct ControllerInStep {
    running: Lockstep,
    now: Timestamp,
    /// Number of lines that it has written.
    lines: u64,
    /// A line that is not a report.
    note: Option<News>,
    /// It no longer takes missions.
    is_deaf: bool,
    /// Its end was reported.
    is_told: bool,
}

impl ControllerInStep {
    const fn new(running: Lockstep) -> Self {
        let now = Timestamp::ZERO;
        Self { running, now, lines: 0, note: None, is_deaf: false, is_told: false }
    }

    fn hear(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        self.now = now;
        self.running.receive(now, port, what);
    }
}

impl HostedController for ControllerInStep {
    fn receive(&mut self, now: Timestamp, port: Port, input: Input<'_>) {
        let at = if port == Port::Gyro { GYRO } else { BASE };
        match input {
            Input::Frame(frame) => self.hear(now, at, &Transmit::Frame(frame)),
            Input::Bytes(bytes) => {
                for packet in bytes.chunks(BYTES_MAX).filter_map(Packet::from_slice) {
                    self.hear(now, at, &Transmit::Bytes(packet));
                }
            }
        }
    }

    fn command(&mut self, now: Timestamp, mission: Mission) {
        self.now = now;
        let line = line_of(&mission);
        let is_taken = line.is_some_and(|line| self.running.tell(now, &line));
        self.is_deaf |= !is_taken && self.running.ended().is_none();
    }

    fn wake(&mut self, now: Timestamp) {
        self.now = now;
        self.running.wake(now);
    }

    fn next_wakeup(&self) -> Timestamp {
        self.running.next_wakeup()
    }

    fn transmit(&mut self, now: Timestamp) -> Option<Output> {
        self.now = now;
        let (port, what) = self.running.transmit(now)?;
        let at = if port == GYRO { Port::Gyro } else { Port::Base };
        Some(match what {
            Transmit::Bytes(packet) => Output::Bytes(at, packet),
            Transmit::Frame(frame) => Output::Frame(frame),
        })
    }

    fn report(&mut self) -> Option<Report> {
        while self.note.is_none() {
            let said = self.running.said()?;
            self.lines += 1;
            let line = match &said {
                Said::Line(line) => Some(line.as_slice()),
                Said::Lost => None,
            };
            match report_of(line) {
                None => {}
                Some(Ok(line)) => return Some(line.report),
                Some(Err(Unread { cause, is_grave })) => {
                    let number = self.lines;
                    let what = format!("line {number} of the device under test: {cause}");
                    self.note =
                        Some(if is_grave { News::Misreport(what) } else { News::Note(what) });
                }
            }
        }
        None
    }

    fn news(&mut self) -> Option<News> {
        if let Some(note) = self.note.take() {
            return Some(note);
        }
        if self.is_told {
            return None;
        }
        let how = match self.running.ended() {
            Some(Ended::GivenUp) => {
                self.is_told = true;
                return Some(News::GivenUp);
            }
            Some(ended) => in_words_of(ended, &self.running),
            None if self.is_deaf => "does not read its missions".to_owned(),
            None => return None,
        };
        self.is_told = true;
        Some(News::Ended(how))
    }
}

/// As on a bench, the program may shut down in order, and is killed if it does not.
impl Drop for ControllerInStep {
    fn drop(&mut self) {
        self.running.stop(self.now, STOPPING);
    }
}
