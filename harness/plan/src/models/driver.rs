//! The input of a term: a field of a data set, as a controller knows it.

use super::numbers::Numbers;
use controller::correction::Driver;
use identification::dataset::Role;
use identification::model::{self, Model, Wrap};
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::{Error, StrDeserializer};

/// The controller's equivalent of a driver.
pub(super) fn of(
    model: &Model,
    driver: &model::Driver,
    numbers: &Numbers<'_>,
) -> Result<Driver, String> {
    let role = role(model, &driver.field)
        .ok_or_else(|| format!("the model does not say what `{}` is", driver.field))?;
    let no_view = || Err(format!("a controller has no view of `{driver}`"));
    Ok(match (role, driver.wrap) {
        (Role::Temperature, Wrap::Plain) => Driver::Temperature,
        (Role::Temperature, Wrap::RateOf) => Driver::TemperatureRate,
        (Role::Temperature, Wrap::LagOf) => {
            Driver::TemperatureLag { time_constant_s: numbers.get("time_constant")? }
        }
        (Role::Temperature, Wrap::BranchOf) => {
            Driver::TemperatureBranch { half_width_kelvin: numbers.get("half_width")? }
        }
        (Role::TableRate | Role::ReferenceRate | Role::GyroRate, wrap) => match wrap {
            Wrap::Plain => Driver::Rate,
            Wrap::Abs => Driver::AbsRate,
            Wrap::Sign => Driver::Direction,
            _ => return no_view(),
        },
        (Role::Bias, Wrap::Plain) => Driver::TestedBias,
        (Role::Direction, Wrap::Plain | Wrap::Sign) => Driver::Direction,
        (Role::Heading | Role::ReferenceHeading, Wrap::Plain | Wrap::Harmonic(1..=2)) => {
            Driver::Heading
        }
        (Role::Time, Wrap::Plain | Wrap::Step | Wrap::Periodic | Wrap::Trend) => Driver::Time,
        _ => return no_view(),
    })
}

/// The role of a field, from the model or from the field's own name.
fn role(model: &Model, field: &str) -> Option<Role> {
    let by_name = || {
        let name: StrDeserializer<'_, Error> = field.into_deserializer();
        Role::deserialize(name).ok()
    };
    model.fields.get(field).copied().or_else(by_name)
}
