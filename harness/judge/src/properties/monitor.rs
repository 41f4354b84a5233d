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
use wire::base::Motion;
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
    /// The same in the world as the inputs of the controller show it, once the two differ.
    apparent: Option<Box<(Box<dyn Judge>, Judgement)>>,
    /// The violation is marked with what was hidden: that world does not have it.
    is_explained: bool,
}

impl Judged {
    fn new(judge: Box<dyn Judge>) -> Self {
        Self { judge, judgement: Judgement::default(), apparent: None, is_explained: false }
    }

    fn hear(&mut self, senses: &Senses, fact: &Fact) {
        self.judge.judge(senses, fact, &mut self.judgement);
    }

    /// From now on, the inputs show another world.
    fn part(&mut self) {
        self.apparent = Some(Box::new((self.judge.clone(), self.judgement.clone())));
    }

    const fn has_parted(&self) -> bool {
        self.apparent.is_some()
    }

    fn hear_apparent(&mut self, senses: &Senses, fact: &Fact) {
        let Some(apparent) = &mut self.apparent else { return };
        let (judge, judgement) = &mut **apparent;
        judge.judge(senses, fact, judgement);
    }

    /// Marks a violation that the world of the inputs does not have, as long as it does not.
    fn explain(&mut self, senses: &Senses) {
        let Some(apparent) = &self.apparent else { return };
        let broken = |judgement: &Judgement| judgement.first_violation().is_some();
        let (real, too) = (broken(&self.judgement), broken(&apparent.1));
        if real && !too && !self.is_explained {
            self.judgement.is_explained(&senses.hidden.names());
            self.is_explained = true;
        } else if too && self.is_explained {
            self.judgement.take_violation(&apparent.1);
            self.is_explained = false;
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

    /// The motion of the paper's base, if it was heard at `now`.
    pub fn motion_heard(&self, now: Timestamp) -> Option<Motion> {
        self.of_robot.as_ref()?.senses.motion_heard(now)
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

    /// The result of each property, in the order given. The run, and with it the current step, ends at `end`.
    pub fn verdicts(mut self, end: Timestamp) -> Vec<PropertyVerdict> {
        if let Some(of_robot) = &mut self.of_robot {
            let OfRobot { senses, judges, .. } = &mut **of_robot;
            let all: Vec<usize> = (0..judges.len()).collect();
            judge(senses, judges, &all, &Fact::StepEnded);
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
            Property::Always(property) => Some(Judged::new(always::judge(property, limits))),
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
        let Self { senses, judges, hearers, reached, facts } = self;
        for fact in facts {
            judge(senses, judges, &hearers[fact.topic() as usize], fact);
            reached.judge(senses, fact);
        }
    }
}

/// Judges a fact in both worlds, by the judges at these places.
fn judge(senses: &mut Senses, judges: &mut [Judged], hearers: &[usize], fact: &Fact) {
    let have_parted = |judges: &[Judged]| judges.first().is_some_and(Judged::has_parted);
    if !have_parted(judges) && senses.hidden.is_any() {
        judges.iter_mut().for_each(Judged::part);
    }
    for &place in hearers {
        judges[place].hear(senses, fact);
    }
    if have_parted(judges) {
        senses.in_apparent(|senses| {
            for &place in hearers {
                judges[place].hear_apparent(senses, fact);
            }
        });
        judges.iter_mut().for_each(|judged| judged.explain(senses));
    }
}
