//! The variables of a device over time.

mod laws;
mod machines;
mod physics;

use crate::description::Model;
use crate::expression::TIME;
use crate::uds::Monitor;
pub(super) use laws::finite;
use laws::{Laws, Moment};
use machines::Machines;
use physics::Coupled;
use wire::time::{Span, Timestamp};

/// Maximum number of steps integrated in one call; time beyond is skipped. Assumption: a world wakes a device more
/// often than once a day. Its tests, which are not optimised, need not wait for so many.
const STEPS_MAX: u32 = if cfg!(test) { 100_000 } else { 10_000_000 };

/// The stages of the classic Runge-Kutta method: the step share with the preceding slope, and the weight.
const STAGES: [(f64, f64); 4] = [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)];
const WEIGHTS: f64 = 6.0;

#[derive(Debug, Clone)]
pub(super) struct Dynamics {
    /// Whoever changes them calls [`has_changed`](Self::has_changed).
    pub(super) values: Vec<f64>,
    laws: Laws,
    machines: Machines,
    trial: Vec<f64>,
    /// One per state with a rate, for the stage and in total.
    slope: Vec<f64>,
    sum: Vec<f64>,
    start: Timestamp,
    now: Timestamp,
    /// Increases with every change of the variables.
    generation: u64,
    pub(super) not_finite: u64,
    /// Tests of the trouble codes, and whether they run.
    pub(super) monitors: Vec<Monitor>,
    pub(super) monitoring: bool,
    /// A functional mock-up unit.
    physics: Option<Box<Coupled>>,
}

impl Dynamics {
    /// All variables at zero, not started.
    pub(super) fn new(model: &Model) -> Self {
        let slots = model.variables.count();
        let laws = Laws::of(model);
        let rates = laws.rates().len();
        Self {
            values: vec![0.0; slots],
            laws,
            machines: Machines::default(),
            trial: vec![0.0; slots],
            slope: vec![0.0; rates],
            sum: vec![0.0; rates],
            start: Timestamp::ZERO,
            now: Timestamp::ZERO,
            generation: 0,
            not_finite: 0,
            monitors: model.uds.iter().flat_map(|uds| &uds.dtcs).map(|_| Monitor::new()).collect(),
            monitoring: true,
            physics: Coupled::of(model),
        }
    }

    /// Power-on: time is zero, states have their start values.
    pub(super) fn start(&mut self, model: &Model, now: Timestamp) {
        (self.start, self.now) = (now, now);
        self.values[TIME] = 0.0;
        self.start_machines(model, now);
        for (index, state) in model.states.iter().enumerate() {
            let start = state.start.value(&self.values);
            let start = finite(start, 0.0, &mut self.not_finite);
            self.values[model.variables.state(index)] = start;
            self.values[model.variables.last_state(index)] = start;
        }
        self.settle();
        self.start_physics(model);
    }

    pub(super) fn get(&self, slot: usize) -> f64 {
        self.values.get(slot).copied().unwrap_or(f64::NAN)
    }

    /// Increases with every change of the variables.
    #[inline]
    pub(super) const fn generation(&self) -> u64 {
        self.generation
    }

    /// Records that variables have changed.
    pub(super) const fn has_changed(&mut self) {
        self.generation += 1;
    }

    pub(super) fn set(&mut self, slot: usize, value: f64) {
        self.has_changed();
        if let Some(place) = self.values.get_mut(slot) {
            *place = value;
        }
    }

    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Number of non-finite values, for which the previous value was kept.
    pub(super) const fn not_finite(&self) -> u64 {
        self.not_finite
    }

    /// Integrates over the whole steps that end by `now`, and up to the times at which a machine changes state by
    /// itself.
    pub(super) fn advance(&mut self, model: &Model, now: Timestamp) {
        let is_still = model.states.is_empty() && model.machines.is_empty();
        if is_still && self.monitors.is_empty() || now <= self.now {
            return;
        }
        for _ in 0..STEPS_MAX {
            let step = model.step.as_nanos();
            let count = self.now.since(self.start).as_nanos() / step + 1;
            let whole = self.start + Span::from_nanos(step.saturating_mul(count));
            let next = whole.min(self.deadline()).min(self.physics_due());
            if next > now {
                return;
            }
            self.step(model, next);
        }
        self.now = now;
        // Deadlines passed meanwhile are void.
        self.plan(model, now);
        self.skip_physics(model);
    }

    /// Integrates up to `now`, with a shorter last step.
    #[inline]
    pub(super) fn reach(&mut self, model: &Model, now: Timestamp) {
        // Usually another message was sent at the same time.
        if now > self.now {
            self.go_to(model, now);
        }
    }

    #[inline(never)]
    fn go_to(&mut self, model: &Model, now: Timestamp) {
        self.advance(model, now);
        if now > self.now {
            self.step(model, now);
        }
    }

    pub(super) fn seconds(&self, at: Timestamp) -> f64 {
        at.since(self.start).as_secs_f64()
    }

    fn step(&mut self, model: &Model, end: Timestamp) {
        let length = end.since(self.now).as_secs_f64();
        if !self.laws.rates().is_empty() {
            self.integrate(length);
        }
        self.values[TIME] = self.seconds(end);
        self.now = end;
        if self.physics_due() == end {
            self.step_physics(model);
        }
        self.settle();
        self.go_on(model, end, None);
    }

    fn integrate(&mut self, length: f64) {
        let from = self.seconds(self.now);
        let Self { values, laws, trial, slope, sum, not_finite, .. } = self;
        sum.fill(0.0);
        slope.fill(0.0);
        trial.copy_from_slice(values);
        for (stage, (reach, weight)) in STAGES.into_iter().enumerate() {
            if stage > 0 {
                laws.restore(trial, values);
            }
            trial[TIME] = from + reach * length;
            for ((slot, _), slope) in laws.rates().iter().zip(&*slope) {
                trial[*slot] = values[*slot] + reach * length * slope;
            }
            laws.follow(trial, Moment::WithinStep, &mut 0);
            for (index, (_, rate)) in laws.rates().iter().enumerate() {
                slope[index] = rate.value(trial);
                sum[index] += weight * slope[index];
            }
        }
        for ((slot, _), sum) in laws.rates().iter().zip(&*sum) {
            let next = values[*slot] + length * sum / WEIGHTS;
            values[*slot] = finite(next, values[*slot], not_finite);
        }
    }

    /// Updates the states with a value after an external change. From now on the current states count as those of the
    /// previous step.
    pub(super) fn settle(&mut self) {
        self.laws.follow(&mut self.values, Moment::EndOfStep, &mut self.not_finite);
        self.laws.remember(&mut self.values);
        self.has_changed();
    }
}
