//! Turns of a table: effects of the rate and the heading appear as means over a turn.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Identified, Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Noise of one turn, deg.
const NOISE_DEG: f64 = 0.01;
/// Duration of every ramp, s.
const RAMP_S: f64 = 4.0;

/// One turn: heading before it and angle, deg; rate, deg/s.
struct Turn {
    from: f64,
    angle: f64,
    rate: f64,
}

impl Turn {
    fn duration(&self) -> f64 {
        self.angle.abs() / self.rate + RAMP_S
    }

    /// The integral of `error` (deg/s, of rate in deg/s and heading in rad) over the turn, deg.
    fn integral(&self, error: impl Fn(f64, f64) -> f64) -> f64 {
        const STEPS: usize = 2000;
        let (duration, mut heading) = (self.duration(), self.from);
        let dt = duration / STEPS as f64;
        let mut sum = 0.0;
        for step in 0..STEPS {
            let t = (step as f64 + 0.5) * dt;
            let share = (t / RAMP_S).min((duration - t) / RAMP_S).min(1.0);
            let rate = (share * self.rate).copysign(self.angle);
            sum += error(rate, (heading + rate * dt / 2.0).to_radians()) * dt;
            heading += rate * dt;
        }
        sum
    }
}

fn identified(turns: &[Turn], error: impl Fn(f64, f64) -> f64) -> Identified {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(5);
    let mut noise = || {
        NOISE_DEG * {
            let z: f64 = StandardNormal.sample(&mut random);
            z
        }
    };
    let of = |value: &dyn Fn(&Turn) -> f64| turns.iter().map(value).collect::<Vec<f64>>();
    let gyro = turns
        .iter()
        .map(|turn| 1.001 * turn.angle + 0.002 * turn.duration() + turn.integral(&error) + noise())
        .collect();
    let dataset = Dataset::new(
        "table",
        Kind::Turns,
        vec![
            Column::new(
                "time",
                Role::Time,
                Unit::Second,
                (0..turns.len()).map(|i| 100.0 * i as f64).collect(),
            ),
            Column::new("direction", Role::Direction, Unit::One, of(&|turn| turn.angle.signum())),
            Column::new("gyro_angle", Role::GyroAngle, Unit::Degree, gyro),
            Column::new(
                "reference_angle",
                Role::ReferenceAngle,
                Unit::Degree,
                of(&|turn| turn.angle),
            ),
            Column::new(
                "table_rate",
                Role::TableRate,
                Unit::DegreePerSecond,
                of(&|turn| turn.rate.copysign(turn.angle)),
            ),
            Column::new("duration", Role::Duration, Unit::Second, of(&Turn::duration)),
            Column::new("heading", Role::Heading, Unit::Degree, of(&|turn| turn.from)),
        ],
        (0..turns.len()).map(|row| row / 2).collect(),
    );
    identify(&dataset, None, &Options::default(), &mut |_, _| {}).unwrap()
}

/// Rates that are reached within a quarter of a turn.
const SLOW: [f64; 7] = [2.0, 4.0, 6.0, 9.0, 12.0, 16.0, 20.0];
/// Rates that are reached within a whole turn.
const FAST: [f64; 7] = [5.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0];

/// There and back by `angle`, from stations round the table.
fn there_and_back(angle: f64, rates: [f64; 7]) -> Vec<Turn> {
    let mut turns = Vec::new();
    for round in 0..84 {
        let rate = rates[round % 7];
        let from = 30.0 * (round % 12) as f64;
        turns.push(Turn { from, angle, rate });
        turns.push(Turn { from: from + angle, angle: -angle, rate });
    }
    turns
}

fn number(finding: &Finding, name: &str) -> f64 {
    finding.effects[0].parameters.iter().find(|one| one.name == name).unwrap().value
}

/// A gyro that reads backwards had no word: the scale factor of the plain model took it up.
#[test]
fn a_gyro_that_reads_backwards_has_the_wrong_sign() {
    let found = identified(&there_and_back(360.0, FAST), |rate, _| -2.001 * rate);
    let names: Vec<&str> = found.finding.effects.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names, ["reversed_sign"], "{:#?}", found.finding);
    assert_eq!(found.finding.in_words()[0], "What is measured has the wrong sign.");
}

/// The readings at 60 deg/s say how much is missing there. From which rate on, only a hard limit says: of a softer one the gain
/// and the limit could be any pair.
#[test]
fn a_limit_that_one_rate_crosses_is_hard() {
    let beyond = |rate: f64, _: f64| rate.clamp(-50.0, 50.0) - rate;
    let found = identified(&there_and_back(360.0, FAST), beyond).finding;
    let words = found.in_words();
    assert!(words[0].starts_with("What is measured is clipped at 50.0 deg/s"), "{words:?}");
    assert_eq!(found.effects.len(), 1, "{words:?}");
    let parameter = |name: &str| {
        let all = &found.effects[0].parameters;
        let one = all.iter().find(|one| one.name == name).unwrap();
        (one.value, one.standard_error)
    };
    let ((gain, untold), (limit, error)) = (parameter("gain"), parameter("limit"));
    assert_eq!((gain, untold), (1.0, None));
    assert!(
        (limit - 50.0).abs() < 0.1 && error.is_some_and(|error| error < 0.05),
        "{limit} {error:?}"
    );
}

/// The scale factor is off by 0.1 %, and the bias by 0.002 deg/s.
#[test]
fn what_the_plain_model_takes_up_is_told() {
    let finding = identified(&there_and_back(360.0, FAST), |_, _| 0.0).finding;
    let said = finding.in_words().pop().unwrap();
    let expected =
        "The plain model itself takes up a bias of 0.00204 deg/s and a scale error of 0.100 %.";
    assert!(finding.effects.is_empty() && said == expected, "{said}");
}

/// With every turn taken as steady, the slope would come out at four fifths: the fastest turns are ramps for half of
/// their angle and more.
#[test]
fn scale_over_rate_has_the_slope_that_it_has_within_the_ramps() {
    const SLOPE: f64 = 1e-4;
    let identified = identified(&there_and_back(360.0, FAST), |rate, _| SLOPE * rate.abs() * rate);
    let finding = &identified.finding;
    assert_eq!(finding.effects.len(), 1, "{finding:#?}");
    let slope = number(finding, "slope");
    assert!((slope / SLOPE - 1.0).abs() < 0.01, "{slope}: {finding:#?}");
}

#[test]
fn a_bias_over_heading_shows_in_part_turns_with_its_size() {
    const SIZE: f64 = 0.05;
    let found = identified(&there_and_back(90.0, SLOW), |_, heading| SIZE * heading.cos());
    let finding = &found.finding;
    assert_eq!(finding.effects[0].name, "magnetic_heading", "{finding:#?}");
    assert!((number(finding, "cos") / SIZE - 1.0).abs() < 0.02, "{finding:#?}");
    assert!(number(finding, "sin").abs() < 0.02 * SIZE, "{finding:#?}");
}

/// In a full turn only the part remains that the ramps, at one heading, do not average out.
#[test]
fn full_turns_do_not_show_what_scales_with_the_heading() {
    let found =
        identified(&there_and_back(360.0, FAST), |rate, heading| 0.01 * rate * heading.cos());
    assert!(found.finding.effects.is_empty(), "{:#?}", found.finding);
}
