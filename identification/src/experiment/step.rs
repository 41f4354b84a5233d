//! Steps on the bench: the one source of both the written plan and the rows it would yield.

/// Rate of the paper's turns, deg/s.
pub(super) const RATE: f64 = 30.0;
/// Ramps of the table and of turns, deg/s^2: they give the paper's table run of 48 s.
pub(super) const TURN_RAMP: f64 = 15.0;
/// Ramps of speed, m/s^2: they give the paper's lap of 64 s.
pub(super) const SPEED_RAMP: f64 = 0.4;
/// The paper's static bias test, s.
pub(super) const BIAS_TEST_S: f64 = 20.0;
/// The paper's speed of laps, m/s.
pub(super) const SPEED: f64 = 0.4;
/// The paper's side of a lap, m.
pub(super) const SIDE: f64 = 4.0;

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Step {
    /// Sets the room temperature, degC.
    Ambient(f64),
    /// A log at rest, s.
    Rest(f64),
    /// A static bias test.
    BiasTest,
    /// A turn of the table: degrees, counter-clockwise positive, and deg/s without sign.
    TableTurn(f64, f64),
    /// A prompt for a person.
    Ask(String),
    /// A person sets a field that no device of the bench controls.
    Level { field: String, unit: &'static str, value: f64 },
    /// Placing the robot at the origin, with that heading in degrees.
    Place(f64),
    /// A straight line: metres, negative backwards, and m/s.
    Straight(f64, f64),
    /// A turn of the robot on the spot: degrees and deg/s.
    Turn(f64, f64),
    /// A lap of the square path, counter-clockwise or not: side in m, speed in m/s, turns in deg/s.
    Lap { ccw: bool, side: f64, speed: f64, rate: f64 },
    /// Repeated steps, with that many seconds from start to start.
    Repeat { times: usize, period_s: Option<f64>, steps: Vec<Step> },
    /// Steps at each of these room temperatures, degC.
    Sweep { ambient: Vec<f64>, steps: Vec<Step> },
}

impl Step {
    /// `times` repetitions, one after the other.
    pub(super) fn again(times: usize, steps: Vec<Self>) -> Self {
        Self::Repeat { times, period_s: None, steps }
    }
}

/// The shipped device files of a bench whose table, or whose base, carries the gyro.
pub(super) const TABLE: &str = "paper-table";
pub(super) const BASE: &str = "paper";

/// A plan of the menu.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Programme {
    /// Name of the plan, and of its file.
    pub name: &'static str,
    /// Its title, in one line.
    pub title: &'static str,
    /// How it separates causes.
    pub reason: &'static str,
    /// The device file of its bench.
    pub devices: &'static str,
    /// Whether the gyro is at its steady temperature when time starts; otherwise it starts at room temperature.
    pub warm: bool,
    /// The steps, in order.
    pub steps: Vec<Step>,
}

impl Programme {
    /// The programme with a bias test at the start alone and logs at rest in place of the others: effects on the bias
    /// then show before a test subtracts them.
    pub(super) fn with_one_bias_test(mut self) -> Self {
        fn logs(steps: &mut [Step]) {
            for step in steps {
                match step {
                    Step::BiasTest => *step = Step::Rest(BIAS_TEST_S),
                    Step::Repeat { steps, .. } | Step::Sweep { steps, .. } => logs(steps),
                    _ => {}
                }
            }
        }
        logs(&mut self.steps);
        let asked = self.steps.iter().take_while(|step| matches!(step, Step::Ask(_))).count();
        self.steps.insert(asked, Step::BiasTest);
        self
    }
}

/// The paper's table run: a bias test and one turn each way, 48 s.
pub(super) fn table_run() -> Vec<Step> {
    vec![Step::BiasTest, Step::TableTurn(-360.0, RATE), Step::TableTurn(360.0, RATE)]
}

/// The paper's robot run: a bias test and a lap, each way.
pub(super) fn laps(side: f64, speed: f64, rate: f64) -> Vec<Step> {
    let lap = |ccw| Step::Lap { ccw, side, speed, rate };
    vec![Step::Place(0.0), Step::BiasTest, lap(false), Step::Place(0.0), Step::BiasTest, lap(true)]
}
