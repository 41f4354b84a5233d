//! Small mutations of a case.

use super::case::Case;
use super::search::Dice;
use super::space::{DURATION_MIN, Space, duration, plain, severities, whole_ms};
use super::survey::Survey;
use plan::faults::{Fault, Lasts, Schedule, When};
use proptest::strategy::{Strategy as _, ValueTree as _};
use rand::RngExt as _;
use wire::time::Span;

/// The most mutations tried until one is applicable.
const TRIES: usize = 20;

/// `parent` with one or two changes, within `space`; `None` if no tried change is applicable. New faults come from
/// `survey`.
pub(super) fn mutated(
    parent: &Case,
    space: &Space,
    survey: &mut Survey,
    dice: &mut Dice,
) -> Option<Case> {
    for _ in 0..TRIES {
        let mut case = parent.clone();
        for _ in 0..dice.random.random_range(1..=2) {
            change(&mut case, space, survey, dice);
        }
        if case != *parent && !case.schedule.is_empty() && space.takes(&case.schedule) {
            return Some(case);
        }
    }
    None
}

fn change(case: &mut Case, space: &Space, survey: &mut Survey, dice: &mut Dice) {
    let Schedule { faults } = &mut case.schedule;
    let count = faults.len();
    let choice = dice.random.random_range(0..100);
    match choice {
        0..12 if count < space.faults_max() => {
            let at = dice.random.random_range(0..=count);
            if let Some(fault) = survey.fault(dice) {
                faults.insert(at, fault);
            }
        }
        12..24 if count > 1 => {
            faults.remove(dice.random.random_range(0..count));
        }
        24..30 => case.seed = dice.seed(),
        30..50 if count > 0 => {
            let at = dice.random.random_range(0..count);
            if let Some(fault) = survey.fault(dice) {
                faults[at] = fault;
            }
        }
        _ if count > 0 => {
            let at = dice.random.random_range(0..count);
            adjust(&mut faults[at], space, dice);
        }
        _ => {}
    }
}

/// Changes the severity, the start or the duration of one fault, mostly a little and sometimes a lot.
fn adjust(fault: &mut Fault, space: &Space, dice: &mut Dice) {
    let random = &mut dice.random;
    let spread = if random.random_bool(0.2) { 2.0 } else { 0.3 };
    let step: f64 = spread * (random.random::<f64>() + random.random::<f64>() - 1.0);
    match random.random_range(0..3) {
        0 => {
            if !fault.what.is_graded() {
                let (least, greatest) = space.values(fault.target, fault.what);
                let value = fault.what.values().first().copied().unwrap_or_default();
                let value = (value + step * 0.5 * (greatest - least)).clamp(least, greatest);
                fault.what = fault.what.with_value(0, value);
                return;
            }
            let (least, greatest) = severities(fault.what);
            let size = (fault.what.severity().max(least) * step.exp()).clamp(least, greatest);
            fault.what = fault.what.with_severity(plain(fault.what, size));
        }
        1 => {
            let horizon = space.horizon().as_secs_f64();
            let moved = |at: Span, scale: f64, latest: f64| {
                whole_ms((at.as_secs_f64() + step * scale).clamp(0.0, latest))
            };
            match &mut fault.when {
                When::At(at) => *at = moved(*at, 0.1 * horizon, horizon),
                When::Step { phase, number, after } => {
                    // The last whole millisecond of the phase.
                    let latest = space.course().within(phase, *number, 1.0 - f64::EPSILON);
                    *after = moved(*after, 2.0_f64.min(horizon), latest.as_secs_f64());
                }
                When::Always | When::During { .. } => {
                    if let Ok(tree) = space.when().new_tree(&mut dice.runner) {
                        fault.when = tree.current();
                    }
                }
            }
        }
        _ if fault.what.info().lasts == Lasts::Scheduled => {
            let now = fault.duration.unwrap_or(space.horizon()).max(DURATION_MIN).as_secs_f64();
            let longest = duration(space.horizon(), 1.0);
            fault.duration = Some(whole_ms(now * step.exp()).clamp(DURATION_MIN, longest));
        }
        _ => {}
    }
}
