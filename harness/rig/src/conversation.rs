//! Collects what controllers and the plan send in virtual time, after an event has reached them.

use super::node::{Part, output};
use super::simulate::Simulation;
use super::touched::Touched;
use crate::engine::Action;
use crate::hosted::{Hosted, HostedController as _, News};
use crate::talk::{START_LIMIT, Talk};
use crate::{Keep, Sink};
use controller::mission::{Mission, Report};
use judge::properties::Seen;
use record::{Device, Record, RecordKind};
use wire::time::Timestamp;

impl Simulation {
    pub(super) fn ask_controller(&mut self, place: usize, sink: Sink<'_>) {
        let Part::Controller(machine) = &mut self.rig.nodes[place].part else { return };
        if machine.host.is_stalled() {
            // It is marked again when its machine resumes.
            return;
        }
        let told = machine.host.told(self.now);
        loop {
            let Part::Controller(machine) = &mut self.rig.nodes[place].part else { return };
            let Some(sent) = machine.host.guest.transmit(told) else { break };
            self.show(&Seen::Sent(&sent));
            let (port, what) = output(sent);
            self.rig.send(self.now, place, port, what);
        }
        loop {
            let Part::Controller(machine) = &mut self.rig.nodes[place].part else { return };
            let Some(report) = machine.host.guest.report() else {
                machine.ask_due();
                let Some(news) = machine.host.guest.news() else { return };
                let may_go_on = matches!(news, News::Note(_));
                self.hear_news(sink, place, news);
                if may_go_on {
                    continue;
                }
                return;
            };
            self.hear_report(sink, &report);
        }
    }

    /// Separate and cold: only programs have news.
    #[cold]
    fn hear_news(&mut self, sink: Sink<'_>, place: usize, news: News) {
        let Self { now, rig, director, touched, .. } = self;
        match news {
            News::Note(_) if director.talk.exceeds(*now) => {
                director.engine.failed(*now, &Talk::why());
                touched.0 |= Touched::PLAN;
            }
            News::Note(note) => {
                if director.talk.misspoke() {
                    let kind = RecordKind::Note(note);
                    sink.record(Record { at: *now, device: Device::Controller, kind });
                }
            }
            News::Misreport(what) => {
                director.engine.failed(*now, &what);
                touched.node(place);
                touched.0 |= Touched::PLAN;
            }
            News::NotStarted(why) => {
                director.engine.broke(*now, &why);
                touched.0 |= Touched::PLAN;
            }
            News::Ended(how) => {
                director.engine.lost_controller(*now, &how);
                touched.0 |= Touched::PLAN;
            }
            News::GivenUp => {
                director.engine.abort(*now);
                touched.0 |= Touched::PLAN;
            }
        }
        if let Part::Controller(machine) = &mut rig.nodes[place].part {
            machine.ask_due();
        }
    }

    /// Separate and not inlined: reports are rare and large, and their stack space must not burden every event.
    #[inline(never)]
    fn hear_report(&mut self, sink: Sink<'_>, report: &Report) {
        if self.director.talk.floods(self.now) {
            self.director.engine.failed(self.now, &Talk::why());
            self.touched.0 |= Touched::PLAN;
            return;
        }
        self.show(&Seen::Report(report));
        self.director.record_report(self.now, &mut self.rig, sink, report);
        self.director.engine.report(self.now, report);
        self.touched.0 |= Touched::PLAN;
    }

    /// Not inlined for the same reason: an action may hold a whole calibration.
    #[inline(never)]
    pub(super) fn ask_engine(&mut self, sink: Sink<'_>, keep: Keep<'_>) {
        while let Some(action) = self.director.engine.action() {
            // An action may have reached any node.
            self.touched = Touched::ALL;
            if let (Some(watch), Some(robot)) = (&mut self.watch, self.rig.robot()) {
                watch.look(self.now, &robot.bench);
                watch.see_action(self.now, &action);
            }
            if let Action::Phase(event) = &action {
                if let Some(faults) = &mut self.faults {
                    faults.phase(self.now, event);
                } else if let Some(phases) = &mut self.phases {
                    phases.push((self.now, event.clone()));
                }
                continue;
            }
            if let Some(mission) = self.director.act(self.now, &mut self.rig, sink, keep, action) {
                self.order(mission);
            }
        }
        self.plan_due = self.director.engine.next_wakeup();
        if !self.director.engine.is_heard() && !self.director.engine.is_ending() {
            self.plan_due = self.plan_due.min(self.start_limit());
        }
    }

    /// When a controller must have reported a state. Ours does so at once, unless a fault keeps it from that.
    fn start_limit(&self) -> Timestamp {
        let is_own = |part: &Part| match part {
            Part::Controller(machine) => matches!(machine.host.guest, Hosted::Own(_)),
            _ => false,
        };
        match self.rig.nodes.iter().any(|node| is_own(&node.part)) {
            true => Timestamp::ZERO + START_LIMIT,
            false => Timestamp::MAX,
        }
    }

    /// The first step waits for a state; other reports do not count.
    #[cold]
    pub(super) fn wait_for_state(&mut self) {
        if self.now < self.start_limit() {
            return;
        }
        let why = format!("the device under test {}", self.director.talk.why_silent(START_LIMIT));
        self.director.engine.failed(self.now, &why);
        self.touched.0 |= Touched::PLAN;
    }

    /// Shows an event to the monitor, after the truth of now.
    pub(super) fn show(&mut self, seen: &Seen<'_>) {
        let Some(watch) = &mut self.watch else { return };
        if let Some(robot) = self.rig.robot() {
            watch.look(self.now, &robot.bench);
        }
        watch.see(self.now, seen);
    }

    pub(super) fn order(&mut self, mission: Mission) {
        let machine = self.rig.nodes.iter_mut().find_map(|node| match &mut node.part {
            Part::Controller(machine) => Some(machine),
            _ => None,
        });
        if let Some(machine) = machine {
            machine.host.command(self.now, mission);
        }
    }
}
