//! Judges all properties of one run.

use super::always::{self, Judge};
use super::seen::Seen;
use super::senses::{Fact, Senses, Topic};
use super::sometimes::Reached;
use super::stated::Statement;
use super::verdict::{Judgement, PropertyVerdict};
use super::{Kind, Limits, Property};
use plan::Speaker;
use record::Violation;
use wire::time::Timestamp;

/// Monitors one run. Duplicate properties are judged once, by the first.
#[derive(Debug, Clone)]
pub struct Monitor {
    properties: Vec<Property>,
    /// The built-in properties of the paper's robot; `None` on a rig without it.
    of_robot: Option<Box<OfRobot>>,
    /// The plan's own properties, in order.
    stated: Vec<Statement>,
}

/// Judges the built-in properties.
#[derive(Debug, Clone)]
struct OfRobot {
    senses: Senses,
    judges: Vec<Judged>,
    /// The judges that subscribe to each topic.
    hearers: [Vec<usize>; Topic::COUNT],
    reached: Reached,
    facts: Vec<Fact>,
}

/// A built-in property, and what was judged of it so far.
#[derive(Debug, Clone)]
struct Judged {
    judge: Box<dyn Judge>,
    judgement: Judgement,
}

impl Judged {
    /// Judges a fact, and marks a violation under a fault that no input of the controller shows.
    fn hear(&mut self, senses: &Senses, fact: &Fact) {
        self.judge.judge(senses, fact, &mut self.judgement);
        if let Some(fault) = senses.unseen {
            self.judgement.unseen(fault);
        }
    }
}

impl Monitor {
    /// A monitor of `properties` on a rig with the messages of `speakers`. `limits` are those of the paper's robot if
    /// it is on the rig. They apply where a property states none; without any property, all built-in ones are judged.
    pub fn new(properties: &[Property], limits: Option<&Limits>, speakers: &[Speaker]) -> Self {
        let mut asked = properties.to_vec();
        if asked.is_empty() && limits.is_some() {
            asked = Property::all();
        }
        let mut properties: Vec<Property> = Vec::new();
        for property in asked {
            if properties.iter().all(|known| known.name() != property.name()) {
                properties.push(property);
            }
        }
        let stated = properties.iter().filter_map(|property| match property {
            Property::Stated(stated) => Some(Statement::new(stated, speakers)),
            Property::Always(_) | Property::Sometimes(_) => None,
        });
        Self {
            of_robot: limits.map(|limits| Box::new(OfRobot::new(&properties, limits))),
            stated: stated.collect(),
            properties,
        }
    }

    /// Takes an observation at `now`. Times never decrease.
    pub fn see(&mut self, now: Timestamp, seen: &Seen<'_>) {
        if let Seen::Message { speaker, decoded } = seen {
            for statement in &mut self.stated {
                statement.message(now, *speaker, decoded);
            }
        } else if let Some(of_robot) = &mut self.of_robot {
            of_robot.see(now, seen);
        }
    }

    /// The properties violated so far, each with its first violation.
    pub fn broken(&self) -> impl Iterator<Item = (&str, &Violation)> {
        let always = self.properties.iter().filter_map(|property| match property {
            Property::Always(always) => Some(always.name()),
            Property::Sometimes(_) | Property::Stated(_) => None,
        });
        let judges = self.of_robot.iter().flat_map(|of_robot| &of_robot.judges);
        let judged = always.zip(judges);
        let built_in =
            judged.filter_map(|(name, judge)| Some((name, judge.judgement.first_violation()?)));
        built_in.chain(self.stated.iter().filter_map(Statement::broken))
    }

    /// The result of each property, in the order given. The run, and with it the current lap, ends at `end`.
    pub fn verdicts(mut self, end: Timestamp) -> Vec<PropertyVerdict> {
        if let Some(of_robot) = &mut self.of_robot {
            let OfRobot { senses, judges, .. } = &mut **of_robot;
            judges.iter_mut().for_each(|judge| judge.hear(senses, &Fact::LapEnded));
        }
        let mut judges = self.of_robot.iter().flat_map(|of_robot| &of_robot.judges);
        let mut stated = self.stated.into_iter();
        let verdicts = self.properties.iter().filter_map(|property| match property {
            Property::Always(always) => {
                judges.next().map(|judge| judge.judgement.clone().verdict(always.name()))
            }
            Property::Sometimes(sometimes) => Some(PropertyVerdict {
                name: sometimes.name().to_owned(),
                kind: Kind::Sometimes,
                held: self.of_robot.as_ref().is_some_and(|one| one.reached.has(*sometimes)),
                first_violation: None,
                never_judged: None,
                margin: None,
                never_asked: None,
            }),
            Property::Stated(_) => stated.next().map(|statement| statement.verdict(end)),
        });
        verdicts.collect()
    }
}

impl OfRobot {
    fn new(properties: &[Property], limits: &Limits) -> Self {
        let judges = properties.iter().filter_map(|property| match property {
            Property::Always(property) => Some(Judged {
                judge: always::judge(property, limits),
                judgement: Judgement::default(),
            }),
            Property::Sometimes(_) | Property::Stated(_) => None,
        });
        let judges: Vec<Judged> = judges.collect();
        let mut hearers = [const { Vec::new() }; Topic::COUNT];
        for (index, judge) in judges.iter().enumerate() {
            for topic in judge.judge.hears() {
                hearers[*topic as usize].push(index);
            }
        }
        let (reached, facts) = Default::default();
        Self { senses: Senses::new(limits), judges, hearers, reached, facts }
    }

    fn see(&mut self, now: Timestamp, seen: &Seen<'_>) {
        self.facts.clear();
        self.senses.take(now, seen, &mut self.facts);
        for fact in &self.facts {
            for &judge in &self.hearers[fact.topic() as usize] {
                self.judges[judge].hear(&self.senses, fact);
            }
            self.reached.judge(&self.senses, fact);
        }
    }
}
