//! Judges all properties of one run.

use super::always::{self, Judge};
use super::seen::Seen;
use super::senses::{Fact, Senses, Topic};
use super::sometimes::Reached;
use super::verdict::{Kind, PropertyVerdict};
use super::{Limits, Property};
use record::Violation;
use wire::time::Timestamp;

/// Watches one run. Properties that are asked for twice are judged once, by the first.
#[derive(Debug)]
pub struct Monitor {
    properties: Vec<Property>,
    senses: Senses,
    judges: Vec<Box<dyn Judge>>,
    /// Which judges hear each topic.
    hearers: [Vec<usize>; Topic::COUNT],
    reached: Reached,
    facts: Vec<Fact>,
}

impl Monitor {
    /// A monitor of `properties`; without any, of all of them. `limits` hold where a property states none.
    pub fn new(properties: &[Property], limits: &Limits) -> Self {
        let mut asked = properties.to_vec();
        if asked.is_empty() {
            asked = Property::all();
        }
        let mut properties: Vec<Property> = Vec::new();
        for property in asked {
            if properties.iter().all(|known| known.name() != property.name()) {
                properties.push(property);
            }
        }
        let judges = properties.iter().filter_map(|property| match property {
            Property::Always(property) => Some(always::judge(property, limits)),
            Property::Sometimes(_) => None,
        });
        let judges: Vec<Box<dyn Judge>> = judges.collect();
        let mut hearers = [const { Vec::new() }; Topic::COUNT];
        for (index, judge) in judges.iter().enumerate() {
            for topic in judge.hears() {
                hearers[*topic as usize].push(index);
            }
        }
        Self {
            senses: Senses::new(limits),
            judges,
            hearers,
            reached: Reached::default(),
            facts: Vec::new(),
            properties,
        }
    }

    /// Takes what is seen at `now`. Times never go back.
    pub fn see(&mut self, now: Timestamp, seen: &Seen<'_>) {
        self.facts.clear();
        self.senses.take(now, seen, &mut self.facts);
        for fact in &self.facts {
            for &judge in &self.hearers[fact.topic() as usize] {
                self.judges[judge].judge(&self.senses, fact);
            }
            self.reached.judge(&self.senses, fact);
        }
    }

    /// The properties that do not hold so far, and where each was first violated.
    pub fn broken(&self) -> impl Iterator<Item = (&'static str, &Violation)> {
        let always = self.properties.iter().filter_map(|property| match property {
            Property::Always(always) => Some(always.name()),
            Property::Sometimes(_) => None,
        });
        let judged = always.zip(&self.judges);
        judged.filter_map(|(name, judge)| Some((name, judge.judgement().first_violation()?)))
    }

    /// What became of each property, in the order in which they were asked for. The run ends here, and
    /// with it the lap that is under way.
    pub fn verdicts(mut self) -> Vec<PropertyVerdict> {
        for judge in &mut self.judges {
            judge.judge(&self.senses, &Fact::LapEnded);
        }
        let mut judges = self.judges.into_iter();
        let verdicts = self.properties.iter().filter_map(|property| match property {
            Property::Always(always) => {
                judges.next().map(|judge| judge.judgement().clone().verdict(always.name()))
            }
            Property::Sometimes(sometimes) => Some(PropertyVerdict {
                name: sometimes.name(),
                kind: Kind::Sometimes,
                held: self.reached.has(*sometimes),
                first_violation: None,
                margin: None,
            }),
        });
        verdicts.collect()
    }
}
