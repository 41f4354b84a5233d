//! The times at which each fault of the schedule was active.

use super::download::{Table, number, place, text};
use maud::{Markup, html};
use record::{FaultEvent, FaultRecord};

const SPANS_MAX: usize = 1_000;

const LISTED_MAX: usize = 20;

/// Maximum rows for overlapping spans.
const LANES_MAX: usize = 8;

/// One period in which a fault was active.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Span {
    pub index: u32,
    pub name: String,
    pub begin_s: f64,
    /// `None` if the record ends before.
    pub end_s: Option<f64>,
    acted: u64,
}

/// Spans of a run, in order of their begin.
#[derive(Debug, Default)]
pub(super) struct FaultSpans {
    all: Vec<Span>,
    never: Vec<(String, String)>,
    overflowed: u64,
}

impl FaultSpans {
    pub(super) fn add(&mut self, at_s: f64, fault: &FaultRecord) {
        let FaultRecord { index, name, event } = fault;
        match event {
            FaultEvent::Began if self.all.len() < SPANS_MAX => {
                let (index, name) = (*index, name.clone());
                self.all.push(Span { index, name, begin_s: at_s, end_s: None, acted: 0 });
            }
            FaultEvent::NeverHappened { why } if self.never.len() < SPANS_MAX => {
                self.never.push((name.clone(), why.clone()));
            }
            FaultEvent::Began | FaultEvent::NeverHappened { .. } => self.overflowed += 1,
            FaultEvent::Ended { acted } => {
                let open = |span: &&mut Span| span.index == *index && span.end_s.is_none();
                if let Some(span) = self.all.iter_mut().rev().find(open) {
                    (span.end_s, span.acted) = (Some(at_s), *acted);
                }
            }
            FaultEvent::Confinement { .. } => {}
        }
    }

    pub(super) fn all(&self) -> &[Span] {
        &self.all
    }

    /// Arranges spans in rows without overlaps; also returns how many found no row.
    pub(super) fn lanes(&self) -> (Vec<Vec<&Span>>, usize) {
        let mut lanes: Vec<Vec<&Span>> = Vec::new();
        let mut left_out = 0;
        for span in &self.all {
            let is_free = |lane: &Vec<&Span>| {
                let last = lane.last().map(|last| last.end_s.unwrap_or(f64::INFINITY));
                last.is_none_or(|end_s| end_s <= span.begin_s)
            };
            match lanes.iter().position(is_free) {
                Some(free) => lanes[free].push(span),
                None if lanes.len() < LANES_MAX => lanes.push(vec![span]),
                None => left_out += 1,
            }
        }
        (lanes, left_out)
    }

    /// Lists the spans with their data; `None` if the run had no fault.
    pub(super) fn words(&self) -> Option<Markup> {
        if self.all.is_empty() && self.never.is_empty() {
            return None;
        }
        let mut data = Table::new(["fault", "name", "begin_s", "end_s", "acted"]);
        for span in &self.all {
            data.row([
                span.index.to_string(),
                text(&span.name),
                place(span.begin_s),
                span.end_s.map_or_else(String::new, place),
                number(span.acted as f64),
            ]);
        }
        Some(html! {
            ul.faults {
                @for span in self.all.iter().take(LISTED_MAX) {
                    li {
                        (span.name) ": " (format!("{:.3} s to ", span.begin_s))
                        @match span.end_s {
                            Some(end_s) => {
                                (format!("{end_s:.3} s")) ", acted " (span.acted) " time"
                                @if span.acted != 1 { "s" }
                            }
                            None => "the end of the record",
                        }
                    }
                }
                @for (name, why) in self.never.iter().take(LISTED_MAX) { li { (name) ": never, " (why) } }
            }
            p {
                @if self.all.len() > LISTED_MAX { "The first " (LISTED_MAX) " of " (self.all.len()) ". " }
                @if self.overflowed > 0 { (self.overflowed) " later ones were not kept. " }
                "Faults: " (data.link("faults"))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{FaultSpans, LANES_MAX, SPANS_MAX};
    use record::{FaultEvent, FaultRecord};

    fn event(index: u32, event: FaultEvent) -> FaultRecord {
        FaultRecord { index, name: format!("drop {index}"), event }
    }

    #[test]
    fn spans_that_overlap_get_rows_of_their_own() {
        let mut spans = FaultSpans::default();
        spans.add(1.0, &event(0, FaultEvent::Began));
        spans.add(2.0, &event(1, FaultEvent::Began));
        spans.add(3.0, &event(0, FaultEvent::Ended { acted: 4 }));
        spans.add(5.0, &event(2, FaultEvent::Began));
        spans.add(9.0, &event(3, FaultEvent::NeverHappened { why: "no third lap".into() }));
        let (lanes, left_out) = spans.lanes();
        let rows: Vec<Vec<u32>> =
            lanes.iter().map(|lane| lane.iter().map(|span| span.index).collect()).collect();
        assert_eq!((rows, left_out), (vec![vec![0, 2], vec![1]], 0));
        let words = spans.words().unwrap().into_string();
        assert!(words.contains("drop 0: 1.000 s to 3.000 s, acted 4 times"), "{words}");
        assert!(words.contains("drop 1: 2.000 s to the end of the record"), "{words}");
        assert!(words.contains("drop 3: never, no third lap"), "{words}");
        assert!(FaultSpans::default().words().is_none());
    }

    #[test]
    fn however_many_there_are_few_are_kept_and_drawn() {
        let mut spans = FaultSpans::default();
        for index in 0..SPANS_MAX as u32 + 5 {
            spans.add(f64::from(index), &event(index, FaultEvent::Began));
        }
        assert_eq!(spans.overflowed, 5);
        let (lanes, left_out) = spans.lanes();
        assert_eq!((lanes.len(), left_out), (LANES_MAX, SPANS_MAX - LANES_MAX));
    }
}
