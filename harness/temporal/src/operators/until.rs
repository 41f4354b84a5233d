//! `until [a, b]` and `since [a, b]`.

use super::{Fold, Join, Reach, Window};
use crate::stream::Stream;
use crate::truth::Truth;

/// A fold, and, for a window that begins later, the condition that must hold until then.
#[derive(Debug, Clone)]
pub(crate) struct Until {
    fold: Fold,
    lead: Option<Lead>,
}

/// `held until [a, b] met` means: `held` from now until just before `a`, and from `a` on `held until [0, b - a] met`
/// (A. Donzé, T. Ferrère, O. Maler, "Efficient Robust Monitoring for STL", 2013, section 3). `since` is its mirror
/// image.
#[derive(Debug, Clone)]
struct Lead {
    length: i64,
    is_past: bool,
    begun: bool,
    window: Window,
    join: Join,
    held_for_fold: Stream,
    held_for_window: Stream,
    held: Stream,
    met: Stream,
    moved: Stream,
}

impl Until {
    /// `until`.
    pub(crate) fn ahead(from: i64, to: i64) -> Self {
        Self { fold: Fold::until(to - from), lead: Lead::new(from, false) }
    }

    /// `since`.
    pub(crate) fn back(from: i64, to: Option<i64>) -> Self {
        Self { fold: Fold::since(to.map(|to| to - from)), lead: Lead::new(from, true) }
    }

    pub(crate) fn run(&mut self, held: &mut Stream, met: &mut Stream, out: &mut Stream) {
        let Some(lead) = &mut self.lead else { return self.fold.run(held, met, out) };
        held.pour(|step| {
            lead.held_for_fold.push(step.at, step.truth);
            lead.held_for_window.push(step.at, step.truth);
        });
        lead.held_for_fold.know(held.known());
        lead.held_for_window.know(held.known());
        self.fold.run(&mut lead.held_for_fold, met, &mut lead.met);
        lead.window.run(&mut lead.held_for_window, &mut lead.held);
        lead.run_on();
        lead.join.run(&mut lead.held, &mut lead.moved, out);
    }
}

impl Lead {
    fn new(length: i64, is_past: bool) -> Option<Self> {
        let reach = if is_past {
            Reach { from: Some(1 - length), to: 0 }
        } else {
            Reach { from: Some(0), to: length - 1 }
        };
        (length > 0).then(|| Self {
            length,
            is_past,
            begun: false,
            window: Window::new(reach, true, false),
            join: Join::and(),
            held_for_fold: Stream::new(),
            held_for_window: Stream::new(),
            held: Stream::new(),
            met: Stream::new(),
            moved: Stream::new(),
        })
    }

    /// Moves the known part of the fold to the start of the window.
    fn run_on(&mut self) {
        let Self { met, moved, length, begun, is_past, .. } = self;
        let length = *length;
        if !*is_past {
            met.pour(|step| moved.push(step.at.saturating_sub(length), step.truth));
            let known = met.known();
            moved.know(if known == i64::MAX { known } else { known.saturating_sub(length) });
            return;
        }
        met.pour(|step| {
            // The run has just begun, so nothing is as far back as the window requires.
            if !std::mem::replace(begun, true) {
                moved.push(step.at, Truth::FALSE);
            }
            moved.push(step.at.saturating_add(length), step.truth);
        });
        moved.know(met.known());
    }
}
