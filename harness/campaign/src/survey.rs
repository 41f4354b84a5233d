//! Draws cases that cover a space evenly: every kind of fault early, in every phase, the worst severity first.
//!
//! Independent draws see each of n kinds only after n ln n cases (coupon collector), and may keep one kind at its
//! mildest for long. Here kinds are dealt from a shuffled deck, and each kind goes through phases, directions and
//! severities separately: phases from a deck too, severities from the worst down in the van der Corput order (1, 1/2,
//! 3/4, 1/4 ...), each in both directions if the kind has them, times of the run in steps of the golden ratio. An injected
//! fault is a boundary value: most of its effects occur at its worst. Messages and signals take turns in their kinds.

use super::case::Case;
use super::search::Dice;
use super::space::{Space, duration, whole_ms};
use plan::faults::{Fault, Lasts, Schedule, Toward, When};
use rand::RngExt as _;
use rand::seq::SliceRandom as _;

/// The most draws of a case until one of its faults is applicable.
const TRIES: usize = 50;
/// Share of cases with the maximum number of faults, each of another kind. The others have fewer, because one fault may
/// hide the effects of another.
const CROWDED: f64 = 0.75;
/// Share of faults that are tied to a phase of the plan.
const IN_PHASE: f64 = 0.6;
/// Of these, the share that lasts as long as the phase.
const WHOLE_PHASE: f64 = 0.5;
/// A kind without visible effect still keeps this share of its turns: it may have an effect elsewhere.
const QUIET_MIN: f64 = 0.2;

/// Progress of one kind through the space.
#[derive(Debug, Clone, Default)]
struct Lane {
    /// The kind on its targets: indices among the kinds of the space.
    kinds: Vec<usize>,
    /// Those whose turn it is, if there are several.
    turns: Vec<usize>,
    /// Number of faults drawn.
    drawn: u64,
    /// Remaining phases; an index beyond them stands for a time of the run.
    phases: Vec<usize>,
    /// Start of the last fault in the run, as a share of it.
    at: f64,
    /// Number of cases with it; `stirred`: number of those that differed from a run without faults.
    cases: u32,
    stirred: u32,
}

/// Draws cases evenly.
#[derive(Debug)]
pub(super) struct Survey {
    space: Space,
    lanes: Vec<Lane>,
    deck: Vec<usize>,
}

impl Survey {
    pub(super) fn new(space: &Space, dice: &mut Dice) -> Self {
        let lane = |kinds| Lane { kinds, at: dice.random.random(), ..Lane::default() };
        let lanes = space.lanes().into_iter().map(lane).collect();
        Self { space: space.clone(), lanes, deck: Vec::new() }
    }

    /// The next case; without any fault if none of those drawn is applicable.
    pub(super) fn case(&mut self, dice: &mut Dice) -> Case {
        let seed = dice.seed();
        let mut schedule = Schedule::default();
        for _ in 0..TRIES {
            let most = self.space.faults_max();
            let crowded = dice.random.random_bool(CROWDED);
            let count = if crowded { most } else { dice.random.random_range(1..=most) };
            for _ in 0..count {
                schedule.faults.extend(self.fault(dice));
                if !self.space.takes(&schedule) {
                    schedule.faults.pop();
                }
            }
            if !schedule.is_empty() {
                break;
            }
        }
        Case { seed, schedule }
    }

    /// The next fault; `None` in an empty space.
    pub(super) fn fault(&mut self, dice: &mut Dice) -> Option<Fault> {
        let index = self.kind(dice)?;
        let when = self.when(index, dice);
        let lane = self.lanes.get_mut(index)?;
        let number = lane.drawn;
        lane.drawn += 1;
        let (target, kind) = *self.space.kinds().get(lane.turn(dice)?)?;
        let (round, turn) = (number / lane.kinds.len() as u64, number % lane.kinds.len() as u64);
        let (round, negative) = match kind.is_signed() {
            true => (round / 2, (round + turn) % 2 == 1),
            false => (round, false),
        };
        let what = self.space.sized((target, kind), 1.0 - van_der_corput(round), negative);
        let info = what.info();
        let lasting = dice.random.random();
        let whole = matches!(when, When::During { .. });
        let duration = (info.lasts == Lasts::Scheduled && !whole)
            .then(|| duration(self.space.horizon(), lasting));
        let toward = match (index as u64 + number) % 3 {
            0 => Toward::Both,
            1 => Toward::Host,
            _ => Toward::Device,
        };
        let toward = self.space.toward((target, what), toward);
        Some(Fault { toward, when, duration, ..Fault::new(target, what) })
    }

    /// Learns the kinds in a case, and whether it differed from a run without faults.
    pub(super) fn learn(&mut self, case: &Case, stirred: bool) {
        for fault in &case.schedule.faults {
            let is_it = |(target, kind): &(_, plan::faults::FaultKind)| {
                *target == fault.target && kind.name() == fault.what.name()
            };
            let place = self.space.kinds().iter().position(is_it);
            let lane = |lane: &&mut Lane| place.is_some_and(|place| lane.kinds.contains(&place));
            if let Some(lane) = self.lanes.iter_mut().find(lane) {
                lane.cases += 1;
                lane.stirred += u32::from(stirred);
            }
        }
    }

    fn kind(&mut self, dice: &mut Dice) -> Option<usize> {
        loop {
            if self.deck.is_empty() {
                self.deck = (0..self.lanes.len()).collect();
                self.deck.shuffle(&mut dice.random);
            }
            let index = self.deck.pop()?;
            let lane = &self.lanes[index];
            let share = f64::from(lane.stirred + 1) / f64::from(lane.cases + 1);
            if dice.random.random_bool(share.clamp(QUIET_MIN, 1.0)) {
                return Some(index);
            }
        }
    }

    fn when(&mut self, index: usize, dice: &mut Dice) -> When {
        let phases = self.space.phases();
        let lane = &mut self.lanes[index];
        if lane.phases.is_empty() {
            // As many times of the run as the share requires, but at least one.
            let timed = (phases.len() as f64 * (1.0 - IN_PHASE) / IN_PHASE).round().max(1.0);
            lane.phases = (0..phases.len() + timed as usize).collect();
            lane.phases.shuffle(&mut dice.random);
        }
        let phase = lane.phases.pop().and_then(|next| phases.get(next));
        let Some((phase, times)) = phase.cloned() else {
            lane.at = (lane.at + GOLDEN).fract();
            return When::At(whole_ms(lane.at * self.space.horizon().as_secs_f64()));
        };
        let number = dice.random.random_range(1..=times);
        if dice.random.random_bool(WHOLE_PHASE) {
            return When::During { phase, number };
        }
        let after = self.space.course().within(&phase, number, dice.random.random());
        When::Step { phase, number, after }
    }
}

impl Lane {
    /// The kind and target whose turn it is.
    fn turn(&mut self, dice: &mut Dice) -> Option<usize> {
        if let [only] = self.kinds[..] {
            return Some(only);
        }
        if self.turns.is_empty() {
            self.turns.clone_from(&self.kinds);
            self.turns.shuffle(&mut dice.random);
        }
        self.turns.pop()
    }
}

/// Its multiples modulo one are as evenly spaced as possible (Weyl).
const GOLDEN: f64 = 0.618_033_988_749_895;

/// The number with its binary digits mirrored at the point: 0, 1/2, 1/4, 3/4 ...
fn van_der_corput(number: u64) -> f64 {
    // Of 64 digits, the 53 that a float can represent.
    (number.reverse_bits() >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::{Survey, van_der_corput};
    use crate::search::Dice;
    use crate::toy::{size, space};
    use crate::{Random, Search, Space};
    use plan::Plan;
    use plan::faults::{LineKind, Lines, Target, Toward};
    use std::collections::BTreeSet;
    use wire::time::Span;

    #[test]
    fn shares_fall_between_those_before() {
        let shares: Vec<f64> = (0..5).map(van_der_corput).collect();
        assert_eq!(shares, [0.0, 0.5, 0.25, 0.75, 0.125]);
    }

    #[test]
    fn every_kind_has_come_at_its_worst_when_the_deck_is_through() {
        let space = space();
        let mut dice = Dice::new(1);
        let mut survey = Survey::new(&space, &mut dice);
        let faults: Vec<_> =
            (0..space.kinds().len()).filter_map(|_| survey.fault(&mut dice)).collect();
        let kinds: BTreeSet<_> = faults.iter().map(|f| (f.target, f.what.name())).collect();
        assert_eq!(kinds.len(), space.kinds().len());
        assert!(faults.iter().all(|fault| size(fault) > 0.999), "{faults:?}");
    }

    /// Found by a user: no fault was ever drawn in its negative direction.
    #[test]
    fn both_directions_come_at_their_worst() {
        let space = space();
        let mut dice = Dice::new(1);
        let mut survey = Survey::new(&space, &mut dice);
        let faults: Vec<_> =
            (0..4 * space.kinds().len()).filter_map(|_| survey.fault(&mut dice)).collect();
        let worst = |name: &str, sign: f64| {
            faults.iter().any(|fault| {
                let values = fault.what.values();
                fault.what.name() == name && size(fault) > 0.999 && values[0] * sign > 0.0
            })
        };
        for name in ["bias_step", "clock_step", "encoder_jump", "baud_drift"] {
            assert!(worst(name, 1.0) && worst(name, -1.0), "{name}");
        }
    }

    /// Found by a user: faults of a line with a direction did nothing, or struck both ways, and counted as tried.
    #[test]
    fn a_line_of_a_rig_has_no_direction() {
        let target = |name: &str| (Target::named(name).unwrap(), LineKind::Can);
        let nodes = ["motor", "can0"].map(target).to_vec();
        let shared = vec![Target::named("can0").unwrap()];
        let lines = Lines { nodes, shared, ..Lines::default() };
        let plan = "name = \"p\"\ntitle = \"\"\nrig = \"r\"\nsteps = [{ wait = { duration_s = 1 } }]\n\
            [[property]]\nname = \"on\"\nalways = \"motor.State > 0\"\n";
        let plan = Plan::parse("p.toml", plan).unwrap();
        let space = Space::new(&plan, lines, Span::from_secs(1), 4, &[]);
        let searches: [Box<dyn Search>; 2] =
            [Box::new(crate::Guided::new(&space, 1)), Box::new(Random::new(&space, 1))];
        for mut search in searches {
            let faults: Vec<_> = (0..200).flat_map(|_| search.next().schedule.faults).collect();
            let toward = |name: &str| -> BTreeSet<&str> {
                let of = faults.iter().filter(|fault| fault.target.name() == name);
                of.map(|fault| match fault.toward {
                    Toward::Both => "both",
                    Toward::Host => "host",
                    Toward::Device => "device",
                })
                .collect()
            };
            assert_eq!(toward("can0"), ["both"].into());
            assert_eq!(toward("motor"), ["both", "device", "host"].into());
        }
    }

    #[test]
    fn kinds_that_do_nothing_come_less_often() {
        let space = space();
        let mut dice = Dice::new(1);
        let mut survey = Survey::new(&space, &mut dice);
        let quiet = space.kinds()[0].1.name();
        let mut times = [0, 0];
        for _ in 0..500 {
            let case = survey.case(&mut dice);
            assert!((1..=space.faults_max()).contains(&case.schedule.faults.len()));
            let is_quiet = |name: &str| name == quiet;
            let stirred = case.schedule.faults.iter().any(|f| !is_quiet(f.what.name()));
            for fault in &case.schedule.faults {
                times[usize::from(is_quiet(fault.what.name()))] += 1;
            }
            let mut alone = case.clone();
            alone.schedule.faults.retain(|f| is_quiet(f.what.name()));
            survey.learn(&alone, false);
            survey.learn(&case, stirred);
        }
        let same_name = space.kinds().iter().filter(|(_, kind)| kind.name() == quiet).count();
        let even = times.iter().sum::<usize>() * same_name / space.kinds().len();
        assert!(times[1] * 4 < even * 3, "{times:?}, evenly {even}");
    }
}
