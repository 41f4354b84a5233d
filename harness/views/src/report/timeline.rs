//! Time line: when each step of the plan ran, when faults were active, and when verdicts were decided.
//!
//! Boxes on a line need no drawing library: they are positioned in percent of the page, so that their text keeps its
//! size, and each carries its title as a tooltip.

use super::collect::Collected;
use super::decided::Mark;
use super::download::{ROWS_MAX, Table, place, text};
use super::fault_spans::Span;
use super::steps::{Step, Steps};
use super::stimuli;
use maud::{Markup, html};
use record::figures;

/// Width of a character as a share of the line.
const CHARACTER_SHARE: f64 = 0.0062;

/// Gap between boxes, and minimum width of a box, in percent of the line.
const GAP_PERCENT: f64 = 0.12;
const WIDTH_PERCENT_MIN: f64 = 0.12;

/// Maximum number of steps that act on devices, on the line and in the list.
const STIMULI_MAX: usize = 500;
const LISTED_MAX: usize = 20;

const MARKS_LISTED_MAX: usize = 30;

/// Height of the row of verdicts.
const MARKS_PX: usize = 16;

const ROW_PX: usize = 24;
const AXIS_PX: usize = 26;

/// Maximum ticks on the time axis.
const TICKS_MAX: f64 = 7.0;

pub(super) fn figure(collected: &Collected, marks: &[Mark]) -> Option<Markup> {
    let Collected { steps, troubles, faults, end_s, .. } = collected;
    let end_s = *end_s;
    if steps.all.is_empty() || end_s <= 0.0 {
        return None;
    }
    let shown = steps.shown(end_s);
    let top = if marks.is_empty() { 0 } else { MARKS_PX };
    let rows = 1 + shown.iter().map(|step| step.depth).max().unwrap_or(0);
    let (lanes, lanes_left_out) = faults.lanes();
    let lanes_y = top + rows * ROW_PX;
    let axis_y = lanes_y + lanes.len() * ROW_PX + 4;
    let height = axis_y + AXIS_PX - 4;
    let percent = |at_s: f64| format!("{:.2}%", 100.0 * at_s / end_s);
    let left_out = steps.all.len() - shown.len();
    let acts = stimuli::steps(collected).count();
    Some(html! {
        figure {
            svg.timeline role="img" aria-label="steps over time" width="100%" height=(height) {
                @for (at_s, label) in ticks(end_s) {
                    line.grid x1=(percent(at_s)) x2=(percent(at_s)) y1="0" y2=(axis_y) {}
                    text.tick x=(percent(at_s)) y=(height - 6)
                        text-anchor=(if at_s > 0.0 { "middle" } else { "start" }) { (label) }
                }
                @for step in &shown { (step_box(step, top, end_s)) }
                @for (row, lane) in lanes.iter().enumerate() {
                    @for span in lane { (fault_box(span, lanes_y + row * ROW_PX, end_s)) }
                }
                @for at_s in troubles.instants() {
                    line.trouble x1=(percent(at_s)) x2=(percent(at_s)) y1=(top) y2=(axis_y) {}
                }
                @for step in stimuli::steps(collected).take(STIMULI_MAX) {
                    line.stimulus x1=(percent(step.begin_s)) x2=(percent(step.begin_s)) y1=(top) y2=(axis_y) {
                        title { (step.title) (format!(" at {:.3} s", step.begin_s)) }
                    }
                }
                @for mark in marks {
                    circle.mark.(mark.class) cx=(percent(mark.at_s.min(end_s))) cy=(MARKS_PX / 2 - 1) r="5" {
                        title { (mark.text) (format!(" at {:.3} s", mark.at_s)) }
                    }
                }
            }
            figcaption {
                p.legend {
                    span { i.box.step {} "steps" }
                    @if acts > 0 { span { i.line.paper {} "what the plan does to devices" } }
                    @if !lanes.is_empty() { span { i.box.fault {} "faults" } }
                    @if !marks.is_empty() { span { i.mark.plain { "●" } "verdicts, in their colours" } }
                    @if troubles.instants().next().is_some() { span { i.box.trouble {} "notes" } }
                }
                p {
                    (steps.all.len()) " step" @if steps.all.len() != 1 { "s" }
                    @if left_out > 0 {
                        "; " (left_out) " of them " (if left_out == 1 { "is" } else { "are" }) " too short to be drawn"
                    }
                    "; point at one to see what it does."
                    @if steps.overflowed > 0 { " " (steps.overflowed) " later ones were not kept." }
                    @if lanes_left_out > 0 { " " (lanes_left_out) " faults at a time too many are not drawn." }
                    " Steps: " (table(steps).without(steps.all.len().saturating_sub(ROWS_MAX)).link("steps"))
                }
                // In place of the words in the boxes, for which a narrow screen has no room.
                @let labelled: Vec<_> = steps.all.iter().filter_map(|step| Some((step.label.as_deref()?, step.begin_s))).collect();
                @if !labelled.is_empty() {
                    p.narrow {
                        "Begin: "
                        @for (index, (label, begin_s)) in labelled.iter().take(LISTED_MAX).enumerate() {
                            @if index > 0 { "; " }
                            (label) (format!(" at {begin_s:.3} s"))
                        }
                        @if labelled.len() > LISTED_MAX { "; and " (labelled.len() - LISTED_MAX) " more" }
                        "."
                    }
                }
                @if acts > 0 {
                    ul.faults {
                        @for step in stimuli::steps(collected).take(LISTED_MAX) {
                            li { (format!("{:.3} s: ", step.begin_s)) (step.title) }
                        }
                        @if acts > LISTED_MAX { li { "and " (acts - LISTED_MAX) " more" } }
                    }
                }
                @if let Some(words) = faults.words() { (words) }
                @if !marks.is_empty() {
                    p {
                        "Decided: "
                        @for (index, mark) in marks.iter().take(MARKS_LISTED_MAX).enumerate() {
                            @if index > 0 { "; " }
                            (mark.text) (format!(" at {:.3} s", mark.at_s))
                        }
                        @if marks.len() > MARKS_LISTED_MAX { "; and " (marks.len() - MARKS_LISTED_MAX) " more" }
                        "."
                    }
                }
            }
        }
    })
}

fn table(steps: &Steps) -> Table {
    let mut table = Table::new(["step", "label", "title", "begin_s", "end_s"]);
    for step in steps.all.iter().take(ROWS_MAX) {
        table.row([
            text(&step.path),
            text(step.label.as_deref().unwrap_or_default()),
            text(&step.title),
            place(step.begin_s),
            step.end_s.map_or_else(String::new, place),
        ]);
    }
    table
}

fn fault_box(span: &Span, y: usize, end_s: f64) -> Markup {
    let shown = (span.begin_s, span.end_s.unwrap_or(end_s));
    let inner = named_box(&span.name, shown, y, end_s);
    html! { g.fault { title { (span.name) } (inner) } }
}

fn step_box(step: &Step, top: usize, end_s: f64) -> Markup {
    let took = match step.end_s {
        Some(step_end_s) => figures::duration(step_end_s - step.begin_s),
        None => "did not end".to_owned(),
    };
    let class = match (step.end_s, step.depth % 2) {
        (None, _) => "unfinished",
        (_, 0) => "even",
        _ => "odd",
    };
    let shown = (step.begin_s, step.end_s.unwrap_or(end_s));
    let inner = named_box(step.name(), shown, top + step.depth * ROW_PX, end_s);
    html! {
        g.step.(class) {
            title {
                (step.path) ": " @if let Some(label) = &step.label { (label) ", " }
                (step.title) " (" (took) ")"
            }
            (inner)
        }
    }
}

/// A box, with its name where that fits.
fn named_box(name: &str, (begin_s, until_s): (f64, f64), y: usize, end_s: f64) -> Markup {
    let share = (until_s - begin_s).max(0.0) / end_s;
    let x = 100.0 * begin_s / end_s;
    let fits = name.chars().count() as f64 * CHARACTER_SHARE < share;
    html! {
        rect x={ (format!("{x:.3}")) "%" } y=(y) height=(ROW_PX - 4) rx="2"
            width={ (format!("{:.3}", (100.0 * share - GAP_PERCENT).max(WIDTH_PERCENT_MIN))) "%" } {}
        @if fits { text x={ (format!("{:.3}", x + 0.4)) "%" } y=(y + 14) { (name) } }
    }
}

/// Returns round instants with their labels.
fn ticks(end_s: f64) -> Vec<(f64, String)> {
    const STEPS_S: [f64; 15] = [
        1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1_800.0, 3_600.0, 7_200.0, 10_800.0,
        21_600.0, 86_400.0,
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
        // A label at the very end would be cut off.
        .filter(|at_s| *at_s <= 0.97 * end_s)
        .map(|at_s| (at_s, format!("{} {unit}", figures::value(at_s / unit_s, 0.0))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Steps, TICKS_MAX, figure, ticks};
    use crate::report::collect::Collected;
    use crate::report::steps::STEPS_MAX;
    use proptest::prelude::*;

    #[test]
    fn steps_nest_and_end_with_what_holds_them() {
        let mut steps = Steps::default();
        steps.begin(0.0, "steps[0]", "repeat", None);
        steps.begin(1.0, "steps[0].repeat[0]", "turn", None);
        steps.end(2.0, "steps[0].repeat[0]");
        steps.begin(3.0, "steps[0].repeat[1]", "turn again", None);
        steps.end(4.0, "steps[0]");
        steps.end(5.0, "never begun");
        let seen: Vec<_> = steps.all.iter().map(|s| (s.depth, s.begin_s, s.end_s)).collect();
        assert_eq!(seen, [(0, 0.0, Some(4.0)), (1, 1.0, Some(2.0)), (1, 3.0, Some(4.0))]);
        assert_eq!(steps.unfinished(), None);
        steps.begin(6.0, "steps[1]", "straight", None);
        assert_eq!(steps.unfinished(), Some("straight"));
    }

    #[test]
    fn many_short_steps_stay_few_boxes() {
        let mut steps = Steps::default();
        for index in 0..=STEPS_MAX {
            steps.begin(index as f64, "s", "short", None);
            steps.end(index as f64 + 0.5, "s");
        }
        assert_eq!(steps.overflowed, 1);
        let end_s = STEPS_MAX as f64;
        assert!(steps.shown(end_s).len() <= 501);
        let collected = Collected { steps, end_s, ..Collected::default() };
        let text = figure(&collected, &[]).unwrap().into_string();
        assert!(text.contains(" of them are too short to be drawn"));
    }

    proptest! {
        #[test]
        fn ticks_are_few(end_s in 1e-3..1e9f64) {
            let ticks = ticks(end_s);
            prop_assert!(!ticks.is_empty() && ticks.len() as f64 <= TICKS_MAX + 1.0);
        }
    }
}
