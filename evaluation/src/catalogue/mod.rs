//! The list of cases. It is fixed: kinds, effects, sizes, repeats and the layout of each.

mod nulls;

use crate::laps::{LAP_EFFECTS, LapEffect, LapsWorld};
use crate::noise::Noise;
use crate::odometry::{self, OdometryWorld, PATH_EFFECTS, PathEffect};
use crate::programme::Rotation;
use crate::series::{self, EFFECTS, Layout, Needs, PAIRS, SeriesEffect, SeriesWorld};
use crate::turns::{Path, TurnEffect, TurnsWorld, effects};
use crate::world::{Sizing, World};
use identification::dataset::{Drive, Kind};

/// Sizes at which every effect is generated.
pub const SIZES: [f64; 3] = [6.0, 10.0, 30.0];
/// Repeats of an effect at one size: one per layout of its kind.
const SERIES_REPEATS: usize = 3;
const HEADINGS_REPEATS: usize = 2;
const TURNS_REPEATS: usize = 4;
const LAPS_REPEATS: usize = 3;
const ODOMETRY_REPEATS: usize = 2;

/// Purpose of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Purpose {
    /// An undeclared effect of that z (or level).
    Effect(f64),
    /// Only the base and noise.
    Null(Noise),
    /// An effect of that z in a set of a stated size, to measure its time.
    Timing(f64),
}

/// Source of the data.
#[derive(Clone)]
enum Source {
    Series(Layout, Vec<&'static SeriesEffect>),
    Turns((Path, usize, Noise), Vec<&'static TurnEffect>),
    Laps((usize, Noise), Vec<&'static LapEffect>),
    Odometry(odometry::Layout, Vec<&'static PathEffect>),
}

/// One case.
#[derive(Clone)]
pub struct Case {
    /// Kind of the data, or a subgroup of it, for the tables.
    pub group: &'static str,
    /// Kind of the data.
    pub kind: Kind,
    /// Undeclared effect, or class of noise.
    pub effect: String,
    /// Family of the effect.
    pub family: &'static str,
    /// Its purpose.
    pub purpose: Purpose,
    /// Index of the repeat.
    pub repeat: usize,
    source: Source,
}

impl Case {
    /// Unique name, without blanks.
    pub fn name(&self) -> String {
        let purpose = match self.purpose {
            Purpose::Effect(z) => format!("z{z}"),
            Purpose::Null(_) => "null".into(),
            Purpose::Timing(_) => "timing".into(),
        };
        let name = format!("{}-{}-{purpose}-{}", self.group, self.effect, self.repeat);
        name.replace([' ', '_', '+', ','], "-").to_lowercase()
    }

    /// Its world with every effect of its kind.
    pub fn with_every_effect(&self, master: u64) -> Box<dyn World> {
        let source = match &self.source {
            Source::Series(layout, _) => {
                let can_show = |effect: &&SeriesEffect| layout.axes || effect.needs != Needs::Axes;
                Source::Series(*layout, EFFECTS.iter().filter(can_show).collect())
            }
            Source::Turns(layout, _) => Source::Turns(*layout, effects(layout.0).collect()),
            Source::Laps(layout, _) => Source::Laps(*layout, LAP_EFFECTS.iter().collect()),
            Source::Odometry(layout, _) => {
                let has = |effect: &&PathEffect| effect.drives.contains(&layout.drive);
                Source::Odometry(*layout, PATH_EFFECTS.iter().filter(has).collect())
            }
        };
        Self { source, ..self.clone() }.world(master)
    }

    /// Draws its world from that master seed. The size is not part of the key: an effect grows in the same data.
    pub fn world(&self, master: u64) -> Box<dyn World> {
        let key = format!("{}/{}", self.group, self.effect);
        let key = (key.as_str(), self.repeat as u64, master);
        match self.source.clone() {
            Source::Series(layout, effects) => Box::new(SeriesWorld::draw(key, layout, effects)),
            Source::Turns(layout, effects) => Box::new(TurnsWorld::draw(key, layout, effects)),
            Source::Laps(layout, effects) => Box::new(LapsWorld::draw(key, layout, effects)),
            Source::Odometry(layout, effects) => {
                Box::new(OdometryWorld::draw(key, layout, effects))
            }
        }
    }
}

fn layout(runs: usize, rows_per_run: usize, dt: f64) -> Layout {
    let rotation = Rotation::Table;
    Layout {
        runs,
        rows_per_run,
        dt,
        rotation,
        headings_every: None,
        axes: false,
        noise: Noise::White,
    }
}

/// The layouts of a `series`, one per repeat.
fn series_layout(repeat: usize) -> Layout {
    match repeat % SERIES_REPEATS {
        // Six runs of 20 minutes, and six of two hours at a tenth of the rate.
        0 => layout(6, 1_200, 1.0),
        1 => layout(6, 720, 10.0),
        _ => Layout { noise: Noise::Autoregressive(20.0), ..layout(6, 1_200, 1.0) },
    }
}

/// The layout of a repeat of the effect of that number. Each effect has one of the two long layouts, and a further set
/// of the second layout in place of the other, so that the total run time stays affordable.
fn effect_layout(number: usize, repeat: usize) -> Layout {
    let spared = if number.is_multiple_of(2) { 2 } else { 3 };
    series_layout(if repeat == spared { 1 } else { repeat })
}

fn headings_layout(repeat: usize) -> Layout {
    let (every, rows) = if repeat.is_multiple_of(2) { (5, 1_200) } else { (10, 2_400) };
    Layout { rotation: Rotation::Calm, headings_every: Some(every), ..layout(6, rows, 1.0) }
}

/// Effects that sparse headings can show.
const HEADINGS: &[&str] = &[
    "bias_over_temperature",
    "shupe",
    "scale_over_temperature",
    "supply",
    "motor_current",
    "magnetic",
    "step_of_bias",
];

fn of_series(cases: &mut Vec<Case>) {
    let mut push = |group, effects: Vec<&'static SeriesEffect>, z, repeat, layout| {
        let names: Vec<&str> = effects.iter().map(|effect| effect.name).collect();
        let family = if effects.len() > 1 { "pair" } else { effects[0].family };
        cases.push(Case {
            group,
            kind: Kind::Series,
            effect: names.join("+"),
            family,
            purpose: Purpose::Effect(z),
            repeat,
            source: Source::Series(layout, effects),
        });
    };
    for z in SIZES {
        for repeat in 0..SERIES_REPEATS {
            for (number, effect) in EFFECTS.iter().enumerate() {
                // An effect that is either present or absent has one size; it is listed with the largest.
                if matches!(effect.sizing, Sizing::Whole(_)) && z < SIZES[2] {
                    continue;
                }
                let mut layout = effect_layout(number, repeat);
                layout.axes = effect.needs == Needs::Axes;
                if effect.needs == Needs::Gentle {
                    layout.rotation = Rotation::Gentle;
                }
                push("series", vec![effect], z, repeat, layout);
            }
            for (number, pair) in PAIRS.iter().enumerate() {
                let effects = pair.iter().filter_map(|name| series::effect(name)).collect();
                push("series", effects, z, repeat, effect_layout(number, repeat));
            }
        }
        for repeat in 0..HEADINGS_REPEATS {
            for effect in HEADINGS.iter().filter_map(|name| series::effect(name)) {
                push("series-headings", vec![effect], z, repeat, headings_layout(repeat));
            }
        }
    }
}

fn turns_layout(path: Path, repeat: usize, noise: Noise) -> (Path, usize, Noise) {
    let runs = match path {
        Path::Table => [75, 100, 120, 150][repeat % 4],
        Path::Laps => [40, 80, 120][repeat % 3],
    };
    (path, runs, noise)
}

fn of_turns(cases: &mut Vec<Case>) {
    for (path, kind, group, repeats) in [
        (Path::Table, Kind::Turns, "turns", TURNS_REPEATS),
        (Path::Laps, Kind::Laps, "laps", LAPS_REPEATS),
    ] {
        for z in SIZES {
            for repeat in 0..repeats {
                for effect in effects(path) {
                    let layout = turns_layout(path, repeat, Noise::White);
                    cases.push(Case {
                        group,
                        kind,
                        effect: effect.name.into(),
                        family: effect.family,
                        purpose: Purpose::Effect(z),
                        repeat,
                        source: Source::Turns(layout, vec![effect]),
                    });
                }
            }
        }
    }
}

fn of_laps(cases: &mut Vec<Case>) {
    for z in SIZES {
        for repeat in 0..LAPS_REPEATS {
            for effect in LAP_EFFECTS {
                cases.push(Case {
                    group: "laps-odometry",
                    kind: Kind::Laps,
                    effect: effect.name.into(),
                    family: effect.family,
                    purpose: Purpose::Effect(z),
                    repeat,
                    source: Source::Laps(([40, 80, 120][repeat % 3], Noise::White), vec![effect]),
                });
            }
        }
    }
}

fn path_layout(drive: Drive, repeat: usize, noise: Noise) -> odometry::Layout {
    use odometry::Shape::{Roaming, Square};
    let (shape, runs, dt, headings_every) = match repeat % ODOMETRY_REPEATS {
        0 => (Square, 12, 0.1, 1),
        1 => (Roaming, 12, 0.1, 1),
        _ => (Square, 40, 0.05, 4),
    };
    odometry::Layout { drive, shape, runs, dt, headings_every, noise }
}

const DRIVES: [(Drive, &str); 2] =
    [(Drive::Differential, "odometry-differential"), (Drive::Synchro, "odometry-synchro")];

fn of_odometry(cases: &mut Vec<Case>) {
    for z in SIZES {
        for repeat in 0..ODOMETRY_REPEATS {
            for (drive, group) in DRIVES {
                for effect in PATH_EFFECTS.iter().filter(|effect| effect.drives.contains(&drive)) {
                    cases.push(Case {
                        group,
                        kind: Kind::Odometry,
                        effect: effect.name.into(),
                        family: "odometry",
                        purpose: Purpose::Effect(z),
                        repeat,
                        source: Source::Odometry(
                            path_layout(drive, repeat, Noise::White),
                            vec![effect],
                        ),
                    });
                }
            }
        }
    }
}

/// Every scored case, effects first.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    of_series(&mut cases);
    of_turns(&mut cases);
    of_laps(&mut cases);
    of_odometry(&mut cases);
    nulls::of_nulls(&mut cases, 1);
    cases
}

/// Noise alone, in that many times as many cases.
pub fn nulls(times: usize) -> Vec<Case> {
    let mut cases = Vec::new();
    nulls::of_nulls(&mut cases, times);
    cases
}

/// The cases whose time and memory are measured.
pub fn timing_cases() -> Vec<Case> {
    let case = |group, kind, effect: &str, source| Case {
        group,
        kind,
        effect: effect.into(),
        family: "timing",
        purpose: Purpose::Timing(30.0),
        repeat: 0,
        source,
    };
    let shupe: Vec<_> = series::effect("shupe").into_iter().collect();
    let turn: Vec<_> =
        effects(Path::Table).filter(|e| e.name == "scale_over_temperature").collect();
    vec![
        case(
            "turns",
            Kind::Turns,
            "300 turns",
            Source::Turns((Path::Table, 150, Noise::White), turn),
        ),
        case(
            "series",
            Kind::Series,
            "28,800 rows at 1 Hz",
            Source::Series(layout(4, 7_200, 1.0), shupe.clone()),
        ),
        case(
            "series",
            Kind::Series,
            "576,000 rows at 10 Hz",
            Source::Series(layout(8, 72_000, 0.1), shupe),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::MASTER_TRAIN;
    use crate::world::strength_of;
    use std::collections::BTreeSet;

    #[test]
    fn every_case_has_a_name_of_its_own_and_there_are_enough_nulls() {
        let cases = cases();
        let names: BTreeSet<String> = cases.iter().map(Case::name).collect();
        assert_eq!(names.len(), cases.len());
        let nulls = cases.iter().filter(|case| matches!(case.purpose, Purpose::Null(_))).count();
        assert!(nulls >= 300, "{nulls}");
    }

    #[test]
    fn every_effect_can_be_made_as_large_as_it_says() {
        // One layout of each: the shortest.
        for case in cases().iter().filter(|case| case.repeat < 2) {
            let Purpose::Effect(z) = case.purpose else { continue };
            let world = case.world(MASTER_TRAIN);
            let (_, reached) =
                strength_of(world.as_ref(), z).unwrap_or_else(|| panic!("{}", case.name()));
            match world.sizings()[0] {
                Sizing::Whole(_) => assert!(reached > Some(z)),
                Sizing::Level(_) => assert_eq!(reached, None),
                // Few rows lie within a small dead zone, so its size grows in steps.
                Sizing::Monotone(..) => {
                    let ratio = reached.expect("sized") / z;
                    assert!((0.99..1.25).contains(&ratio), "{}: {reached:?}", case.name());
                }
                _ => assert!(
                    (reached.expect("sized") / z - 1.0).abs() < 1e-3,
                    "{}: {reached:?}",
                    case.name()
                ),
            }
        }
    }
}
