//! Real-time priority, if permitted.

use rustix::mm::{MlockAllFlags, mlockall};
use thread_priority::unix::{
    RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy,
    thread_native_id,
};
use thread_priority::{ThreadPriority, ThreadPriorityValue};

/// Priority among the real-time threads, 1 to 99. Assumption: above the usual for user programs, below the interrupt
/// threads of a kernel with PREEMPT_RT (50).
const PRIORITY: u8 = 40;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scheduling {
    #[default]
    Normal,
    /// `SCHED_FIFO` and locked memory.
    RealTime,
}

/// Requests the scheduling, and describes the result. Without permission the run goes on normally.
pub(super) fn ask(scheduling: Scheduling) -> String {
    if scheduling == Scheduling::Normal {
        return "normal".to_owned();
    }
    let mut told = Vec::new();
    let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let priority = ThreadPriorityValue::try_from(PRIORITY).map(ThreadPriority::Crossplatform);
    let asked = priority.map_err(|why| why.to_owned()).and_then(|priority| {
        set_thread_priority_and_policy(thread_native_id(), priority, fifo)
            .map_err(|why| why.to_string())
    });
    match asked {
        Ok(()) => told.push(format!("SCHED_FIFO {PRIORITY}")),
        Err(why) => {
            tracing::warn!(
                "no real-time priority: {why}; `hil doctor` shows the limit (rtprio) and how to raise it"
            );
            told.push("no real-time priority".to_owned());
        }
    }
    match mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE) {
        Ok(()) => told.push("memory locked".to_owned()),
        Err(why) => {
            tracing::warn!(
                "memory is not locked: {why}; `hil doctor` shows the limit (memlock) and how to raise it"
            );
            told.push("memory not locked".to_owned());
        }
    }
    told.join(", ")
}

#[cfg(test)]
mod tests {
    use super::{Scheduling, ask};

    #[test]
    fn nothing_is_asked_for_unless_wanted() {
        assert_eq!(ask(Scheduling::Normal), "normal");
    }
}
