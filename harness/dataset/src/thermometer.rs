//! Scales of temperatures: whatever a package states, a data set is in degrees Celsius.

use identification::dataset::Role;
use std::ops::RangeInclusive;

/// The scale of a temperature, as a package states it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scale {
    Celsius,
    Kelvin,
    Fahrenheit,
}

/// Readings (of a device beside what turns or drives) that can only be in kelvin.
const KELVIN: RangeInclusive<f64> = 200.0..=400.0;
/// The same readings in degrees Celsius: in kelvin, there is no such place.
const CELSIUS: RangeInclusive<f64> = -80.0..=130.0;

impl Scale {
    /// Those that are no unit of a data set.
    pub const CONVERTED: [Self; 2] = [Self::Kelvin, Self::Fahrenheit];

    /// The scale with that text, among [`Self::CONVERTED`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::CONVERTED.into_iter().find(|scale| scale.text() == text)
    }

    pub const fn text(self) -> &'static str {
        match self {
            Self::Celsius => "Cel",
            Self::Kelvin => "K",
            Self::Fahrenheit => "degF",
        }
    }

    fn celsius(self, value: f64) -> f64 {
        match self {
            Self::Celsius => value,
            Self::Kelvin => value - 273.15,
            Self::Fahrenheit => (value - 32.0) / 1.8,
        }
    }

    /// The scale that `values` are on, if they contradict this one.
    fn contradicted(self, values: &[f64]) -> Option<Self> {
        let mut there = values.iter().filter(|value| !value.is_nan()).peekable();
        there.peek()?;
        let all_in = |range: &RangeInclusive<f64>| there.clone().all(|value| range.contains(value));
        match self {
            Self::Celsius if all_in(&KELVIN) => Some(Self::Kelvin),
            Self::Kelvin if all_in(&CELSIUS) => Some(Self::Celsius),
            _ => None,
        }
    }

    /// Converts the values of a field to degrees Celsius and says so.
    pub fn convert(self, name: &str, role: Role, values: &mut [f64]) -> Option<String> {
        let is_surroundings = role == Role::Temperature;
        let other = self.contradicted(values).filter(|_| is_surroundings);
        let is = other.unwrap_or(self);
        values.iter_mut().for_each(|value| *value = is.celsius(*value));
        let (stated, is) = (self.text(), is.text());
        match other {
            Some(Self::Celsius) => {
                Some(format!("{name} is stated in {stated}, but its values can only be in {is}"))
            }
            Some(_) => Some(format!(
                "{name} is stated in {stated}, but its values can only be in {is}: converted to Cel"
            )),
            None => {
                (self != Self::Celsius).then(|| format!("{name} is converted from {is} to Cel"))
            }
        }
    }
}
