//! Whether a program ended early in the run and in its rerun alike.

use super::pairs::Clock;

/// Whether a program ended as the run notes, both if it did.
pub(super) fn ends_alike(clock: Clock, recorded: Option<&str>, now: Option<&str>) -> bool {
    match (recorded, now) {
        (Some(recorded), Some(now)) => match clock {
            Clock::Virtual => recorded.ends_with(now),
            // Its last words are collected otherwise there.
            Clock::Real => recorded.contains(now.split(';').next().unwrap_or(now)),
        },
        (recorded, now) => recorded.is_none() && now.is_none(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Clock, ends_alike};

    #[test]
    fn how_a_program_ended_is_compared_and_in_real_time_without_its_last_words() {
        let (exited, aborted) = ("exited during the run (status 1)", "was ended by signal 6");
        let now = format!("{exited}; its last words: bye");
        let live = format!("`beat`, which is under test, {exited}: bye");
        let in_step = format!("`beat`, which is under test, {now}");
        for (clock, recorded, now, is_alike) in [
            (Clock::Virtual, Some(&*in_step), Some(&*now), true),
            (Clock::Virtual, Some(&*live), Some(&*now), false),
            (Clock::Real, Some(&*live), Some(&*now), true),
            (Clock::Real, Some(&*live), Some(aborted), false),
            (Clock::Real, Some(&*live), None, false),
            (Clock::Real, None, Some(&*now), false),
            (Clock::Virtual, None, None, true),
        ] {
            assert_eq!(
                ends_alike(clock, recorded, now),
                is_alike,
                "{clock:?} {recorded:?} {now:?}"
            );
        }
    }
}
