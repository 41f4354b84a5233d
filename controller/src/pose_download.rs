//! Writing the dead-reckoned pose to the base: at rest only, repeated after a refusal.

use crate::config::MotionConfig;
use crate::mission::{MissionId, MissionResult};
use wire::base::{Motion, POSE_WRITE_MODULUS, PoseWriteResult, Request};
use wire::time::Timestamp;
use wire::units::Pose;

/// A pose on its way to the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PoseDownload {
    pub(crate) id: MissionId,
    /// Result of the mission, reported once the pose is written.
    pub(crate) result: MissionResult,
    pose: Pose,
    counter: u8,
    attempts: u8,
    retry_at: Timestamp,
}

/// Progress of a download.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Progress {
    /// Send this.
    Write(Request),
    /// Nothing to send yet.
    Waiting,
    /// Written, after this many attempts.
    Written(u8),
    /// Refused at every attempt.
    Refused,
}

impl PoseDownload {
    /// `counter` is that of the last write, from any source.
    pub(crate) const fn new(
        id: MissionId,
        pose: Pose,
        result: MissionResult,
        counter: u8,
        now: Timestamp,
    ) -> Self {
        Self { id, result, pose, counter, attempts: 0, retry_at: now }
    }

    /// Checks the base's last answer, `None` before the first answer since the last write.
    pub(crate) fn step(
        &mut self,
        now: Timestamp,
        motion: &Motion,
        config: &MotionConfig,
    ) -> Progress {
        let answered = self.attempts > 0 && motion.pose_write_counter == self.counter;
        if answered && motion.pose_write == PoseWriteResult::Accepted {
            return Progress::Written(self.attempts);
        }
        if now < self.retry_at {
            return Progress::Waiting;
        }
        if self.attempts >= config.pose_writes_max {
            return Progress::Refused;
        }
        self.attempts += 1;
        self.counter = (self.counter + 1) % POSE_WRITE_MODULUS;
        self.retry_at = now + config.pose_write_retry;
        Progress::Write(Request::WritePose {
            pose: Pose { heading: self.pose.heading.wrapped(), ..self.pose },
            counter: self.counter,
        })
    }

    /// True after the first attempt.
    pub(crate) const fn is_under_way(&self) -> bool {
        self.attempts > 0
    }

    /// Counter of the last write.
    pub(crate) const fn counter(&self) -> u8 {
        self.counter
    }

    /// Time of the next check without a message.
    pub(crate) const fn retry_at(&self) -> Timestamp {
        self.retry_at
    }
}

#[cfg(test)]
mod tests {
    use super::{MissionResult, Motion, Pose, PoseDownload, PoseWriteResult, Progress, Request};
    use crate::config::MotionConfig;
    use wire::time::{Span, Timestamp};

    fn counter_of(progress: Progress) -> u8 {
        match progress {
            Progress::Write(Request::WritePose { counter, .. }) => counter,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_refusal_is_tried_again_and_an_old_answer_is_not_taken_for_a_new_one() {
        let config = MotionConfig::default();
        let mut now = Timestamp::ZERO;
        let mut download = PoseDownload::new(7, Pose::default(), MissionResult::Applied, 2, now);
        let mut motion = Motion {
            pose_write: PoseWriteResult::Accepted,
            pose_write_counter: 2,
            ..Motion::default()
        };
        assert_eq!(counter_of(download.step(now, &motion, &config)), 3);
        assert_eq!(download.step(now, &motion, &config), Progress::Waiting, "old answer");
        motion.pose_write = PoseWriteResult::RefusedInMotion;
        motion.pose_write_counter = 3;
        assert_eq!(download.step(now, &motion, &config), Progress::Waiting, "not at once");
        now += config.pose_write_retry;
        assert_eq!(counter_of(download.step(now, &motion, &config)), 0, "wraps");
        motion.pose_write = PoseWriteResult::Accepted;
        motion.pose_write_counter = 0;
        assert_eq!(download.step(now, &motion, &config), Progress::Written(2));
    }

    #[test]
    fn it_gives_up_after_the_last_attempt() {
        let config = MotionConfig::default();
        let mut now = Timestamp::ZERO;
        let mut download = PoseDownload::new(7, Pose::default(), MissionResult::Applied, 0, now);
        let mut writes = 0;
        loop {
            match download.step(now, &Motion::default(), &config) {
                Progress::Write(_) => writes += 1,
                Progress::Refused => break,
                other => assert_eq!(other, Progress::Waiting),
            }
            now += Span::from_millis(100);
        }
        assert_eq!(writes, config.pose_writes_max);
    }
}
