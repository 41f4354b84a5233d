//! Reports: the state, and a queue of bounded size.

use super::{Controller, REPORTS_MAX, STATE_PERIOD_AT_REST, Task};
use crate::bias_test::RunningMean;
use crate::mission::{Activity, Report, State};
use crate::mutant::Mutant;
use heapless::Deque;
use wire::time::Timestamp;
use wire::units::AngularRate;

impl Controller {
    pub(super) fn activity(&self) -> Activity {
        match &self.task {
            Task::Idle => Activity::Idle,
            Task::BiasTest { .. } => Activity::BiasTest,
            Task::Drive(drive) => drive.activity(),
            Task::PoseDownload(..) => Activity::PoseDownload,
        }
    }

    pub(super) fn report_state(&mut self, now: Timestamp) {
        let heading = self.heading();
        let integrator = self.gyro.integrator();
        let straight = matches!(&self.task, Task::Drive(drive) if drive.is_straight());
        let called_rest = self.stopping && self.plants(Mutant::StopCalledRest);
        let state = State {
            activity: self.activity(),
            pose: self.reckoning.pose(heading),
            gyro_heading: integrator.heading(),
            odometry_heading: self.reckoning.odometry_heading(),
            displacement: self.reckoning.displacement(),
            heading_error: straight.then(|| self.reference - heading),
            raw_rate: AngularRate::from_rad_per_s(self.raw_rate.mean()),
            bias: integrator.bias(),
            temperature: integrator.temperature(),
            moving: self.is_moving(now) && !called_rest,
            samples: integrator.samples(),
            samples_lost: integrator.samples_lost(),
            clock_ratio: integrator.clock_ratio(),
            health: self.health,
            uncertainty: self.uncertainty(),
        };
        self.last_raw_rate = self.mean_raw_rate();
        self.raw_rate = RunningMean::default();
        self.state_at = now + STATE_PERIOD_AT_REST;
        self.push_report(Report::State(state));
    }

    /// Drops the oldest state to make room for a new report; without one, the new report is lost.
    pub(super) fn push_report(&mut self, report: Report) {
        if let Err(report) = self.reports.push_back(report) {
            self.reports_lost = true;
            let mut kept: Deque<Report, REPORTS_MAX> = Deque::new();
            let mut made_room = false;
            while let Some(waiting) = self.reports.pop_front() {
                if !made_room && matches!(waiting, Report::State(_)) {
                    made_room = true;
                } else {
                    // Cannot fail: same capacity.
                    let _ = kept.push_back(waiting);
                }
            }
            self.reports = kept;
            let _ = self.reports.push_back(report);
        }
    }
}
