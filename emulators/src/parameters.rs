//! Named numbers of a device: declared once, read from a device file, set by name during a run.

pub(crate) mod schema;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The permitted values of a parameter. A NaN is never permitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Domain {
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Domain {
    /// Any finite number.
    pub const FINITE: Self = Self { min: f64::MIN, max: f64::MAX };
    /// Zero or more, and finite.
    pub const NOT_NEGATIVE: Self = Self { min: 0.0, max: f64::MAX };
    /// More than zero, and finite.
    pub const POSITIVE: Self = Self { min: f64::MIN_POSITIVE, max: f64::MAX };
    /// More than zero; `inf` stands for "no limit".
    pub const LIMIT: Self = Self { min: f64::MIN_POSITIVE, max: f64::INFINITY };

    /// Degrees Celsius of a room or an instrument, with a wide margin.
    pub const CELSIUS: Self = Self { min: -273.15, max: 1e3 };
    /// Differences of such temperatures.
    pub const KELVIN: Self = Self { min: -1e3, max: 1e3 };
    /// Degrees of latitude, north positive.
    pub const LATITUDE: Self = Self { min: -90.0, max: 90.0 };
    /// Error of a clock in parts per million: up to half of its rate.
    pub const CLOCK_ERROR: Self = Self { min: -5e5, max: 5e5 };
    /// Delay of an output in seconds: up to the capacity of the emulator's queue of outputs.
    pub const LATENCY: Self = Self { min: 0.0, max: 0.1 };

    /// True if `value` is permitted.
    pub const fn contains(self, value: f64) -> bool {
        value >= self.min && value <= self.max
    }
}

/// Description of a parameter.
#[derive(Debug, Clone, Copy)]
pub struct ParameterInfo {
    /// Name as in a device file; the last part is the unit.
    pub name: &'static str,
    /// Meaning, with source and usual size.
    pub doc: &'static str,
    /// Permitted values.
    pub domain: Domain,
    /// Default value in a device file: that of an ideal device.
    pub ideal: f64,
}

/// Reason why a parameter was not set.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ParameterError {
    /// The device has no parameter of this name.
    #[error("no parameter `{name}`{}", hint(.nearest))]
    Unknown {
        /// The requested name.
        name: String,
        /// The most similar existing name.
        nearest: Option<&'static str>,
    },
    /// The value is not permitted.
    #[error("`{name}` = {value} is not within {} to {}", .domain.min, .domain.max)]
    OutOfDomain {
        /// The parameter.
        name: String,
        /// The requested value.
        value: f64,
        /// The permitted values.
        domain: Domain,
    },
}

fn hint(nearest: &Option<&'static str>) -> String {
    nearest.map(|name| format!(", did you mean `{name}`?")).unwrap_or_default()
}

/// A set of named numbers.
pub trait Parameters {
    /// Every parameter that is a single number.
    const TABLE: &'static [ParameterInfo];

    /// A reference to the parameter `name`, and its permitted values.
    fn slot(&mut self, name: &str) -> Option<(&mut f64, Domain)>;

    /// Sets the parameter `name`, or leaves everything unchanged.
    fn set(&mut self, name: &str, value: f64) -> Result<(), ParameterError> {
        let Some((slot, domain)) = self.slot(name) else {
            return Err(ParameterError::Unknown {
                name: name.to_owned(),
                nearest: nearest(name, Self::TABLE),
            });
        };
        if !domain.contains(value) {
            return Err(ParameterError::OutOfDomain { name: name.to_owned(), value, domain });
        }
        *slot = value;
        Ok(())
    }

    /// Checks that every value is permitted, whatever its origin.
    fn check(&mut self) -> Result<(), ParameterError> {
        for info in Self::TABLE {
            if let Some((&mut value, domain)) = self.slot(info.name)
                && !domain.contains(value)
            {
                let name = info.name.to_owned();
                return Err(ParameterError::OutOfDomain { name, value, domain });
            }
        }
        Ok(())
    }
}

/// The name with the longest common start, the shortest of several, if it shares at least a word with `name`.
fn nearest(name: &str, table: &[ParameterInfo]) -> Option<&'static str> {
    let common = |other: &str| name.bytes().zip(other.bytes()).take_while(|(a, b)| a == b).count();
    let word = name.find('_').unwrap_or(name.len()).max(1);
    let names = table.iter().map(|info| info.name);
    let best = names.max_by_key(|other| (common(other), std::cmp::Reverse(other.len())))?;
    (common(best) >= word).then_some(best)
}

/// Declares a struct of named `f64` parameters: fields, documentation, domain and ideal value in one
/// place, so that a device file, a plan step and a listing cannot disagree.
macro_rules! parameters {
    (
        $(#[doc = $struct_doc:literal])*
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])*
                $field:ident: $domain:ident = $ideal:expr,
            )*
        }
        $(
            lists {
                $(#[doc = $list_doc:literal])*
                $list:ident: $item:ty = $list_ideal:expr,
            }
        )?
    ) => {
        $(#[doc = $struct_doc])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name {
            $($(#[doc = $doc])* pub $field: f64,)*
            $($(#[doc = $list_doc])* pub $list: Vec<$item>,)?
        }

        impl Default for $name {
            /// The ideal device.
            fn default() -> Self {
                Self { $($field: $ideal,)* $($list: $list_ideal,)? }
            }
        }

        impl schemars::JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            #[allow(unused_mut, unused_variables, reason = "used where there is a list")]
            fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                let known = <Self as $crate::parameters::Parameters>::TABLE;
                let mut schema = $crate::parameters::schema::table(known);
                schema.insert("description".to_owned(), concat!($($struct_doc, "\n"),*).trim().into());
                $(
                    let list = generator.subschema_for::<Vec<$item>>();
                    if let Some(known) = schema.get_mut("properties").and_then(|it| it.as_object_mut()) {
                        known.insert(stringify!($list).to_owned(), list.into());
                    }
                )?
                schema
            }
        }

        impl $crate::parameters::Parameters for $name {
            const TABLE: &'static [$crate::parameters::ParameterInfo] = &[
                $($crate::parameters::ParameterInfo {
                    name: stringify!($field),
                    doc: concat!($($doc),*),
                    domain: $crate::parameters::Domain::$domain,
                    ideal: $ideal,
                },)*
            ];

            fn slot(&mut self, name: &str) -> Option<(&mut f64, $crate::parameters::Domain)> {
                $(
                    if let Some(rest) = name.strip_prefix(concat!(stringify!($list), ".")) {
                        let (index, field) = rest.split_once('.')?;
                        return self.$list.get_mut(index.parse::<usize>().ok()?)?.slot(field);
                    }
                )?
                match name {
                    $(stringify!($field) => {
                        Some((&mut self.$field, $crate::parameters::Domain::$domain))
                    })*
                    _ => None,
                }
            }

            $(
                fn check(&mut self) -> Result<(), $crate::parameters::ParameterError> {
                    self.$list.iter_mut().try_for_each(|item| item.check())?;
                    for info in Self::TABLE {
                        if let Some((&mut value, _)) = self.slot(info.name) {
                            self.set(info.name, value)?;
                        }
                    }
                    Ok(())
                }
            )?
        }
    };
}
pub(crate) use parameters;

#[cfg(test)]
mod tests {
    use super::{ParameterError, Parameters};

    parameters! {
        /// An item.
        pub struct Item {
            /// Anything.
            toe_deg: FINITE = 0.0,
        }
    }

    parameters! {
        /// For the tests.
        pub struct Example {
            /// How warm it is.
            ambient_celsius: FINITE = 20.0,
            /// How fast it goes.
            /// At most.
            range_deg_per_s: LIMIT = f64::INFINITY,
        }
        lists {
            /// Several.
            wheels: Item = vec![Item::default(), Item::default()],
        }
    }

    #[test]
    fn a_parameter_is_set_by_name() {
        let mut example = Example::default();
        example.set("ambient_celsius", 25.0).unwrap();
        example.set("range_deg_per_s", f64::INFINITY).unwrap();
        example.set("wheels.1.toe_deg", 0.1).unwrap();
        assert_eq!((example.ambient_celsius, example.wheels[1].toe_deg), (25.0, 0.1));
        assert_eq!(Example::TABLE[1].doc, " How fast it goes. At most.");
    }

    #[test]
    fn a_wrong_name_or_value_is_refused_and_changes_nothing() {
        let mut example = Example::default();
        for name in ["", "ambient", "wheels", "wheels.2.toe_deg", "wheels.x.toe_deg", "wheels.0."] {
            assert!(
                matches!(example.set(name, 1.0), Err(ParameterError::Unknown { .. })),
                "{name}"
            );
        }
        for value in [0.0, -1.0, f64::NAN] {
            assert!(example.set("range_deg_per_s", value).is_err());
        }
        assert!(example.set("wheels.0.toe_deg", f64::INFINITY).is_err());
        assert_eq!(example, Example::default());
        assert_eq!(
            example.set("ambient_kelvin", 300.0).unwrap_err().to_string(),
            "no parameter `ambient_kelvin`, did you mean `ambient_celsius`?"
        );
    }

    #[test]
    fn a_file_is_checked_whole() {
        let read = |text| toml::from_str::<Example>(text);
        assert!(read("ambient_celsius = 21").unwrap().check().is_ok());
        assert!(read("range_deg_per_s = nan").unwrap().check().is_err());
        assert!(read("wheels = [{ toe_deg = inf }]").unwrap().check().is_err());
        assert!(read("ambient = 21").is_err());
    }
}
