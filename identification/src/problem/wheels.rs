//! Motion by the wheels: distance and turn of each row.

use super::channels::Channels;
use super::path::{chord, slopes};
use super::segments::runs;
use super::wrap;
use crate::dataset::{Column, Constant, Dataset, Dimension, Drive, Role, Unit};
use crate::error::IdentifyError;
use crate::robust;
use crate::signal::{interpolate, running_total};

/// Nominal motion in each row.
pub(crate) struct Motion {
    /// Distance, m.
    pub distance: Vec<f64>,
    /// Turn, rad.
    pub turn: Vec<f64>,
    /// For a tricycle: name of the steering angle, and that angle between each row and the previous one, rad.
    pub steer: Option<(String, Vec<f64>)>,
}

impl Motion {
    /// Makes it come later by `delay`, s, as its reference does.
    pub fn delay(&mut self, delay: f64, channels: &Channels) {
        let later = |per_row: &[f64]| -> Vec<f64> {
            let total = running_total(per_row);
            let mut found = vec![0.0; per_row.len()];
            for run in runs(&channels.run) {
                let (time, total) = (&channels.time[run.clone()], &total[run.clone()]);
                let at = |time_of: f64| interpolate(time, total, time_of - delay);
                for row in run.start + 1..run.end {
                    found[row] = at(channels.time[row]) - at(channels.time[row - 1]);
                }
            }
            found
        };
        (self.distance, self.turn) = (later(&self.distance), later(&self.turn));
        if let Some((_, angle)) = &mut self.steer {
            *angle = channels.by_segment(angle, |times, values| {
                times.iter().map(|time| interpolate(times, values, time - delay)).collect()
            });
        }
    }
}

/// Names of the constant that says how far apart the wheels stand.
pub(crate) const TRACK: &[&str] =
    &["wheelbase", "track", "track_width", "wheel_base", "wheel_track"];

/// Half the distance of the wheels, m, of a robot with one on each side.
pub(super) fn half_track(dataset: &Dataset) -> Option<f64> {
    dataset.column(Role::WheelLeft).and(dataset.column(Role::WheelRight))?;
    length(dataset, TRACK).map(|track| track / 2.0)
}

/// Ratio of range to largest step from which a reading counts as cumulative.
const CUMULATIVE: f64 = 20.0;

pub(crate) fn motion(dataset: &Dataset, channels: &Channels) -> Result<Motion, IdentifyError> {
    let wheels = (dataset.column(Role::WheelLeft), dataset.column(Role::WheelRight));
    if let (Some(left), Some(right)) = wheels {
        let track = length(dataset, TRACK).ok_or_else(|| no_constant(dataset, "wheelbase"))?;
        let left = travelled(dataset, left, "left", channels)?;
        let right = travelled(dataset, right, "right", channels)?;
        let distance = left.iter().zip(&right).map(|(l, r)| (l + r) / 2.0).collect();
        let turn = left.iter().zip(&right).map(|(l, r)| (r - l) / track).collect();
        return Ok(Motion { distance, turn, steer: None });
    }
    let distance = dataset.required(Role::DriveDistance, "wheels")?;
    let steer = dataset.required(Role::SteerAngle, "steer angle")?;
    let distance = match distance.unit.dimension() {
        Dimension::Speed => by_time(dataset, distance, channels),
        Dimension::Length => increments(distance, channels, false),
        _ => {
            let factor = length(dataset, &["metres_per_count", "drive_metres_per_count"])
                .ok_or_else(|| no_constant(dataset, "metres_per_count"))?;
            distance.values.iter().map(|counts| finite(*counts) * factor).collect()
        }
    };
    if dataset.drive == Some(Drive::Tricycle) {
        return tricycle(dataset, &distance, steer, channels);
    }
    let turn = match steer.unit.dimension() {
        Dimension::AngularRate => by_time(dataset, steer, channels),
        Dimension::Count => {
            let per_turn =
                number(dataset, &["steer_counts_per_revolution", "counts_per_revolution"])
                    .ok_or_else(|| no_constant(dataset, "steer_counts_per_revolution"))?;
            let factor = std::f64::consts::TAU / per_turn;
            steer.values.iter().map(|counts| finite(*counts) * factor).collect()
        }
        _ => increments(steer, channels, true),
    };
    Ok(Motion { distance, turn, steer: None })
}

/// One steered and driven wheel, `wheelbase` ahead of an axle: the axle advances by the cosine of the steering angle,
/// and the robot turns by its sine over the wheelbase.
fn tricycle(
    dataset: &Dataset,
    distance: &[f64],
    steer: &Column,
    channels: &Channels,
) -> Result<Motion, IdentifyError> {
    let base = length(dataset, &["wheelbase"]).ok_or_else(|| no_constant(dataset, "wheelbase"))?;
    let scale = number(dataset, &["steer_scale"]).unwrap_or(1.0);
    if steer.unit.dimension() != Dimension::Angle {
        let (name, unit) = (&steer.name, steer.unit.text());
        let what =
            format!("`{name}` is in {unit}: the steering angle of a tricycle must be an angle");
        return Err(IdentifyError(what));
    }
    let angles: Vec<f64> = steer.si().map(|angle| scale * finite(angle)).collect();
    // The steering angle of a row is the mean over it.
    let mut middle: Vec<f64> = (0..angles.len())
        .map(|row| match row {
            0 => angles[0],
            _ if channels.run[row] == channels.run[row - 1] => {
                (angles[row] + angles[row - 1]) / 2.0
            }
            _ => angles[row],
        })
        .collect();
    // It is turned by a motor: between rows it follows a cubic, as its slopes at both ends say (Hermite).
    for range in &channels.segments {
        let slopes = slopes(&angles[range.clone()]);
        for row in range.start + 1..range.end {
            let at = row - range.start;
            middle[row] -= (slopes[at] - slopes[at - 1]) / 12.0;
        }
    }
    // The mean of a sine or a cosine over a row in which the angle changes evenly is less than that in its middle.
    let half = |row: usize| match row {
        0 => 0.0,
        _ if channels.run[row] == channels.run[row - 1] => (angles[row] - angles[row - 1]) / 2.0,
        _ => 0.0,
    };
    let even: Vec<f64> = (0..angles.len()).map(|row| chord(2.0 * half(row))).collect();
    let mean = |part: fn(f64) -> f64| -> Vec<f64> {
        (0..angles.len()).map(|row| distance[row] * even[row] * part(middle[row])).collect()
    };
    Ok(Motion {
        turn: mean(f64::sin).into_iter().map(|turn| turn / base).collect(),
        distance: mean(f64::cos),
        steer: Some((steer.name.clone(), middle)),
    })
}

fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

fn constant(dataset: &Dataset, names: &[&str]) -> Option<Constant> {
    names.iter().find_map(|name| dataset.constants.get(*name).copied())
}

fn no_constant(dataset: &Dataset, name: &str) -> IdentifyError {
    let stated: Vec<String> = dataset.constants.keys().map(|name| format!("`{name}`")).collect();
    let has = if stated.is_empty() { "none".to_owned() } else { stated.join(", ") };
    IdentifyError::missing(&format!("constant `{name}` in the package; it has {has}"))
}

pub(super) fn length(dataset: &Dataset, names: &[&str]) -> Option<f64> {
    constant(dataset, names).map(|constant| constant.si())
}

fn number(dataset: &Dataset, names: &[&str]) -> Option<f64> {
    constant(dataset, names).map(|constant| constant.value)
}

/// Metres that a wheel travelled in each row.
fn travelled(
    dataset: &Dataset,
    wheel: &Column,
    side: &str,
    channels: &Channels,
) -> Result<Vec<f64>, IdentifyError> {
    let radius = || {
        length(dataset, &[&format!("wheel_diameter_{side}"), "wheel_diameter"])
            .map(|diameter| diameter / 2.0)
            .or_else(|| length(dataset, &[&format!("wheel_radius_{side}"), "wheel_radius"]))
            .ok_or_else(|| no_constant(dataset, &format!("wheel_diameter_{side}")))
    };
    Ok(match wheel.unit.dimension() {
        Dimension::Count => {
            let ticks = [
                format!("encoder_ticks_per_revolution_{side}"),
                "encoder_ticks_per_revolution".to_owned(),
                "ticks_per_revolution".to_owned(),
            ];
            let names: Vec<&str> = ticks.iter().map(String::as_str).collect();
            let per_turn = number(dataset, &names)
                .ok_or_else(|| no_constant(dataset, "encoder_ticks_per_revolution"))?;
            let factor = std::f64::consts::TAU * radius()? / per_turn;
            wheel.values.iter().map(|count| finite(*count) * factor).collect()
        }
        Dimension::Angle => {
            let radius = radius()?;
            increments(wheel, channels, false).into_iter().map(|angle| angle * radius).collect()
        }
        Dimension::AngularRate => {
            let radius = radius()?;
            by_time(dataset, wheel, channels).into_iter().map(|angle| angle * radius).collect()
        }
        Dimension::Length => increments(wheel, channels, false),
        _ => by_time(dataset, wheel, channels),
    })
}

/// The way since the previous row, between which a speed changes evenly, if it is not the mean.
fn by_time(dataset: &Dataset, column: &Column, channels: &Channels) -> Vec<f64> {
    let is_mean = dataset.constants.get(Constant::MEAN_SPEED).is_some_and(|one| one.value != 0.0);
    let values: Vec<f64> = column.si().map(finite).collect();
    let mut found = vec![0.0; values.len()];
    for row in 1..values.len() {
        if channels.run[row] == channels.run[row - 1] {
            let dt = channels.time[row] - channels.time[row - 1];
            let before = if is_mean { values[row] } else { values[row - 1] };
            found[row] = dt * (values[row] + before) / 2.0;
        }
    }
    found
}

/// Steps of a cumulative reading, or the reading itself if it consists of steps.
fn increments(column: &Column, channels: &Channels, wraps: bool) -> Vec<f64> {
    let values: Vec<f64> = column.si().collect();
    let mut steps = vec![0.0; values.len()];
    let mut last = f64::NAN;
    for row in 0..values.len() {
        if row > 0 && channels.run[row] != channels.run[row - 1] {
            last = f64::NAN;
        }
        if values[row].is_finite() {
            if last.is_finite() {
                let step = values[row] - last;
                steps[row] = if wraps && column.unit != Unit::One { wrap(step) } else { step };
            }
            last = values[row];
        }
    }
    // A gap holds the way of many rows.
    let per_row = |row: usize| match row
        .checked_sub(1)
        .map(|before| channels.time[row] - channels.time[before])
    {
        Some(dt) if dt > channels.interval() => channels.interval() / dt,
        _ => 1.0,
    };
    let sizes = steps.iter().enumerate().map(|(row, step)| step.abs() * per_row(row));
    let largest_step = sizes.fold(0.0, f64::max);
    let (low, high) = robust::ends(values.iter().copied().filter(|value| value.is_finite()));
    if high - low > CUMULATIVE * largest_step || (wraps && high - low > 1.0 && largest_step < 1.0) {
        steps
    } else if largest_step == 0.0 {
        vec![0.0; values.len()]
    } else {
        values.into_iter().map(finite).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::increments;
    use crate::dataset::{Column, Dataset, Kind, Role, Unit};
    use crate::problem::Channels;

    /// Of a way of 30 m with a gap of 3 s, each reading counted as a step.
    #[test]
    fn a_reading_that_adds_up_is_told_across_a_gap() {
        let time: Vec<f64> =
            (0..600).filter(|i| !(200..260).contains(i)).map(|i| 0.05 * f64::from(i)).collect();
        let way: Vec<f64> = time.iter().map(|time| 1.1 * time - (0.5 * time).sin()).collect();
        let rows = time.len();
        let of = |values: Vec<f64>| {
            let columns = vec![
                Column::new("time", Role::Time, Unit::Second, time.clone()),
                Column::new("way", Role::DriveDistance, Unit::Metre, values),
            ];
            let dataset = Dataset::new("any", Kind::Odometry, columns, vec![0; rows]);
            let channels = Channels::new(&dataset);
            increments(dataset.column(Role::DriveDistance).unwrap(), &channels, false)
        };
        let total = way[rows - 1] - way[0];
        assert!((of(way.clone()).iter().sum::<f64>() - total).abs() < 1e-9);
        // What is a step already stays one.
        let steps: Vec<f64> = way.windows(2).map(|two| two[1] - two[0]).chain([0.05]).collect();
        assert_eq!(of(steps.clone()), steps);
    }
}
