//! Data of the kind `odometry`: wheels of a driven robot against motion capture. The nominal constants are the truth
//! apart from the effect.

mod effects;
mod path;

pub use effects::{PATH_EFFECTS, PathEffect};
pub use path::Shape;

use crate::design::{Design, Whitener};
use crate::noise::{Drawn, Noise};
use crate::poses::{Cause, Poses};
use crate::random::Stream;
use crate::table::{column, run_labels, sparse};
use crate::world::{Strength, World};
use identification::dataset::{Constant, Dataset, Drive, Kind, Role, Unit};
use path::{Step, path};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Constants of the differential robot: those of a small research robot with motion capture.
const TICKS_PER_REVOLUTION: f64 = 2_797.0;
const WHEEL_DIAMETER: f64 = 0.084;
const WHEELBASE: f64 = 0.2;
/// Motion capture: noise of a position (m) and a heading (rad, 0.3 deg).
const POSITION_NOISE: f64 = 0.003;
const HEADING_NOISE: f64 = 0.3 * PI / 180.0;
/// The same of a precise one, with which wheels that slip at random are told from noise of the reference.
const PRECISE: [f64; 2] = [0.001, 0.1 * PI / 180.0];
/// Slip of a wheel after a metre, m; it grows with the root of the distance (Chong and Kleeman 1997; size assumed, that
/// of the robot on square paths).
const SLIP: f64 = 0.002;
/// Pause between runs, s (assumption).
const PAUSE: f64 = 60.0;

/// How a set is driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// The robot.
    pub drive: Drive,
    /// The path.
    pub shape: Shape,
    /// Number of runs.
    pub runs: usize,
    /// Time between rows, s.
    pub dt: f64,
    /// Reference headings only every so many rows.
    pub headings_every: usize,
    /// Noise of the reference.
    pub noise: Noise,
}

/// A drawn set.
pub struct OdometryWorld {
    name: String,
    layout: Layout,
    effects: Vec<&'static PathEffect>,
    runs: Vec<Range<usize>>,
    time: Vec<f64>,
    steps: Vec<Step>,
    starts: Vec<[f64; 3]>,
    /// Distance (m) and turn (rad) by which the wheels slip in each step.
    slips: Vec<[f64; 2]>,
    noise: Drawn,
    design: Design,
}

impl OdometryWorld {
    /// Draws the set of that case.
    pub fn draw(
        (case, index, master): (&str, u64, u64),
        layout: Layout,
        effects: Vec<&'static PathEffect>,
    ) -> Self {
        let mut stream = Stream::new(master, case, index, "programme");
        let side = stream.between(1.0, 2.0);
        let (mut runs, mut time, mut steps, mut starts) = (vec![], vec![], vec![], vec![]);
        let mut start = 0.0;
        for run in 0..layout.runs {
            let mut of_run = path(&mut stream, layout.shape, run, side, layout.dt);
            if layout.drive == Drive::Differential {
                in_whole_counts(&mut of_run);
            }
            runs.push(steps.len()..steps.len() + of_run.len());
            time.extend((0..of_run.len()).map(|k| start + k as f64 * layout.dt));
            start += of_run.len() as f64 * layout.dt + PAUSE;
            steps.extend(of_run);
            starts.push([
                stream.between(-1.0, 1.0),
                stream.between(-1.0, 1.0),
                stream.between(-PI, PI),
            ]);
        }
        let mut stream = Stream::new(master, case, index, "noise");
        let is_slipping = layout.noise == Noise::Slip;
        let slips: Vec<[f64; 2]> = steps
            .iter()
            .map(|step| if is_slipping { slip(&mut stream, step) } else { [0.0; 2] })
            .collect();
        let [position, heading] =
            if is_slipping { PRECISE } else { [POSITION_NOISE, HEADING_NOISE] };
        let sd = [position, position, heading].repeat(steps.len());
        let blocks: Vec<_> = runs.iter().map(|run| 3 * run.start..3 * run.end).collect();
        let noise = layout.noise.draw(&mut stream, &blocks, &sd);
        let whitener = match &noise.whitener {
            Whitener::Autoregressive(_) | Whitener::Neighbours(_) => Whitener::Independent(sd),
            independent => independent.clone(),
        };
        let design = Design { blocks, base: Vec::new(), local: Vec::new(), whitener };
        let name = format!("{case}-{index}");
        let mut world =
            Self { name, layout, effects, runs, time, steps, starts, slips, noise, design };
        world.design.local = world.start_columns();
        world
    }

    /// Effect of a small error of the start pose of each run on all its poses.
    fn start_columns(&self) -> Vec<Vec<f64>> {
        let poses = self.poses(&[]);
        let mut columns = vec![Vec::new(); 3];
        for (run, start) in self.runs.iter().zip(&self.starts) {
            for pose in poses[3 * run.start..3 * run.end].chunks_exact(3) {
                columns[0].extend([1.0, 0.0, 0.0]);
                columns[1].extend([0.0, 1.0, 0.0]);
                columns[2].extend([-(pose[1] - start[1]), pose[0] - start[0], 1.0]);
            }
        }
        columns
    }

    /// For each row, the sum of the step's contributions since the start of the run.
    fn sums(&self, of: impl Fn(&Step) -> f64) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.steps.len());
        for run in &self.runs {
            let mut sum = 0.0;
            for k in run.clone() {
                if k > run.start {
                    sum += of(&self.steps[k]);
                }
                out.push(sum);
            }
        }
        out
    }

    /// Encoder counts since the previous row.
    fn counts(&self, side: f64) -> Vec<f64> {
        let mut counts: Vec<f64> =
            self.steps.iter().map(|step| wheel(step, side).round()).collect();
        for run in &self.runs {
            counts[run.start] = 0.0;
        }
        counts
    }
}

const COUNTS_PER_METRE: f64 = TICKS_PER_REVOLUTION / (PI * WHEEL_DIAMETER);

/// Counts of the wheel on that side (+1 right, -1 left) in one step.
fn wheel(step: &Step, side: f64) -> f64 {
    (step.distance + side * step.turned * WHEELBASE / 2.0) * COUNTS_PER_METRE
}

/// What the wheels of a differential robot slip in a step, as a distance and a turn.
fn slip(stream: &mut Stream, step: &Step) -> [f64; 2] {
    let mut of_wheel = |side: f64| {
        let way = step.distance + side * step.turned * WHEELBASE / 2.0;
        SLIP * way.abs().sqrt() * stream.normal()
    };
    let (right, left) = (of_wheel(1.0), of_wheel(-1.0));
    [(right + left) / 2.0, (right - left) / WHEELBASE]
}

/// Rounds every wheel's motion to whole counts, so that counting adds no error, which the known noise would not
/// include.
fn in_whole_counts(steps: &mut [Step]) {
    let mut carried = [0.0; 2];
    for step in steps {
        let mut moved = [0.0; 2];
        for ((side, carried), moved) in [1.0, -1.0].iter().zip(&mut carried).zip(&mut moved) {
            *carried += wheel(step, *side);
            *moved = carried.round();
            *carried -= *moved;
        }
        let [right, left] = moved;
        step.distance = (right + left) / 2.0 / COUNTS_PER_METRE;
        step.turned = (right - left) / WHEELBASE / COUNTS_PER_METRE;
    }
}

impl Poses for OdometryWorld {
    fn dataset(&self, strength: &Strength) -> Dataset {
        let observed = self.observed(strength);
        let pose =
            |part: usize| observed.iter().skip(part).step_by(3).copied().collect::<Vec<f64>>();
        let wrap = |x: f64| (x + PI).rem_euclid(TAU) - PI;
        let step = self.noise.step;
        let row_in_run: Vec<usize> = self.runs.iter().flat_map(|run| 0..run.len()).collect();
        let headings = pose(2).into_iter().map(wrap).collect();
        let headings = sparse(headings, |k| row_in_run[k], self.layout.headings_every);
        let metre = Unit::Metre;
        let mut columns = vec![
            column("time", Role::Time, Unit::Second, self.time.clone(), 0.0),
            column("reference_x", Role::ReferenceX, metre, pose(0), step * POSITION_NOISE),
            column("reference_y", Role::ReferenceY, metre, pose(1), step * POSITION_NOISE),
            column(
                "reference_heading",
                Role::ReferenceHeading,
                Unit::Radian,
                headings,
                step * HEADING_NOISE,
            ),
        ];
        let mut constants = BTreeMap::new();
        let mut constant = |name: &str, value, unit| {
            constants.insert(name.to_owned(), Constant { value, unit });
        };
        if self.layout.drive == Drive::Differential {
            constant("encoder_ticks_per_revolution", TICKS_PER_REVOLUTION, Unit::Count);
            constant("wheel_diameter_left", WHEEL_DIAMETER, metre);
            constant("wheel_diameter_right", WHEEL_DIAMETER, metre);
            constant("wheelbase", WHEELBASE, metre);
            columns.push(column(
                "wheel_left",
                Role::WheelLeft,
                Unit::Count,
                self.counts(-1.0),
                0.0,
            ));
            columns.push(column(
                "wheel_right",
                Role::WheelRight,
                Unit::Count,
                self.counts(1.0),
                0.0,
            ));
        } else {
            let (driven, steered) = (self.sums(|s| s.distance), self.sums(|s| s.turned));
            columns.push(column("drive_distance", Role::DriveDistance, metre, driven, 1e-5));
            columns.push(column("steer_angle", Role::SteerAngle, Unit::Radian, steered, 1e-5));
        }
        let run_of_row = self.runs.iter().enumerate();
        Dataset {
            name: self.name.clone(),
            kind: Kind::Odometry,
            drive: Some(self.layout.drive),
            constants,
            columns,
            run_of_row: run_of_row.flat_map(|(run, rows)| rows.clone().map(move |_| run)).collect(),
            run_labels: run_labels(self.runs.len()),
            notices: Vec::new(),
        }
    }

    fn design(&self) -> &Design {
        &self.design
    }

    fn poses(&self, sizes: &[(usize, f64)]) -> Vec<f64> {
        let mut out = Vec::with_capacity(3 * self.steps.len());
        for (run, start) in self.runs.iter().zip(&self.starts) {
            let [mut x, mut y, mut heading] = *start;
            let mut steered = 0.0;
            for k in run.clone() {
                let step = &self.steps[k];
                let [slid, spun] = self.slips[k];
                let (mut distance, mut turned) = (step.distance + slid, step.turned + spun);
                for &(effect, size) in sizes {
                    let (further, rotated) =
                        (self.effects[effect].error)(step, self.time[k], steered);
                    distance += size * further;
                    turned += size * rotated;
                }
                // The first row is the start: motion before it belongs to no run.
                if k > run.start {
                    let middle = heading + turned / 2.0;
                    x += distance * middle.cos();
                    y += distance * middle.sin();
                    heading += turned;
                    steered += step.turned;
                }
                out.extend([x, y, heading]);
            }
        }
        out
    }

    fn noise(&self) -> &Drawn {
        &self.noise
    }

    fn causes(&self) -> Vec<Cause> {
        let cause = |effect: &&'static PathEffect| Cause {
            name: effect.name,
            spellings: effect.spellings,
            unit: effect.unit,
        };
        self.effects.iter().map(cause).collect()
    }
}
