//! One processor for a program and for whoever runs it. Only one of them runs at a time, and to wake somebody on another
//! processor takes longer than to change places: it costs half of the speed.

use rustix::thread::{CpuSet, Pid, gettid, sched_getaffinity, sched_getcpu, sched_setaffinity};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// How many places are taken on each processor.
static TAKEN: Mutex<[u16; CpuSet::MAX_CPU]> = Mutex::new([0; CpuSet::MAX_CPU]);

fn taken() -> MutexGuard<'static, [u16; CpuSet::MAX_CPU]> {
    TAKEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The thread that took it runs on one processor, and so does all that it starts; until it is dropped.
#[derive(Debug)]
pub(crate) struct Place {
    thread: Pid,
    before: CpuSet,
    processor: usize,
}

impl Place {
    /// On the processor where fewest are, and there already if that may be. None where there is no choice, or the system
    /// allows none.
    pub(crate) fn take() -> Option<Self> {
        let before = sched_getaffinity(None).ok().filter(|before| before.count() > 1)?;
        let here = sched_getcpu();
        let mut taken = taken();
        let allowed = (0..CpuSet::MAX_CPU).filter(|processor| before.is_set(*processor));
        let processor = allowed.min_by_key(|one| (taken[*one], *one != here))?;
        let mut one = CpuSet::new();
        one.set(processor);
        sched_setaffinity(None, &one).ok()?;
        taken[processor] = taken[processor].saturating_add(1);
        Some(Self { thread: gettid(), before, processor })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut taken = taken();
        taken[self.processor] = taken[self.processor].saturating_sub(1);
        // The thread may have ended by now, which is as well.
        let _ = sched_setaffinity(Some(self.thread), &self.before);
    }
}

#[cfg(test)]
mod tests {
    use super::{Place, sched_getaffinity};
    use std::thread;

    #[test]
    fn a_thread_keeps_to_one_processor_and_is_free_again() {
        let run = || {
            let before = sched_getaffinity(None).unwrap();
            if before.count() < 2 {
                return;
            }
            let place = Place::take().unwrap();
            assert_eq!(sched_getaffinity(None).unwrap().count(), 1);
            // Who has no choice takes no place, and another thread another processor.
            assert!(Place::take().is_none());
            let other = thread::spawn(move || {
                let free = before;
                rustix::thread::sched_setaffinity(None, &free).unwrap();
                let other = Place::take().unwrap();
                other.processor
            });
            assert_ne!(other.join().unwrap(), place.processor);
            drop(place);
            assert_eq!(sched_getaffinity(None).unwrap(), before);
        };
        thread::spawn(run).join().unwrap();
    }
}
