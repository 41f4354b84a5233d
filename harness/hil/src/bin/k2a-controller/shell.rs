//! The loop: drives the controller on the real clock between its ports, its missions and its reports.

use crate::outlet::{LineSender, is_worth_telling};
use crate::port::{HEARD_MAX, Heard, Outgoing, role};
use crate::signals::Signals;
use controller::mission::{Command, Mission, Report, ReportLine};
use controller::{Controller, Input, Output, Port};
use live::world::{Alarm, Clock};
use std::fmt;
use tokio::sync::mpsc;
use tracing::{error, info, warn};
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

/// Time limit for the base to come to rest at the end; then the process ends anyway. The base continues to stop by
/// itself.
const STOP_MAX: Span = Span::from_secs(2);
/// Polling interval of the state at the end. Assumption: twice the control period of 27 ms.
const STOP_LOOK: Span = Span::from_millis(54);
/// At the end the base must report rest for this long: a message already in flight when the stop was sent may describe
/// the time before a motion began. As `MotionConfig::settle`.
const REST_MIN: Span = Span::from_millis(300);
/// Id of the missions that the shell itself gives at the end; their answers are not forwarded.
const SHELL_MISSION: u32 = 0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    MissionsClosed,
    /// No further report can be read.
    ReportsClosed,
    Signal(&'static str),
    /// A port vanished and did not come back.
    PortLost(Port),
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MissionsClosed => {
                f.write_str("no more missions: stdin was closed, or the client left")
            }
            Self::ReportsClosed => f.write_str("no reader: stdout was closed, or the client left"),
            Self::Signal(name) => f.write_str(name),
            Self::PortLost(port) => write!(f, "the {} port did not come back", role(*port)),
        }
    }
}

/// The controller and everything that it is connected to.
pub(crate) struct Shell {
    pub(crate) controller: Controller,
    pub(crate) clock: Clock,
    pub(crate) alarm: Alarm,
    pub(crate) heard: mpsc::Receiver<(Timestamp, Heard)>,
    pub(crate) missions: mpsc::Receiver<Mission>,
    pub(crate) gyro: Outgoing,
    /// `None` on a rotary table.
    pub(crate) base: Option<Outgoing>,
    pub(crate) reports: LineSender,
}

impl Shell {
    /// Runs until something ends it.
    ///
    /// At each moment the controller receives all pending input, is woken if it asked for that, and is asked for its
    /// output: as on the harness's rigs, so that it behaves the same in both.
    pub(crate) async fn run(&mut self, signals: &mut Signals) -> End {
        loop {
            self.pass_out(|_| true);
            let due = self.controller.next_wakeup();
            let mut lost = None;
            tokio::select! {
                // Polled in a fixed order, the same in every run.
                biased;
                name = signals.next() => return End::Signal(name),
                () = self.reports.closed() => return End::ReportsClosed,
                Some((at, heard)) = self.heard.recv() => lost = self.take(at, heard),
                mission = self.missions.recv() => match mission {
                    Some(mission) => self.controller.command(self.clock.now(), mission),
                    None => return End::MissionsClosed,
                },
                () = rung(&self.alarm, self.clock, due) => {}
            }
            lost = lost.or(self.catch_up().await);
            while let Ok(mission) = self.missions.try_recv() {
                self.controller.command(self.clock.now(), mission);
            }
            if let Some(port) = lost {
                return End::PortLost(port);
            }
            self.wake_if(due);
        }
    }

    /// Waits for `next` and meanwhile serves the devices, without any reports.
    pub(crate) async fn wait_for<T>(
        &mut self,
        signals: &mut Signals,
        next: impl Future<Output = T>,
    ) -> Result<T, End> {
        let mut next = std::pin::pin!(next);
        loop {
            self.pass_out(|_| false);
            let due = self.controller.next_wakeup();
            tokio::select! {
                biased;
                name = signals.next() => return Err(End::Signal(name)),
                next = &mut next => return Ok(next),
                Some((at, heard)) = self.heard.recv() => {
                    if let Some(port) = self.take(at, heard) {
                        return Err(End::PortLost(port));
                    }
                }
                () = rung(&self.alarm, self.clock, due) => {}
            }
            self.wake_if(due);
        }
    }

    /// Takes all input that has arrived before time advances: after a moment without the processor, input and time-outs
    /// are due together, and a device that has sent something is not silent.
    async fn catch_up(&mut self) -> Option<Port> {
        // One turn for the system to signal new bytes, one for the ports to read them.
        for _ in 0..2 {
            tokio::task::yield_now().await;
        }
        let mut lost = None;
        for _ in 0..HEARD_MAX {
            let Ok((at, heard)) = self.heard.try_recv() else {
                break;
            };
            lost = lost.or(self.take(at, heard));
        }
        lost
    }

    /// Commands the base to stop until it has reported rest for a while. Returns `false` if it did not in time.
    pub(crate) async fn bring_to_rest(&mut self) -> bool {
        // Pending reports belong to the clients' missions.
        self.pass_out(|_| true);
        let begin = self.clock.now();
        self.controller.command(begin, shell_mission(Command::Stop));
        let mut at_rest_since = None;
        let mut look = begin;
        loop {
            let mut moving = None;
            self.pass_out(|report| {
                if let Report::State(state) = report {
                    moving = Some(state.moving);
                }
                // Only the shell's own missions are kept back.
                !matches!(report, Report::Done { id: SHELL_MISSION, .. })
            });
            if self.base.is_none() {
                return true;
            }
            let now = self.clock.now();
            match moving {
                Some(true) => at_rest_since = None,
                Some(false) => at_rest_since = at_rest_since.or(Some(now)),
                None => {}
            }
            if at_rest_since.is_some_and(|since| now - since >= REST_MIN)
                && self.base.as_ref().is_none_or(Outgoing::is_empty)
            {
                return true;
            }
            if now - begin >= STOP_MAX {
                return false;
            }
            if now >= look {
                look = now + STOP_LOOK;
                self.controller.command(now, shell_mission(Command::RequestState));
                continue;
            }
            let due = self.controller.next_wakeup();
            let wake = due.min(look).min(begin + STOP_MAX);
            tokio::select! {
                biased;
                Some((at, heard)) = self.heard.recv() => {
                    // A port that is lost now is treated as silent.
                    let _ = self.take(at, heard);
                }
                () = rung(&self.alarm, self.clock, wake) => {
                    let _ = self.catch_up().await;
                }
            }
            self.wake_if(due);
        }
    }

    /// Logs how the run ended and what was lost.
    pub(crate) fn log_end(&self, end: End, at_rest: bool, lines_refused: u64) {
        let (gyro_dropped, base_dropped) =
            (self.gyro.dropped(), self.base.as_ref().map_or(0, Outgoing::dropped));
        let reports_lost = self.reports.lost();
        info!(lines_refused, reports_lost, gyro_dropped, base_dropped, "ended: {end}");
        if !at_rest {
            error!(
                "the base was told to stop and has not said in {} s that it is at rest",
                STOP_MAX.as_secs_f64()
            );
        }
    }

    /// Hands received input to the controller; returns the port if it is lost for good.
    fn take(&mut self, at: Timestamp, heard: Heard) -> Option<Port> {
        match heard {
            Heard::Unit(port, Transmit::Bytes(bytes)) => {
                self.controller.receive(at, port, Input::Bytes(bytes.as_slice()));
            }
            Heard::Unit(port, Transmit::Frame(frame)) => {
                self.controller.receive(at, port, Input::Frame(frame));
            }
            Heard::GivenUp(port) => return Some(port),
        }
        None
    }

    /// Wakes the controller if its wake-up time has come.
    fn wake_if(&mut self, due: Timestamp) {
        let now = self.clock.now();
        if now >= due {
            self.controller.wake(now);
        }
    }

    /// Sends all outputs, and those reports that `wanted` accepts.
    fn pass_out(&mut self, mut wanted: impl FnMut(&Report) -> bool) {
        let now = self.clock.now();
        while let Some(output) = self.controller.transmit(now) {
            let (link, unit) = match output {
                Output::Bytes(Port::Gyro, packet) => (Some(&self.gyro), Transmit::Bytes(packet)),
                Output::Bytes(Port::Base, packet) => (self.base.as_ref(), Transmit::Bytes(packet)),
                Output::Frame(frame) => (self.base.as_ref(), Transmit::Frame(frame)),
            };
            if let Some(link) = link {
                link.send(unit);
            }
        }
        while let Some(report) = self.controller.report() {
            if wanted(&report) {
                self.tell(ReportLine { at: now, report });
            }
        }
    }

    fn tell(&self, line: ReportLine) {
        let lost = self.reports.lost();
        match serde_json::to_vec(&line) {
            Ok(mut text) => {
                text.push(b'\n');
                // States are repeated; answers and changes of health are not.
                if matches!(line.report, Report::State(_)) {
                    self.reports.send_minor(text);
                } else {
                    self.reports.send(text);
                }
            }
            Err(cause) => error!(%cause, "a report cannot be written as JSON"),
        }
        let count = self.reports.lost();
        if count > lost && is_worth_telling(count) {
            warn!(count, "report lost: they are not read fast enough");
        }
    }
}

const fn shell_mission(command: Command) -> Mission {
    Mission { id: SHELL_MISSION, command }
}

/// Waits until `due`; a missing timer must not stop the controller.
async fn rung(alarm: &Alarm, clock: Clock, due: Timestamp) {
    if alarm.at(due).await.is_err() {
        clock.sleep_until(due).await;
    }
}
