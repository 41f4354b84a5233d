use crate::dataset::{Column, Constant, Dataset, Drive, Kind, Role, Unit};
use crate::noise::{Layout, NoiseModel, Residual};
use crate::problem::{Known, Problem};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeMap;

/// Noise of a position, m, and of a heading, rad.
const NOISE: f64 = 0.02;
/// Distance between the wheels, m, and what the way of a wheel walks over a metre, m.
const TRACK: f64 = 0.4;
const SLIPS: f64 = 6e-4;

/// Six minutes of a robot that drives straight, in bends and on the spot, each for some seconds, seen once a second.
fn robot(seed: u64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let (runs, rows, step) = (6, 1200, 0.05);
    let mut columns: [Vec<f64>; 6] = Default::default();
    for _ in 0..runs {
        let mut pose = [0.0, 0.0, random.random_range(-3.0..3.0)];
        let (mut left, mut right) = (0.0, 0.0);
        let (mut speed, mut rate, mut wanted, mut until) = (0.0_f64, 0.0_f64, [0.0; 2], 0);
        for row in 0..rows {
            if row >= until {
                until = row + random.random_range(20..80);
                let bend = random.random_range(-0.9..0.9);
                wanted = match random.random_range(0..3) {
                    0 => [random.random_range(0.2..0.8), 0.0],
                    1 => [random.random_range(0.2..0.8), bend],
                    _ => [0.0, bend],
                };
            }
            if row > 0 {
                speed += (wanted[0] - speed).clamp(-step, step);
                rate += (wanted[1] - rate).clamp(-2.0 * step, 2.0 * step);
                let ways = [-1.0, 1.0].map(|side| step * (speed + side * rate * TRACK / 2.0));
                (left, right) = (left + ways[0], right + ways[1]);
                let ways = ways.map(|way| {
                    let drawn: f64 = StandardNormal.sample(&mut random);
                    way + SLIPS * way.abs().sqrt() * drawn
                });
                let turned = (ways[1] - ways[0]) / TRACK;
                let (middle, way) = (pose[2] + turned / 2.0, (ways[0] + ways[1]) / 2.0);
                pose[0] += way * middle.cos();
                pose[1] += way * middle.sin();
                pose[2] += turned;
            }
            let seen = pose.map(|value| {
                let drawn: f64 = StandardNormal.sample(&mut random);
                if row % 20 == 0 { value + NOISE * drawn } else { f64::NAN }
            });
            let values = [row as f64 * step, left, right, seen[0], seen[1], seen[2]];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
    }
    let named = [
        ("time", Role::Time, Unit::Second),
        ("left", Role::WheelLeft, Unit::Metre),
        ("right", Role::WheelRight, Unit::Metre),
        ("x", Role::ReferenceX, Unit::Metre),
        ("y", Role::ReferenceY, Unit::Metre),
        ("heading", Role::ReferenceHeading, Unit::Radian),
    ];
    let columns = named.into_iter().zip(columns);
    let columns = columns.map(|((name, role, unit), v)| Column::new(name, role, unit, v)).collect();
    let track = Constant { value: TRACK, unit: Unit::Metre };
    let run = (0..runs * rows).map(|row| row / rows).collect();
    Dataset {
        drive: Some(Drive::Differential),
        constants: BTreeMap::from([("wheelbase".to_owned(), track)]),
        ..Dataset::new("robot", Kind::Odometry, columns, run)
    }
}

/// The search had begun beside positions that walk, found no walk of the heading, and put slips of the wheels down to causes.
#[test]
fn the_walk_of_a_heading_is_found_beside_rough_positions() {
    for seed in 0..8 {
        let problem = Problem::new(&robot(seed), Known::default()).expect("a whole set");
        let block = &problem.blocks[0];
        let layout = Layout::new(block, &problem.channels);
        let residual = Residual { layout: &layout, values: &block.residual, columns: &[] };
        let found = residual.fit();
        let slips = SLIPS.powi(2) / NOISE.powi(2);
        let truth = NoiseModel {
            walk: 2.0 * slips / TRACK.powi(2),
            slide: Some([slips / 2.0, 0.0]),
            run_scale: found.run_scale.clone(),
            left_out: found.left_out.clone(),
            ..NoiseModel::white(layout.runs())
        };
        let value = |noise: &NoiseModel| residual.priced(noise);
        let behind = value(&truth) - value(&found);
        assert!(behind < 3.0, "{seed}: {behind} {found:?}");
    }
}
