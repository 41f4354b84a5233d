//! The timeline of a programme: motions in time, with the gyro's temperature.

use super::step::{BIAS_TEST_S, Programme, SPEED_RAMP, Step, TURN_RAMP};
use super::surroundings::{ROOM, Thermal};

/// Motion, SI; signed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Motion {
    /// Nothing.
    Rest,
    /// A rotation: angle and steady rate.
    Turn { angle: f64, rate: f64 },
    /// A straight line: distance.
    Straight { distance: f64 },
}

/// A stretch of time with one motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Phase {
    /// Start time, s.
    pub start: f64,
    /// Duration, s.
    pub duration: f64,
    pub motion: Motion,
    /// Heading at the start, rad.
    pub heading: f64,
    /// Room temperature, degC.
    pub ambient: f64,
    /// Temperature of the gyro at the start, degC.
    pub celsius: f64,
    /// Values of the fields that a person has set so far.
    pub levels: Vec<(String, f64)>,
    /// Number of bias tests and placements of the robot so far.
    pub run: usize,
    /// Index of the lap and its direction, during a lap.
    pub lap: Option<(usize, f64)>,
}

impl Phase {
    /// End time, s.
    pub(super) fn end(&self) -> f64 {
        self.start + self.duration
    }

    /// Mean rate of rotation, rad/s.
    pub(super) fn rate(&self) -> f64 {
        match self.motion {
            Motion::Turn { angle, .. } => angle / self.duration,
            _ => 0.0,
        }
    }

    /// Mean speed, m/s.
    pub(super) fn speed(&self) -> f64 {
        match self.motion {
            Motion::Straight { distance } => distance / self.duration,
            _ => 0.0,
        }
    }
}

/// Every phase of `programme`, in order.
pub(super) fn phases(programme: &Programme, thermal: Thermal) -> Vec<Phase> {
    let celsius = if programme.warm { thermal.steady(ROOM) } else { ROOM };
    let mut bench = Bench {
        thermal,
        now: 0.0,
        ambient: ROOM,
        celsius,
        heading: 0.0,
        levels: Vec::new(),
        run: 0,
        lap: None,
        laps: 0,
        phases: Vec::new(),
    };
    bench.all(&programme.steps);
    bench.phases
}

struct Bench {
    thermal: Thermal,
    now: f64,
    ambient: f64,
    celsius: f64,
    heading: f64,
    levels: Vec<(String, f64)>,
    run: usize,
    lap: Option<(usize, f64)>,
    laps: usize,
    phases: Vec<Phase>,
}

impl Bench {
    fn all(&mut self, steps: &[Step]) {
        for step in steps {
            self.step(step);
        }
    }

    fn step(&mut self, step: &Step) {
        match step {
            Step::Ambient(celsius) => self.ambient = *celsius,
            Step::Rest(duration) => self.pass(*duration, Motion::Rest),
            Step::BiasTest => {
                self.run += 1;
                self.pass(BIAS_TEST_S, Motion::Rest);
            }
            Step::TableTurn(angle, rate) | Step::Turn(angle, rate) => self.turn(*angle, *rate),
            Step::Ask(_) => {}
            Step::Level { field, value, .. } => {
                self.levels.retain(|(name, _)| name != field);
                self.levels.push((field.clone(), *value));
            }
            Step::Place(heading) => {
                self.run += 1;
                self.heading = heading.to_radians();
            }
            Step::Straight(distance, speed) => self.straight(*distance, *speed),
            Step::Lap { ccw, side, speed, rate } => {
                let direction = if *ccw { 1.0 } else { -1.0 };
                self.lap = Some((self.laps, direction));
                for _ in 0..4 {
                    self.straight(*side, *speed);
                    self.turn(direction * 90.0, *rate);
                }
                self.lap = None;
                self.laps += 1;
            }
            Step::Repeat { times, period_s, steps } => {
                for _ in 0..*times {
                    let next = period_s.map_or(self.now, |period| self.now + period);
                    self.all(steps);
                    if next > self.now {
                        self.pass(next - self.now, Motion::Rest);
                    }
                }
            }
            Step::Sweep { ambient, steps } => {
                for value in ambient {
                    self.ambient = *value;
                    self.all(steps);
                }
            }
        }
    }

    fn turn(&mut self, angle_deg: f64, rate_deg_per_s: f64) {
        let duration = trapezoid(angle_deg.abs(), rate_deg_per_s, TURN_RAMP);
        let angle = angle_deg.to_radians();
        let rate = rate_deg_per_s.to_radians().copysign(angle);
        self.pass(duration, Motion::Turn { angle, rate });
        self.heading += angle;
    }

    fn straight(&mut self, distance: f64, speed: f64) {
        self.pass(trapezoid(distance.abs(), speed, SPEED_RAMP), Motion::Straight { distance });
    }

    fn pass(&mut self, duration: f64, motion: Motion) {
        self.phases.push(Phase {
            start: self.now,
            duration,
            motion,
            heading: self.heading,
            ambient: self.ambient,
            celsius: self.celsius,
            levels: self.levels.clone(),
            run: self.run,
            lap: self.lap,
        });
        self.now += duration;
        self.celsius = self.thermal.after(self.celsius, self.ambient, duration);
    }
}

/// Duration of a move from rest to rest, with equal ramps.
fn trapezoid(way: f64, speed: f64, ramp: f64) -> f64 {
    if way >= speed * speed / ramp { way / speed + speed / ramp } else { 2.0 * (way / ramp).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::super::step::{Programme, RATE, SIDE, SPEED, Step, TABLE, laps, table_run};
    use super::super::surroundings::Thermal;
    use super::phases;
    use crate::dataset::{Dataset, Kind};

    fn last_end(steps: Vec<Step>) -> f64 {
        let nothing = Dataset::new("", Kind::Turns, Vec::new(), Vec::new());
        let programme =
            Programme { name: "", title: "", reason: "", devices: TABLE, warm: false, steps };
        phases(&programme, Thermal::of(&nothing)).last().map_or(0.0, super::Phase::end)
    }

    #[test]
    fn the_papers_runs_take_the_papers_times() {
        assert!((last_end(table_run()) - 48.0).abs() < 1e-9);
        // Two bias tests and two laps of 64 s.
        assert!((last_end(laps(SIDE, SPEED, RATE)) - 168.0).abs() < 1e-9);
        let hourly = Step::Repeat { times: 2, period_s: Some(3600.0), steps: table_run() };
        assert!((last_end(vec![hourly]) - 7200.0).abs() < 1e-9);
    }
}
