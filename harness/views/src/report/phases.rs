//! When the phases of a plan were under way: by the tags of observations, which also say which bands apply to them.

use super::against::Against;
use plan::quantities::DURING_PREFIX;
use record::header::Band;
use std::collections::BTreeMap;

/// Maximum number of stretches, and of different sets of phases.
const STRETCHES_MAX: usize = 100_000;
const SETS_MAX: usize = 10_000;

/// Observations in a row with the same phases.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    set: u16,
    begin_s: f64,
    end_s: f64,
}

#[derive(Debug)]
pub(super) struct Phases {
    /// Sets of phases that observations have; the first is empty.
    sets: Vec<Vec<String>>,
    stretches: Vec<Stretch>,
}

impl Default for Phases {
    fn default() -> Self {
        Self { sets: vec![Vec::new()], stretches: Vec::new() }
    }
}

impl Phases {
    /// Adds an observation; returns the number of its set.
    pub(super) fn add(&mut self, at_s: f64, tags: &BTreeMap<String, f64>) -> u16 {
        let phases = || {
            let tags = tags.range(DURING_PREFIX.to_owned()..);
            tags.map_while(|(tag, _)| tag.strip_prefix(DURING_PREFIX))
        };
        let is_it = |set: &Vec<String>| phases().eq(set.iter().map(String::as_str));
        if let Some(last) = self.stretches.last_mut()
            && is_it(&self.sets[usize::from(last.set)])
        {
            last.end_s = at_s;
            return last.set;
        }
        let known = self.sets.iter().position(is_it);
        let set = match known {
            Some(known) => known,
            None if self.sets.len() < SETS_MAX => {
                self.sets.push(phases().map(str::to_owned).collect());
                self.sets.len() - 1
            }
            None => 0,
        } as u16;
        if self.stretches.len() < STRETCHES_MAX {
            self.stretches.push(Stretch { set, begin_s: at_s, end_s: at_s });
        }
        set
    }

    /// Whether an observation with this set was made in the phase.
    pub(super) fn has(&self, set: u16, phase: &str) -> bool {
        self.sets.get(usize::from(set)).is_some_and(|set| set.iter().any(|one| one == phase))
    }

    /// Where on the axis a band holds; `None`: everywhere.
    pub(super) fn spans(&self, band: &Band, against: Against) -> Option<Vec<(f64, f64)>> {
        let Against::Time { .. } = against else { return None };
        let wanted: Vec<&str> =
            band.tags.keys().filter_map(|tag| tag.strip_prefix(DURING_PREFIX)).collect();
        if wanted.is_empty() {
            return None;
        }
        let mut spans: Vec<(f64, f64)> = Vec::new();
        let mut is_open = false;
        for stretch in &self.stretches {
            let holds = wanted.iter().all(|phase| self.has(stretch.set, phase));
            match spans.last_mut() {
                Some(last) if holds && is_open => last.1 = against.place(stretch.end_s),
                _ if holds => {
                    spans.push((against.place(stretch.begin_s), against.place(stretch.end_s)));
                }
                _ => {}
            }
            is_open = holds;
        }
        Some(spans)
    }
}

#[cfg(test)]
mod tests {
    use super::Phases;
    use crate::report::against::Against;
    use record::header::Band;
    use std::collections::BTreeMap;

    fn tags(names: &[&str]) -> BTreeMap<String, f64> {
        let tag = |name: &&str| (format!("during.{name}"), 1.0);
        names.iter().map(tag).chain([("run".to_owned(), 1.0), ("angle".to_owned(), 2.0)]).collect()
    }

    #[test]
    fn a_band_holds_while_observations_have_its_phase() {
        let mut phases = Phases::default();
        let heating = phases.add(1.0, &tags(&["heating", "wait"]));
        for (at_s, names) in [
            (2.0, &["heating", "wait"][..]),
            (3.0, &["send"]),
            (60.0, &["holding", "wait"]),
            (90.0, &["holding", "wait"]),
            (120.0, &["heating", "repeat"]),
            (150.0, &["heating", "wait"]),
        ] {
            phases.add(at_s, &tags(names));
        }
        assert!(phases.has(heating, "wait") && !phases.has(heating, "holding"));
        let of = |names: &[&str]| Band { tags: tags(names), ..Band::default() };
        let minutes = Against::Time { unit: "min", unit_s: 60.0 };
        assert_eq!(phases.spans(&of(&["holding"]), minutes), Some(vec![(1.0, 1.5)]));
        let both = Some(vec![(1.0 / 60.0, 2.0 / 60.0), (2.0, 2.5)]);
        assert_eq!(phases.spans(&of(&["heating"]), minutes), both);
        assert_eq!(phases.spans(&of(&["never"]), minutes), Some(Vec::new()));
        assert_eq!(phases.spans(&of(&[]), minutes), None);
        assert_eq!(phases.spans(&of(&["holding"]), Against::Run), None);
    }
}
