//! What an imported log cannot show: a format that holds frames alone says nothing of a serial line, not even that it was silent.

use crate::outcome::{Measurement, PropertySummary, Summary, Verdict};
use crate::plan::{Declared, Plan, Property, QuantityName, Rig};
use crate::properties::Unjudged;
use plan::replayed::of_unheard;
use plan::{formula, resolve, speakers_of};
use std::collections::BTreeSet;

/// The lines of a rig of which a log holds nothing.
pub(super) struct Unheard<'a> {
    rig: &'a Rig,
    /// Indexes into the lines of the rig.
    lines: BTreeSet<usize>,
}

impl<'a> Unheard<'a> {
    /// Those that the notes of the `summary` tell of.
    pub(super) fn of(rig: &'a Rig, summary: Option<&Summary>) -> Self {
        let is_told = |name: &str| {
            let note = of_unheard(name);
            summary.is_some_and(|summary| summary.notes.contains(&note))
        };
        let lines = 0..rig.robot_lines() + rig.lines.len();
        Self { rig, lines: lines.filter(|line| is_told(rig.line_name(*line))).collect() }
    }

    /// Takes the figures of what the log cannot show away; returns whether there are any.
    pub(super) fn unset(&self, plan: &Plan, measurements: &mut [Measurement]) -> bool {
        let mut any = false;
        for (declared, found) in plan.measurements.iter().zip(measurements) {
            if let Some(why) = self.why_unset(plan, declared) {
                found.verdict = Verdict::Unset;
                (found.value, found.uncertainty, found.statistic) = (None, 0.0, why);
                any = true;
            }
        }
        any
    }

    /// Takes the verdicts on properties that read what the log cannot show away, and returns them with the reason.
    pub(super) fn unjudged(
        &self,
        plan: &Plan,
        properties: &mut [PropertySummary],
    ) -> Vec<Unjudged> {
        let mut all = Vec::new();
        for property in &plan.properties {
            let Property::Stated(stated) = property else { continue };
            let Some(why) = self.why(&stated.formula) else { continue };
            let (name, kind) = (stated.name.clone(), stated.kind);
            let one = Unjudged { name, kind, why };
            if let Some(found) = properties.iter_mut().find(|found| found.name == one.name) {
                *found = PropertySummary::from(&one);
            }
            all.push(one);
        }
        all
    }

    fn why_unset(&self, plan: &Plan, declared: &Declared) -> Option<String> {
        let second = declared.check.kind().facts().second_quantity.map(|(_, name)| name);
        let of = |quantity: &QuantityName| {
            if let Some(name) = quantity.reaction() {
                let reaction = plan.reactions.iter().find(|one| one.name.as_str() == name)?;
                return self.why(&reaction.from).or_else(|| self.why(&reaction.to));
            }
            if let Some(line) = quantity.line() {
                return self.lines.iter().find_map(|known| {
                    let name = self.rig.line_name(*known);
                    (name == line).then(|| of_unheard(name))
                });
            }
            let place = resolve(&self.rig.speakers, quantity.of_message()?).ok()?;
            self.of_speaker(place.speaker)
        };
        of(&declared.quantity).or_else(|| of(second?))
    }

    /// A sentence about the line that a formula reads and the log does not have.
    fn why(&self, text: &str) -> Option<String> {
        if self.lines.is_empty() {
            return None;
        }
        let formula = formula(text, &self.rig.speakers).ok()?;
        let speakers: Vec<usize> = speakers_of(&self.rig.speakers).collect();
        formula.signals().iter().find_map(|used| self.of_speaker(speakers[used.index]))
    }

    fn of_speaker(&self, speaker: usize) -> Option<String> {
        let speaker = self.rig.speakers.get(speaker)?;
        self.lines.contains(&speaker.line).then(|| of_unheard(&speaker.line_name))
    }
}
