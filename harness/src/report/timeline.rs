//! When each step of the plan ran.
//!
//! Boxes on a line need no drawing library: they are placed in percent of the page, so that their
//! text keeps its size, and each carries its title for the pointer.

use super::trouble::Troubles;
use crate::figures;
use maud::{Markup, html};

/// The most steps that are kept.
const STEPS_MAX: usize = 50_000;

/// The deepest nesting that has a row of its own.
const DEPTH_MAX: usize = 8;

/// Steps narrower than this share of the line that begin as near to the last drawn are left out.
const SHARE_MIN: f64 = 0.002;

/// A character needs this share of the line.
const CHARACTER_SHARE: f64 = 0.0062;

/// Blank between boxes, and the narrowest box, in percent of the line.
const GAP_PERCENT: f64 = 0.12;
const WIDTH_PERCENT_MIN: f64 = 0.12;

const ROW_PX: usize = 24;
const AXIS_PX: usize = 26;

/// Ticks on the time axis, at most.
const TICKS_MAX: f64 = 12.0;

#[derive(Debug)]
struct Step {
    path: String,
    title: String,
    depth: usize,
    begin_s: f64,
    end_s: Option<f64>,
}

/// The steps of a run, in the order in which they began.
#[derive(Debug, Default)]
pub(super) struct Steps {
    all: Vec<Step>,
    /// Indices of those that run, outermost first.
    open: Vec<usize>,
    overflowed: u64,
}

impl Steps {
    pub(super) fn begin(&mut self, at_s: f64, path: &str, title: &str) {
        if self.all.len() >= STEPS_MAX {
            self.overflowed += 1;
            return;
        }
        self.open.push(self.all.len());
        self.all.push(Step {
            path: path.to_owned(),
            title: title.to_owned(),
            depth: (self.open.len() - 1).min(DEPTH_MAX - 1),
            begin_s: at_s,
            end_s: None,
        });
    }

    /// Ends the last step of this path that runs, and with it what ran inside.
    pub(super) fn end(&mut self, at_s: f64, path: &str) {
        let found = self.open.iter().rposition(|&index| self.all[index].path == path);
        if let Some(position) = found {
            for index in self.open.drain(position..) {
                self.all[index].end_s = Some(at_s);
            }
        }
    }

    /// The title of the innermost step that had not ended.
    pub(super) fn unfinished(&self) -> Option<&str> {
        self.open.last().map(|&index| self.all[index].title.as_str())
    }

    fn shown(&self, end_s: f64) -> Vec<&Step> {
        let mut last_begin = [f64::NEG_INFINITY; DEPTH_MAX];
        let least = SHARE_MIN * end_s;
        let is_shown = |step: &&Step| {
            let wide = step.end_s.unwrap_or(end_s) - step.begin_s >= least;
            let apart = step.begin_s - last_begin[step.depth] >= least;
            if wide || apart {
                last_begin[step.depth] = step.begin_s;
            }
            wide || apart
        };
        self.all.iter().filter(is_shown).collect()
    }
}

/// The time line.
pub(super) fn figure(steps: &Steps, troubles: &Troubles, end_s: f64) -> Option<Markup> {
    if steps.all.is_empty() || end_s <= 0.0 {
        return None;
    }
    let shown = steps.shown(end_s);
    let rows = 1 + shown.iter().map(|step| step.depth).max().unwrap_or(0);
    let height = rows * ROW_PX + AXIS_PX;
    let axis_y = rows * ROW_PX + 4;
    let percent = |at_s: f64| format!("{:.2}%", 100.0 * at_s / end_s);
    let left_out = steps.all.len() - shown.len();
    Some(html! {
        figure {
            svg.timeline role="img" aria-label="steps over time" width="100%" height=(height) {
                @for (at_s, label) in ticks(end_s) {
                    line.grid x1=(percent(at_s)) x2=(percent(at_s)) y1="0" y2=(axis_y) {}
                    text.tick x=(percent(at_s)) y=(height - 6)
                        text-anchor=(if at_s > 0.0 { "middle" } else { "start" }) { (label) }
                }
                @for step in &shown { (step_box(step, end_s)) }
                @for at_s in troubles.instants() {
                    line.trouble x1=(percent(at_s)) x2=(percent(at_s)) y1="0" y2=(axis_y) {}
                }
            }
            figcaption {
                p {
                    (steps.all.len()) " step" @if steps.all.len() != 1 { "s" }
                    @if left_out > 0 { "; " (left_out) " too short to be told apart are not drawn" }
                    "; point at one to read what it is."
                    @if steps.overflowed > 0 { " " (steps.overflowed) " later ones were not kept." }
                }
            }
        }
    })
}

fn step_box(step: &Step, end_s: f64) -> Markup {
    let share = (step.end_s.unwrap_or(end_s) - step.begin_s).max(0.0) / end_s;
    let x = 100.0 * step.begin_s / end_s;
    let y = step.depth * ROW_PX;
    let took = match step.end_s {
        Some(step_end_s) => figures::duration(step_end_s - step.begin_s),
        None => "did not end".to_owned(),
    };
    let class = match (step.end_s, step.depth % 2) {
        (None, _) => "unfinished",
        (_, 0) => "even",
        _ => "odd",
    };
    let fits = step.title.chars().count() as f64 * CHARACTER_SHARE < share;
    html! {
        g.step.(class) {
            title { (step.path) ": " (step.title) " (" (took) ")" }
            rect x={ (format!("{x:.3}")) "%" } y=(y) height=(ROW_PX - 4) rx="2"
                width={ (format!("{:.3}", (100.0 * share - GAP_PERCENT).max(WIDTH_PERCENT_MIN))) "%" } {}
            @if fits {
                text x={ (format!("{:.3}", x + 0.4)) "%" } y=(y + 14) { (step.title) }
            }
        }
    }
}

/// Round instants with their labels.
fn ticks(end_s: f64) -> Vec<(f64, String)> {
    const STEPS_S: [f64; 14] = [
        1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1_800.0, 3_600.0, 7_200.0, 21_600.0,
        86_400.0,
    ];
    let longest = STEPS_S[STEPS_S.len() - 1];
    let fits = STEPS_S.into_iter().find(|step_s| end_s / step_s <= TICKS_MAX);
    let step_s = fits.unwrap_or_else(|| longest * (end_s / longest / TICKS_MAX).ceil());
    let (unit, unit_s) = match step_s {
        _ if step_s >= 1_800.0 => ("h", 3_600.0),
        _ if step_s >= 60.0 => ("min", 60.0),
        _ => ("s", 1.0),
    };
    let count = (end_s / step_s).floor() as u32;
    (0..=count)
        .map(|index| f64::from(index) * step_s)
        // A label at the very end would be cut.
        .filter(|at_s| *at_s <= 0.97 * end_s)
        .map(|at_s| (at_s, format!("{} {unit}", figures::value(at_s / unit_s, 0.0))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{STEPS_MAX, Steps, TICKS_MAX, figure, ticks};
    use crate::report::trouble::Troubles;
    use proptest::prelude::*;

    #[test]
    fn steps_nest_and_end_with_what_holds_them() {
        let mut steps = Steps::default();
        steps.begin(0.0, "steps[0]", "repeat");
        steps.begin(1.0, "steps[0].repeat[0]", "turn");
        steps.end(2.0, "steps[0].repeat[0]");
        steps.begin(3.0, "steps[0].repeat[1]", "turn again");
        steps.end(4.0, "steps[0]");
        steps.end(5.0, "never begun");
        let seen: Vec<_> = steps.all.iter().map(|s| (s.depth, s.begin_s, s.end_s)).collect();
        assert_eq!(seen, [(0, 0.0, Some(4.0)), (1, 1.0, Some(2.0)), (1, 3.0, Some(4.0))]);
        assert_eq!(steps.unfinished(), None);
        steps.begin(6.0, "steps[1]", "straight");
        assert_eq!(steps.unfinished(), Some("straight"));
    }

    #[test]
    fn many_short_steps_stay_few_boxes() {
        let mut steps = Steps::default();
        for index in 0..=STEPS_MAX {
            steps.begin(index as f64, "s", "short");
            steps.end(index as f64 + 0.5, "s");
        }
        assert_eq!(steps.overflowed, 1);
        let end_s = STEPS_MAX as f64;
        assert!(steps.shown(end_s).len() <= 501);
        let text = figure(&steps, &Troubles::default(), end_s).unwrap().into_string();
        assert!(text.contains("too short to be told apart"));
    }

    proptest! {
        #[test]
        fn ticks_are_few(end_s in 1e-3..1e9f64) {
            let ticks = ticks(end_s);
            prop_assert!(!ticks.is_empty() && ticks.len() as f64 <= TICKS_MAX + 1.0);
        }
    }
}
