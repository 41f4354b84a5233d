//! Plans for the rotary table.

use super::step::{Programme, Step, TABLE, TURN_RAMP, table_run};
use super::surroundings::{Level, ROOM};

/// Change of the room temperature to each side, K (assumption: a small climate chamber or a heater and an open window).
pub(super) const AMBIENT_SWING: f64 = 12.0;
/// Rates of the ladder, deg/s (assumption: a stepper table reaches 60).
const LADDER: [f64; 12] = [2.0, 4.0, 6.0, 8.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0];
/// Table runs of 48 s in an hour, back to back.
const RUNS_PER_HOUR: usize = 75;
/// A low and a high rate, deg/s.
const SLOW: f64 = 10.0;
const FAST: f64 = 60.0;
/// Time at rest after which the gyro counts as resting (assumption: some states of the controller, one a second).
const SETTLED_S: f64 = 5.0;
/// Headings at which the table stops.
const STATIONS: usize = 8;

/// Plans that a table can run, in order of increasing duration.
pub(super) fn table(levels: &[Level]) -> Vec<Programme> {
    let mut menu = vec![
        plan(
            "reversals",
            "Short turns there and back",
            "what comes late shows at every change of the rate, what is off in scale does not",
            vec![Step::again(
                60,
                vec![Step::Rest(4.0), Step::TableTurn(30.0, 30.0), Step::TableTurn(-30.0, 30.0)],
            )],
        ),
        plan(
            "heading-stations",
            "Table runs at eight headings, at rest in between",
            "what depends on the heading repeats with it, what depends on time or temperature does not",
            vec![Step::again(4 * STATIONS, station())],
        ),
        plan(
            "rate-ladder",
            "Turns both ways at twelve rates",
            "the powers of the rate part where it is low and where it is high; a turn at a low rate is long and shows \
             the bias",
            vec![Step::again(4, ladder())],
        ),
        hot_restart(),
        plan(
            "ambient-sine-fast",
            "Table runs while the room's temperature goes up and down in 20 minutes",
            "the rate of change and the lag of a temperature lead and trail it by a share of the period",
            runs_in_a_sine(1200.0, 10, 9),
        ),
        plan(
            "ambient-steps",
            "Table runs at constant and at suddenly changed temperatures of the room, up and down",
            "at equal temperatures the gyro is warming or cooling, or has been on for a different time",
            vec![Step::Sweep {
                ambient: [0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0]
                    .map(|s| ROOM + s * AMBIENT_SWING)
                    .to_vec(),
                steps: vec![Step::again(RUNS_PER_HOUR * 2 / 3, table_run())],
            }],
        ),
        plan(
            "ladder-at-two-temperatures",
            "Turns both ways at twelve rates, in a cold and in a warm room",
            "rate and temperature vary independently of each other",
            vec![Step::Sweep {
                ambient: vec![ROOM - AMBIENT_SWING, ROOM + AMBIENT_SWING],
                steps: vec![Step::Rest(5400.0), Step::again(3, ladder())],
            }],
        ),
        plan(
            "ambient-sine-slow",
            "Table runs while the room's temperature goes up and down in two hours",
            "the gyro follows the room, so that the same temperatures are passed upward and downward, again and again",
            runs_in_a_sine(7200.0, 24, 3),
        ),
        plan(
            "rates-in-a-changing-room",
            "Slow and fast turns both ways while the room's temperature goes up and down in two hours",
            "rate, direction, temperature and its rate of change vary independently of one another",
            vec![Step::Sweep {
                ambient: sine(24, 4),
                steps: vec![Step::Repeat {
                    times: 2,
                    period_s: Some(150.0),
                    steps: slow_and_fast(),
                }],
            }],
        ),
        plan(
            "long-rest",
            "Eight hours at rest in a constant room, table runs before and after",
            "what goes on with time goes on after the temperature is steady",
            vec![
                Step::again(10, table_run()),
                Step::Rest(8.0 * 3600.0),
                Step::again(10, table_run()),
            ],
        ),
        plan(
            "hours-apart",
            "The same table runs every hour for sixteen hours, in a constant room",
            "what ages or wanders differs from hour to hour at the same temperature",
            vec![Step::Repeat {
                times: 16,
                period_s: Some(3600.0),
                steps: vec![Step::again(20, table_run())],
            }],
        ),
    ];
    if !levels.is_empty() {
        menu.insert(0, by_hand(levels));
    }
    menu
}

fn plan(
    name: &'static str,
    title: &'static str,
    reason: &'static str,
    steps: Vec<Step>,
) -> Programme {
    Programme { name, title, reason, devices: TABLE, warm: false, steps }
}

fn hot_restart() -> Programme {
    let ask = "Let the gyro run for two hours. Then switch it off for 10 s and on again, and go on at once.";
    let steps = vec![Step::Ask(ask.to_owned()), Step::again(2 * RUNS_PER_HOUR, table_run())];
    Programme {
        warm: true,
        ..plan(
            "hot-restart",
            "Table runs from a power-up while the gyro is warm",
            "time since power-up begins anew while the temperature is steady already",
            steps,
        )
    }
}

/// Whole turns at each rate, a bias test before each pair. A bias test is refused while the last second's mean rate
/// looks like motion, which is still the case after a slow turn.
fn ladder() -> Vec<Step> {
    LADDER
        .into_iter()
        .flat_map(|rate| {
            let turn = |angle| Step::TableTurn(angle, rate);
            [Step::Rest(SETTLED_S), Step::BiasTest, turn(-360.0), turn(360.0)]
        })
        .collect()
}

fn station() -> Vec<Step> {
    let mut steps = vec![Step::Rest(30.0)];
    steps.extend(table_run());
    steps.push(Step::TableTurn(360.0 / STATIONS as f64, TURN_RAMP));
    steps
}

/// A bias test, and a turn each way at a low and at a high rate: 2 min.
fn slow_and_fast() -> Vec<Step> {
    let rates = [(-360.0, SLOW), (360.0, SLOW), (-360.0, FAST), (360.0, FAST)];
    let turns = rates.map(|(angle, rate)| Step::TableTurn(angle, rate));
    [Step::Rest(SETTLED_S), Step::BiasTest].into_iter().chain(turns).collect()
}

/// An hour at room temperature, then `periods` of a sine in `count` steps a period, with table runs throughout.
fn runs_in_a_sine(period_s: f64, count: usize, periods: usize) -> Vec<Step> {
    const RUN_S: f64 = 48.0;
    let runs = (period_s / count as f64 / RUN_S).floor();
    let rest = period_s / count as f64 - runs * RUN_S;
    let mut steps = vec![Step::again(runs as usize, table_run())];
    if rest > 0.0 {
        steps.push(Step::Rest(rest));
    }
    vec![
        Step::Ambient(ROOM),
        Step::again(RUNS_PER_HOUR, table_run()),
        Step::Sweep { ambient: sine(count, periods), steps },
    ]
}

/// Temperatures of the room along a sine.
fn sine(count: usize, periods: usize) -> Vec<f64> {
    let value = |k: usize| {
        let phase = std::f64::consts::TAU * k as f64 / count as f64;
        // Room temperatures are set to tenths of a degree.
        ((ROOM + AMBIENT_SWING * phase.sin()) * 10.0).round() / 10.0
    };
    (1..=count * periods).map(value).collect()
}

/// Fields that a person sets: each at its lowest and highest value in turn, the others unchanged.
fn by_hand(levels: &[Level]) -> Programme {
    let mut steps = Vec::new();
    for level in levels {
        for _ in 0..4 {
            for value in [level.low, level.high] {
                let (field, unit) = (level.field.clone(), level.unit);
                steps.push(Step::Level { field, unit, value });
                steps.push(Step::Rest(60.0));
                steps.push(Step::again(6, table_run()));
            }
        }
    }
    plan(
        "levels-by-hand",
        "Table runs while a person moves what the bench does not control",
        "the field is moved on purpose while everything else stays as it is; write its value beside the run",
        steps,
    )
}
