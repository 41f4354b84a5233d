//! One processor for a program and the thread that runs it. Only one of them runs at a time, and waking a thread on
//! another processor takes longer than a switch on the same one: it would halve the speed.

use rustix::thread::{CpuSet, Pid, gettid, sched_getaffinity, sched_getcpu, sched_setaffinity};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Number of places taken on each processor.
static TAKEN: Mutex<[u16; CpuSet::MAX_CPU]> = Mutex::new([0; CpuSet::MAX_CPU]);

fn taken() -> MutexGuard<'static, [u16; CpuSet::MAX_CPU]> {
    TAKEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Pins the calling thread, and all that it starts, to one processor until dropped.
#[derive(Debug)]
pub(crate) struct Place {
    thread: Pid,
    before: CpuSet,
    processor: usize,
}

impl Place {
    /// Takes the processor with the fewest places, preferably the current one. `None` if there is no choice or the
    /// system refuses.
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
        // If the thread has ended by now, nothing needs to be restored.
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
            // A pinned thread takes no place; another thread takes another processor.
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
