//! Assumptions of a planned experiment about the room and the device.

use crate::dataset::{Dataset, Dimension, Role};
use crate::robust;

/// Temperature of a heated room, degC (assumption).
pub(super) const ROOM: f64 = 22.0;
/// Time constant of a gyro's temperature, s (this class: 30 to 40 min).
const THERMAL_TIME_CONSTANT_S: f64 = 2100.0;
/// Self-heating of a gyro above room temperature, K: bounds on the value from the data (assumption), and the value used
/// without data.
const SELF_HEATING: (f64, f64) = (5.0, 25.0);
const SELF_HEATING_USUAL: f64 = 15.0;

/// A field that a person moves.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Level {
    /// Name of the field.
    pub field: String,
    /// Its unit as the contract writes it.
    pub unit: &'static str,
    /// Lowest value in the data, in that unit.
    pub low: f64,
    /// Highest value in the data, in that unit.
    pub high: f64,
}

/// First-order model of the gyro's temperature: it tends to room temperature plus self-heating.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Thermal {
    self_heating: f64,
}

impl Thermal {
    /// The model for the gyro of `dataset`: its highest temperature counts as steady.
    pub(super) fn of(dataset: &Dataset) -> Self {
        let highest = dataset.column(Role::Temperature).and_then(|column| {
            column.si().filter(|value| value.is_finite()).max_by(f64::total_cmp)
        });
        let self_heating = highest.map_or(SELF_HEATING_USUAL, |highest| {
            (highest - ROOM).clamp(SELF_HEATING.0, SELF_HEATING.1)
        });
        Self { self_heating }
    }

    /// Steady temperature of the gyro in a room of `ambient`.
    pub(super) fn steady(self, ambient: f64) -> f64 {
        ambient + self.self_heating
    }

    /// Temperature of a gyro that started at `celsius`, after `after_s` in a room of `ambient`.
    pub(super) fn after(self, celsius: f64, ambient: f64, after_s: f64) -> f64 {
        let steady = self.steady(ambient);
        steady + (celsius - steady) * (-after_s / THERMAL_TIME_CONSTANT_S).exp()
    }
}

/// Fields of `dataset` among `names` that only a person can change: voltages, currents, fields.
pub(super) fn levels(dataset: &Dataset, names: &[&str]) -> Vec<Level> {
    let by_hand = [Dimension::Voltage, Dimension::Current, Dimension::MagneticField];
    dataset
        .columns
        .iter()
        .filter(|column| column.role == Role::Auxiliary && names.contains(&column.name.as_str()))
        .filter(|column| by_hand.contains(&column.unit.dimension()))
        .map(|column| {
            let finite = column.values.iter().copied().filter(|value| value.is_finite());
            let (low, high) = robust::ends(finite);
            Level { field: column.name.clone(), unit: column.unit.text(), low, high }
        })
        .filter(|level| level.high > level.low)
        .collect()
}
