//! The value of a driver in each row.

use super::{Driver, Wrap};
use crate::problem::{Channel, Channels};
use crate::signal::{self, Bends};
use std::borrow::Cow;
use std::ops::Range;

/// Numbers that a driver and a form need besides the data, in SI: `time_constant`, `origin` ...
pub type Fixed = Vec<(String, f64)>;

/// The number of that name.
pub fn fixed(all: &Fixed, name: &str) -> Option<f64> {
    all.iter().find(|(key, _)| key == name).map(|(_, value)| *value)
}

/// The number of that name, or `otherwise` if it is not set.
pub fn fixed_or(all: &Fixed, name: &str, otherwise: f64) -> f64 {
    fixed(all, name).unwrap_or(otherwise)
}

/// The field of a driver.
pub enum Field<'a> {
    /// Time.
    Time,
    /// The rotation itself.
    Rotation,
    /// The sign of the rotation.
    Direction,
    /// A field of the data.
    Channel(&'a Channel),
}

/// Finds the field that `driver` names.
pub fn field<'a>(channels: &'a Channels, driver: &Driver) -> Option<Field<'a>> {
    let name = driver.field.as_str();
    if name == channels.time_name || name == "time" {
        Some(Field::Time)
    } else if let Some(channel) = channels.named(name) {
        Some(Field::Channel(channel))
    } else if !channels.rotation.is_empty()
        && (channels.direction_name.as_deref() == Some(name) || name == "direction")
    {
        Some(Field::Direction)
    } else if !channels.rotation.is_empty()
        && (name == channels.rotation_name
            || [crate::problem::ROTATION, "table_rate"].contains(&name))
    {
        Some(Field::Rotation)
    } else {
        None
    }
}

/// The driver's value in each row; harmonics and steps in time leave their argument to the form.
pub fn see<'a>(channels: &'a Channels, driver: &Driver, numbers: &Fixed) -> Option<Cow<'a, [f64]>> {
    let found = field(channels, driver)?;
    let plain = |found: &Field<'a>| -> Cow<'a, [f64]> {
        match found {
            Field::Time => Cow::Borrowed(&channels.time),
            Field::Rotation => Cow::Borrowed(&channels.rotation),
            Field::Direction => direction(channels),
            Field::Channel(channel) => Cow::Borrowed(&channel.values),
        }
    };
    Some(match driver.wrap {
        Wrap::Plain | Wrap::Harmonic(_) | Wrap::Step | Wrap::Periodic | Wrap::Trend => {
            plain(&found)
        }
        Wrap::Abs => plain(&found).iter().map(|value| value.abs()).collect(),
        Wrap::Sign => match found {
            Field::Rotation => direction(channels),
            other => plain(&other).iter().map(|value| sign(*value)).collect(),
        },
        Wrap::RateOf => match found {
            Field::Channel(channel) => Cow::Borrowed(&channel.smooth.slope),
            other => Cow::Owned(channels.smooth(&plain(&other)).slope),
        },
        Wrap::LagOf => {
            let level = level(&found, plain);
            let bends = match found {
                Field::Rotation => Cow::Borrowed(channels.bends_of_rotation()),
                _ => Cow::Owned(channels.bends(&level)),
            };
            Cow::Owned(lagged(channels, (&level, &bends), numbers)?)
        }
        Wrap::BranchOf => {
            let level = level(&found, plain);
            let half = fixed(numbers, "half_width")?;
            // The branch beside the middle one; or the branch itself, if all of the driver goes through the play.
            let own = 1.0 - fixed_or(numbers, "through", 0.0);
            let branch = channels.by_segment(&level, |_, values| signal::play(values, half));
            branch.iter().zip(level.iter()).map(|(branch, level)| branch - own * level).collect()
        }
    })
}

fn level<'a>(found: &Field<'a>, plain: impl Fn(&Field<'a>) -> Cow<'a, [f64]>) -> Cow<'a, [f64]> {
    match found {
        Field::Channel(channel) => Cow::Borrowed(&channel.smooth.level),
        other => plain(other),
    }
}

fn lagged(
    channels: &Channels,
    (level, bends): (&[f64], &[Bends]),
    numbers: &Fixed,
) -> Option<Vec<f64>> {
    let constant = fixed(numbers, "time_constant")?;
    let of = |rows: &Range<usize>| {
        let (times, level) = (&channels.time[rows.clone()], &level[rows.clone()]);
        signal::first_order(times, level, &bends[rows.clone()], constant)
    };
    Some(channels.segments.iter().flat_map(of).collect())
}

/// The square of a field through a lag: the heat that a current leaves.
pub fn heat(channels: &Channels, driver: &Driver, numbers: &Fixed) -> Option<Vec<f64>> {
    let Field::Channel(channel) = field(channels, driver)? else { return None };
    let squares: Vec<f64> = channel.smooth.level.iter().map(|level| level * level).collect();
    lagged(channels, (&squares, &channels.bends(&squares)), numbers)
}

/// Sign of the rotation; zero where its noise may have made it.
fn direction<'a>(channels: &Channels) -> Cow<'a, [f64]> {
    let of = |rate: &f64| if is_noise(*rate, channels) { 0.0 } else { sign(*rate) };
    channels.rotation.iter().map(of).collect()
}

/// Least half width of a play of the rotation. What evens a noisy reference out predicts readings better, whatever the
/// sensor does: the play must be wider than the noise on both sides.
pub fn narrowest_play(channels: &Channels) -> f64 {
    2.0 * NOISES_WIDE * channels.rotation_noise
}

/// Times the standard deviation of its noise that a reference of zero stays within.
pub const NOISES_WIDE: f64 = 3.0;

/// Whether the noise of the rotation may have made this value of it.
pub fn is_noise(rate: f64, channels: &Channels) -> bool {
    rate.abs() < NOISES_WIDE * channels.rotation_noise
}

/// Sign of a rotation; zero at rest.
fn sign(value: f64) -> f64 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        0.0
    }
}
