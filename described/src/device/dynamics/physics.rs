//! A functional mock-up unit that runs with the device.
//!
//! It advances in steps of its own from power-on, whenever messages arrive: its inputs are those at the beginning of a
//! step, and its outputs are states that change at the end.

use super::Dynamics;
use super::laws::{Moment, finite};
use crate::description::{Model, Physics};
use crate::device::{Device, NEVER};
use crate::fmu::FmuInstance;
use wire::time::Timestamp;

#[derive(Debug)]
pub(super) struct Coupled {
    instance: Option<Box<dyn FmuInstance>>,
    /// Values of the inputs for this step.
    inputs: Vec<f64>,
    /// Inputs as the unit has them.
    given: Vec<f64>,
    /// Number of steps made.
    steps: u64,
    /// The end of this step.
    pub(super) due: Timestamp,
    /// When and why it ended, until somebody asks.
    failure: Option<(Timestamp, String)>,
}

/// A unit may have state that cannot be copied. A copy has no unit, and fails at its first step.
impl Clone for Coupled {
    fn clone(&self) -> Self {
        let (inputs, given) = (self.inputs.clone(), self.given.clone());
        Self { instance: None, inputs, given, failure: self.failure.clone(), ..*self }
    }
}

impl Coupled {
    pub(super) fn of(model: &Model) -> Option<Box<Self>> {
        let inputs = model.physics.as_ref()?.inputs.len();
        Some(Box::new(Self {
            instance: None,
            inputs: vec![0.0; inputs],
            given: vec![f64::NAN; inputs],
            steps: 0,
            due: NEVER,
            failure: None,
        }))
    }
}

impl Device {
    /// True if a copy goes on like this one: a functional mock-up unit cannot be copied.
    pub const fn can_be_copied(&self) -> bool {
        self.dynamics.physics.is_none()
    }

    /// Why its functional mock-up unit failed, once. The device is off from then on.
    pub fn failure(&mut self, now: Timestamp) -> Option<String> {
        let failure = self.dynamics.physics_failure()?;
        self.power(now, false);
        Some(failure)
    }
}

impl Dynamics {
    /// The end of the unit's step.
    #[inline]
    pub(super) fn physics_due(&self) -> Timestamp {
        self.physics.as_ref().map_or(NEVER, |coupled| coupled.due)
    }

    /// When the unit failed, until somebody has asked why.
    #[inline]
    pub(in crate::device) fn physics_failed_at(&self) -> Option<Timestamp> {
        self.physics.as_ref()?.failure.as_ref().map(|(at, _)| *at)
    }

    /// Why the unit failed, once.
    pub(super) fn physics_failure(&mut self) -> Option<String> {
        self.physics.as_mut()?.failure.take().map(|(_, why)| why)
    }

    pub(in crate::device) fn stop_physics(&mut self) {
        if let Some(coupled) = &mut self.physics {
            coupled.instance = None;
            coupled.due = NEVER;
        }
    }

    /// Power-on: a new instance, at time zero.
    pub(super) fn start_physics(&mut self, model: &Model) {
        self.with_physics(model, |dynamics, physics, coupled| {
            // An instance that is still there is ended before the next begins.
            coupled.instance = None;
            let (values, not_finite) = (&dynamics.values, &mut dynamics.not_finite);
            let parameters = physics.parameters.iter();
            let parameters = parameters
                .map(|(place, value)| (*place, finite(value.value(values), 0.0, not_finite)));
            let mut instance = physics.unit.start(&parameters.collect::<Vec<_>>())?;
            dynamics.read(physics, &mut *instance)?;
            dynamics.laws.follow(&mut dynamics.values, Moment::EndOfStep, &mut 0);
            coupled.given.fill(f64::NAN);
            coupled.inputs.fill(0.0);
            coupled.look(physics, dynamics);
            coupled.give(physics, &mut *instance)?;
            instance.begin()?;
            dynamics.read(physics, &mut *instance)?;
            (coupled.steps, coupled.due) = (0, dynamics.start + physics.step);
            coupled.instance = Some(instance);
            Ok(())
        });
        self.settle();
        self.look_at_inputs(model);
    }

    /// Makes the unit's step that ends now.
    pub(super) fn step_physics(&mut self, model: &Model) {
        self.with_physics(model, |dynamics, physics, coupled| {
            let mut instance =
                coupled.instance.take().ok_or("a copy of a device cannot go on with an FMU")?;
            coupled.give(physics, &mut *instance)?;
            let length = physics.step.as_secs_f64();
            instance.step(coupled.steps as f64 * length, length)?;
            dynamics.read(physics, &mut *instance)?;
            coupled.steps += 1;
            coupled.due += physics.step;
            coupled.instance = Some(instance);
            Ok(())
        });
    }

    /// Takes the inputs for a step that begins now, also if they change at this instant once more.
    pub(super) fn look_at_inputs(&mut self, model: &Model) {
        let (Some(coupled), Some(physics)) = (&self.physics, &model.physics) else { return };
        if coupled.due != self.now + physics.step {
            return;
        }
        self.with_physics(model, |dynamics, physics, coupled| {
            coupled.look(physics, dynamics);
            Ok(())
        });
    }

    /// The device was not woken for so long that steps were left out.
    pub(super) fn skip_physics(&mut self, model: &Model) {
        self.with_physics(model, |_, _, _| Err("it was left alone for too many steps".to_owned()));
    }

    fn with_physics(
        &mut self,
        model: &Model,
        act: impl FnOnce(&mut Self, &Physics, &mut Coupled) -> Result<(), String>,
    ) {
        let (Some(physics), Some(mut coupled)) = (&model.physics, self.physics.take()) else {
            return;
        };
        if let Err(why) = act(self, physics, &mut coupled) {
            (coupled.instance, coupled.due) = (None, NEVER);
            let at = self.seconds(self.now);
            coupled.failure = Some((self.now, format!("`{}` at {at} s: {why}", physics.file)));
        }
        self.physics = Some(coupled);
    }

    fn read(&mut self, physics: &Physics, instance: &mut dyn FmuInstance) -> Result<(), String> {
        for (place, slot) in &physics.outputs {
            let value = instance.get(*place)?;
            if !value.is_finite() {
                let name = &physics.unit.variables()[*place].name;
                return Err(format!("its output `{name}` is {value}"));
            }
            self.values[*slot] = value;
        }
        Ok(())
    }
}

impl Coupled {
    fn look(&mut self, physics: &Physics, dynamics: &mut Dynamics) {
        for ((_, input), value) in physics.inputs.iter().zip(&mut self.inputs) {
            *value = finite(input.value(&dynamics.values), *value, &mut dynamics.not_finite);
        }
    }

    fn give(&mut self, physics: &Physics, instance: &mut dyn FmuInstance) -> Result<(), String> {
        for (((place, _), value), given) in
            physics.inputs.iter().zip(&self.inputs).zip(&mut self.given)
        {
            if value.to_bits() != given.to_bits() {
                instance.set(*place, *value)?;
                *given = *value;
            }
        }
        Ok(())
    }
}
