//! The changes of one fault that shrinking tries.

use crate::space::DURATION_MIN;
use plan::faults::{Fault, FaultKind, Lasts, Toward, When};
use wire::time::Span;

/// The same fault with another kind, as far as possible.
pub(super) fn recast(fault: &Fault, what: FaultKind) -> Fault {
    let info = what.info();
    let toward = if info.reach.is_line() { fault.toward } else { Toward::Both };
    let lasting = fault.lasting();
    let what = match (info.lasts, lasting) {
        (Lasts::Itself, Some(lasting)) => what.with_severity(lasting.as_secs_f64()),
        _ => what,
    };
    let duration = if info.lasts == Lasts::Scheduled { lasting } else { None };
    let duration = duration.filter(|duration| *duration > Span::ZERO);
    Fault { what, toward, duration, ..fault.clone() }
}

/// Begin of a fault that begins at a fixed time of the run or of a phase.
pub(super) const fn begin(fault: &Fault) -> Option<Span> {
    match fault.when {
        When::At(at) | When::Step { after: at, .. } => Some(at),
        When::Always | When::During { .. } => None,
    }
}

/// The same begin, as a time after that of the run or of the phase.
pub(super) fn timed(when: &When) -> When {
    match when.clone() {
        When::Always => When::At(Span::ZERO),
        When::During { phase, number } => When::Step { phase, number, after: Span::ZERO },
        when @ (When::At(_) | When::Step { .. }) => when,
    }
}

/// The shortest length that is tried.
pub(super) fn length_min(fault: &Fault) -> f64 {
    match fault.what.info().lasts {
        Lasts::Itself => fault.what.severity_range().0,
        Lasts::Scheduled | Lasts::Instant => DURATION_MIN.as_secs_f64(),
    }
}

/// Sets its duration, or the parameter that is its duration.
pub(super) fn set_length(fault: &mut Fault, length: Span) {
    match fault.what.info().lasts {
        Lasts::Itself => fault.what = fault.what.with_severity(length.as_secs_f64()),
        Lasts::Scheduled => fault.duration = Some(length),
        Lasts::Instant => {}
    }
}

pub(super) fn set_begin(fault: &mut Fault, begin: Span) {
    if let When::At(at) | When::Step { after: at, .. } = &mut fault.when {
        *at = begin;
    }
}

pub(super) fn set_number(fault: &mut Fault, to: u32) {
    if let When::Step { number, .. } | When::During { number, .. } = &mut fault.when {
        *number = to;
    }
}

/// Rounds to this many digits, away from zero.
pub(super) fn rounded_up(value: f64, digits: i32) -> f64 {
    if value.is_nan() || value <= 0.0 {
        return value;
    }
    let unit = 10f64.powi(value.log10().floor() as i32 + 1 - digits);
    // A number that is already round stays.
    let rounded = (value / unit - 1e-9).ceil() * unit;
    // Without the rounding error of the product, as a person would write it.
    format!("{rounded:.*e}", 6).parse().unwrap_or(rounded)
}
