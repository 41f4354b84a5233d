//! Final judgement of a run in real time: the cause of its end, how well time was kept, and the traffic of the ports.

use super::LiveWorld;
use super::device_under_test::{DeviceUnderTest, Running};
use super::journal::{self, blame_bench};
use super::lateness::Lateness;
use super::losses::Losses;
use super::placement::Player;
use super::ports::{BASE, GYRO, OpenPort, Ports};
use super::role_port::RolePort;
use judge::properties::{Kind, PropertyVerdict, View};
use ports::PortSpec;
use ports::spec::SerialDevice;
use record::outcome::{Outcome, PortSide, PortSummary, Timing};
use rig::build::NOBODY;
use rig::ended::{Ended, judged};
use rig::engine::Ending;
use std::path::Path;
use std::sync::Arc;
use wire::time::Timestamp;

/// A run in real time, with its additional results.
#[derive(Debug, Clone)]
pub struct LiveEnd {
    pub run: Ended,
    /// How well real time was kept.
    pub timing: Timing,
    pub ports: Vec<PortSummary>,
    /// Files with the output of commands, beside that of the device under test.
    pub artifacts: Vec<String>,
}

/// A property that broke, or was not answered, because this machine was late is a failure of the bench.
pub(super) fn excuse(
    ending: Ending,
    properties: &[PropertyVerdict],
    lateness: &Lateness,
) -> Ending {
    let late = properties.iter().find_map(|verdict| {
        let broken = verdict.first_violation.as_ref().map(|violation| (violation.at, violation.at));
        let missing = verdict.never_judged.as_ref().filter(|_| verdict.kind == Kind::Always);
        let span = broken.or_else(|| missing.map(|missing| missing.span))?;
        lateness.verdict_on_violation(&verdict.name, span)
    });
    match (ending.outcome, late) {
        (Outcome::Passed | Outcome::Failed | Outcome::Timeout, Some(why)) => {
            blame_bench(ending, &why)
        }
        _ => ending,
    }
}

/// Why the end of a plan and its measurements say nothing about the device under test: the machine or the harness was late.
fn too_late(ending: Outcome, measured: Outcome, lateness: &Lateness) -> Option<String> {
    match ending.max(measured) {
        Outcome::Passed => lateness.verdict_on_pass(),
        Outcome::Failed | Outcome::Timeout => lateness.verdict_on_failure(),
        Outcome::Error | Outcome::Aborted => None,
    }
}

/// Whether the path of a serial port no longer leads anywhere.
fn is_gone(spec: &PortSpec) -> bool {
    let (PortSpec::Serial(serial) | PortSpec::Slcan { serial, .. }) = spec else { return false };
    matches!(&serial.device, SerialDevice::Path(path) if !Path::new(path).exists())
}

impl LiveWorld {
    /// What was lost at the ports.
    pub(super) fn losses(&self, ports: &Ports, device: &Running) -> Losses {
        let mut losses = Losses::default();
        let mut add = |role: &Arc<str>, side, port: &RolePort| {
            let absences = self.journal.absences(&(Arc::clone(role), side));
            let whose = journal::whose(role, side, port.name());
            losses.add((&whose, side), port.link(), &port.counters(), absences);
        };
        for OpenPort { plan, port, .. } in &ports.open {
            add(&plan.role, plan.side, port);
        }
        for role in [GYRO, BASE] {
            if let Some(port) = device.in_process().and_then(|here| here.port(role)) {
                add(&role.into(), PortSide::Controller, port);
            }
        }
        for OpenPort { plan, port, .. } in &ports.open {
            let Some(path) = port.unopened() else { continue };
            let line = &self.rig.lines[plan.line];
            let nodes = line.ends().iter().map(|end| &self.rig.nodes[end.node]);
            let away = nodes.filter(|node| node.is_away()).map(|node| &*node.name);
            let away = away.filter(|name| *name != NOBODY);
            losses.unopened(path, &plan.role, &Vec::from_iter(away));
        }
        losses
    }

    /// The outcome by the measurements alone.
    fn measured(&self) -> Outcome {
        let (declared, observations) =
            (&self.engine().plan().measurements, self.engine().observations());
        let no_truth = self.setting.sight().why_not(View::Truth);
        judged(declared, observations, no_truth.as_deref()).1
    }

    /// The ending, adjusted for problems of the ports and the machine.
    pub(super) fn judge(
        &self,
        ending: Ending,
        end: Timestamp,
        ports: &Ports,
        losses: &Losses,
    ) -> Ending {
        let ending = match (&losses.why, ending.outcome) {
            (None, _) | (_, Outcome::Error | Outcome::Aborted) => ending,
            (Some(why), _) => blame_bench(ending, why),
        };
        let ending = self.journal.explain(self.blame_missing(ending), end);
        let gyro = self.rig.robot().map(|robot| robot.bench.gyro_stream().format);
        let miswired = ports.miswired(gyro);
        let late = too_late(ending.outcome, self.measured(), &self.lateness);
        let unheard = losses.unheard.clone();
        let why = match ending.outcome {
            Outcome::Passed => late.or(unheard),
            Outcome::Failed | Outcome::Timeout => {
                let flooded = self.foreign.verdict(end, ports.name(BASE));
                // A flood makes a machine late, not the other way round.
                flooded.or(late).or(miswired).or(unheard)
            }
            Outcome::Error | Outcome::Aborted => None,
        };
        match why {
            Some(why) => blame_bench(ending, &why),
            None if self.foreign.frames() > 0 && ending.outcome != Outcome::Passed => {
                let then = ending.reason.unwrap_or_else(|| "no reason was given".to_owned());
                let (foreign, port) = (self.foreign.frames(), ports.name(BASE));
                let reason =
                    format!("{then}; {foreign} frames of other nodes crossed {port} meanwhile");
                Ending { reason: Some(reason), ..ending }
            }
            None => ending,
        }
    }

    /// A real device whose port only the controller has, in a process of its own: that the port is gone shows in its
    /// path alone.
    fn blame_missing(&self, ending: Ending) -> Ending {
        if self.setting.device_under_test == DeviceUnderTest::InProcess {
            return ending;
        }
        let gone = |role: &&str| {
            let spec = match self.setting.site.player(role) {
                Some(Player::Real(spec)) if self.setting.is_unheard(role) => spec,
                _ => return None,
            };
            is_gone(spec).then(|| format!("the {role}'s port {spec} is gone"))
        };
        match ([GYRO, BASE].iter().find_map(gone), ending.outcome) {
            (None, _) | (_, Outcome::Aborted) => ending,
            (Some(why), _) => blame_bench(ending, &why),
        }
    }

    pub(super) fn port_summaries(&self, ports: &Ports, device: &Running) -> Vec<PortSummary> {
        // The plan's side of a port comes before the device's.
        let mut order: Vec<usize> = (0..ports.open.len()).collect();
        order.sort_by_key(|place| {
            let far_of = ports.open[*place].plan.far_of;
            (far_of.unwrap_or(*place), far_of.is_none())
        });
        let summary = |place: usize| {
            let OpenPort { plan, port, .. } = &ports.open[place];
            self.journal.summary((Arc::clone(&plan.role), plan.side), port)
        };
        let mut summaries: Vec<PortSummary> = order.into_iter().map(summary).collect();
        for role in [GYRO, BASE] {
            if let Some(port) = device.in_process().and_then(|here| here.port(role)) {
                summaries.push(self.journal.summary((role.into(), PortSide::Controller), port));
            }
        }
        summaries
    }
}

#[cfg(test)]
mod tests {
    use super::super::lateness::Course;
    use super::{Ending, Lateness, Outcome, PropertyVerdict, Timestamp, excuse, too_late};
    use judge::properties::{Kind, Missing};
    use record::Violation;
    use wire::time::Span;

    /// Found by a user: a plan that went to its end, and failed by a measurement alone, was held against the device.
    #[test]
    fn a_measurement_that_failed_while_the_machine_was_late_is_excused() {
        let mut lateness = Lateness::new(Span::from_millis(20));
        assert_eq!(too_late(Outcome::Passed, Outcome::Failed, &lateness), None, "in time");
        lateness.add_machine(Timestamp::ZERO, Span::from_millis(30));
        lateness.end_step(Course { steps: 1, observations: 1 });
        let why = too_late(Outcome::Passed, Outcome::Failed, &lateness).unwrap();
        assert!(why.contains("other programs waited once"), "{why}");
        assert_eq!(
            too_late(Outcome::Passed, Outcome::Passed, &lateness),
            None,
            "it was harder to pass"
        );
    }

    #[test]
    fn what_broke_on_a_machine_that_was_late_is_the_fault_of_the_bench() {
        let at = Timestamp::from_nanos(9_000_000_000);
        let broken = PropertyVerdict {
            name: "fresh_heading".to_owned(),
            kind: Kind::Always,
            held: false,
            first_violation: Some(Violation { at, what: "an old one".to_owned() }),
            never_judged: None,
            margin: Some(-0.1),
            never_asked: None,
        };
        let passed = || Ending { outcome: Outcome::Passed, reason: None, lost: false };
        let mut lateness = Lateness::new(Span::from_millis(20));
        let ended = excuse(passed(), std::slice::from_ref(&broken), &lateness);
        assert_eq!(ended.outcome, Outcome::Passed, "in time: it counts");
        lateness.add_machine(at, Span::from_millis(300));
        let what = "not answered".to_owned();
        let unanswered = PropertyVerdict {
            first_violation: None,
            never_judged: Some(Missing { span: (at, at + Span::from_secs(1)), what }),
            ..broken.clone()
        };
        for verdict in [&broken, &unanswered] {
            let ended = excuse(passed(), std::slice::from_ref(verdict), &lateness);
            assert_eq!(ended.outcome, Outcome::Error);
        }
        let long_ago = PropertyVerdict {
            never_judged: Some(Missing {
                span: (at + Span::from_secs(60), at + Span::from_secs(61)),
                what: "not answered".to_owned(),
            }),
            ..unanswered
        };
        assert_eq!(excuse(passed(), &[long_ago], &lateness).outcome, Outcome::Passed);
        let ended = excuse(passed(), &[broken], &lateness);
        assert_eq!(ended.outcome, Outcome::Error);
        assert!(ended.reason.unwrap().contains("shortly before fresh_heading broke"));
        assert_eq!(excuse(passed(), &[], &lateness).outcome, Outcome::Passed);
    }
}
