//! Physical ranges of terms, each with its source. A value outside is not a calibration but a different fault.

use super::{Acts, Driver, Form, Shape, Wrap, narrowest_play};
use crate::dataset::Dimension;
use crate::late::SHARE_MAX;
use crate::problem::Channels;
use crate::robust;

/// Maximum delay of filters and buffers, in samples.
const SAMPLES_LATE_MAX: f64 = 10.0;

/// Range of the values of a kind of term, SI. `None` if unknown.
fn range(acts: Acts, channels: &Channels) -> Option<[f64; 2]> {
    Some(match acts {
        // A gyro that reads nothing has a scale error of -1; one that reads twice the rate has another unit or is
        // another gyro (data sheets of MEMS parts state 3 % and less). A wrong sign is corrected earlier.
        Acts::Scale => [-1.05, 1.0],
        // Effective track of a skid-steered robot: one to five times the geometric one (Mandow et al. 2007, figure 6:
        // 1.3 to 2.4; on ice more). A track that is too wide by half is a wrong file.
        Acts::Turn => [-0.8, 0.5],
        // A wheel half or twice as large as stated means a wrong file.
        Acts::Drive => [-0.5, 1.0],
        // Unequal wheels: 10 % over a track of 0.1 m.
        Acts::Curvature => [-1.0, 1.0],
        // Slip removes a part of the distance, not all of it.
        Acts::Slip => [-1.0, 1.0],
        // A clock of ceramic or RC is within some per cent (data sheets of microcontrollers).
        Acts::Clock => [-0.05, 0.05],
        // A sensor sits on the robot.
        Acts::Reference => [-5.0, 5.0],
        // A device is late by a second at most, or by some samples at a slow rate.
        Acts::Delay => {
            let late = (SAMPLES_LATE_MAX * channels.interval()).max(1.0);
            [-late, late]
        }
        // Share of a rotation about another axis: the sine of an angle, plus some scale error.
        Acts::Axis => [-1.1, 1.1],
        _ => return None,
    })
}

/// Range of the value of `shape`, SI, of readings that rise by one for one of what is measured. `None` if unknown.
pub fn range_of(shape: &Shape, channels: &Channels) -> Option<[f64; 2]> {
    let [low, high] = range(shape.acts, channels)?;
    let is_delay =
        shape.acts == Acts::Delay && shape.drivers.iter().all(|one| one.wrap == Wrap::Plain);
    // Two recordings whose clocks nobody set against one another are off by any time that leaves enough of both to compare.
    let apart = if is_delay { SHARE_MAX * channels.span() } else { 0.0 };
    Some([low.min(-apart), high.max(apart)])
}

/// Maximum sensitivity of a gyro's bias to acceleration, rad/s/(m/s^2): 1 deg/s/g, five to ten times what data sheets
/// state (ADXRS150: 0.2, MPU-6050: 0.1 deg/s/g). A larger sensitivity belongs to the rotation or the temperature that
/// varies with the acceleration.
const OF_ACCELERATION_MAX: f64 = 0.017_453 / 9.806_65;

/// Maximum variation of a gyro's scale with anything, twice the 10 % of an uncalibrated part (ADXRS150: 12.5 mV/(deg/s)
/// within 10 % over its whole temperature range; MPU-6050: 2 %, nonlinearity 0.2 %).
const OF_SCALE_MAX: f64 = 0.2;

/// Maximum share of the measured quantity that a sensor shows late (creep of a load cell is below 0.001, of a polymer some
/// hundredths). One that shows most of it late is slow, which is a delay.
const CREEP_MAX: f64 = 0.3;

/// Maximum share of the measured quantity that goes through a play: all of it, plus some scale error. Where the play is narrow
/// against the motion, the readings show only this times the width, and noise can make the share of any size.
const PLAY_MAX: f64 = 1.1;

/// Whether the contribution of `shape` with `coefficients` is within the range. `columns` are its columns over the
/// rows.
pub fn is_physical(
    shape: &Shape,
    channels: &Channels,
    columns: &[Vec<f64>],
    coefficients: &[f64],
) -> bool {
    // What goes with what is measured is as large as the unit of the readings makes it.
    let gain = if goes_with_gain(shape, channels) { channels.gain } else { 1.0 };
    let coefficients: Vec<f64> = coefficients.iter().map(|value| value / gain).collect();
    let coefficients = &*coefficients;
    let is_narrow =
        |driver: &Driver| driver.wrap == Wrap::BranchOf && driver.field == channels.rotation_name;
    if shape.drivers.iter().any(is_narrow)
        && shape.number("half_width").is_some_and(|half| half < narrowest_play(channels))
    {
        return false;
    }
    // What holds a rate back takes it away and gives none.
    if shape.form == Form::DeadZone && coefficients.iter().any(|value| value / channels.gain < 0.0)
    {
        return false;
    }
    if shape.acts == Acts::Bias && !channels.of_sensor {
        return bears_acceleration(shape, channels, columns, coefficients);
    }
    let share_max = shape
        .drivers
        .first()
        .filter(|driver| shape.acts == Acts::Bias && driver.field == channels.rotation_name)
        .and_then(|driver| match driver.wrap {
            Wrap::LagOf => Some(CREEP_MAX),
            Wrap::BranchOf => Some(PLAY_MAX),
            _ => None,
        });
    if let Some(most) = share_max {
        return coefficients.iter().all(|value| value.abs() <= most);
    }
    let is_filter = matches!(shape.form, Form::Delay)
        && shape.drivers.first().is_some_and(|driver| driver.wrap == Wrap::LagOf);
    if is_filter && coefficients.iter().any(|value| *value < 0.0) {
        // A sensor does not see what is to come: where it seems to, its reference is late.
        return false;
    }
    if shape.acts == Acts::Delay && channels.of_sensor {
        // A probe in a thick wall is minutes late.
        return true;
    }
    if shape.acts == Acts::Scale && !channels.of_sensor && !shape.drivers.is_empty() {
        let [low, high] = ends(columns, coefficients);
        if high - low > OF_SCALE_MAX {
            return false;
        }
    }
    let Some([low, high]) = range_of(shape, channels) else { return true };
    let inside = |value: f64| value >= low && value <= high;
    if matches!(shape.form, Form::Delay) || shape.acts == Acts::Axis {
        return coefficients.iter().all(|value| inside(*value));
    }
    let rows = columns.first().map_or(0, Vec::len);
    // A subset of the rows is enough.
    let stride = rows.div_ceil(2000).max(1);
    (0..rows).step_by(stride).all(|row| {
        inside(columns.iter().zip(coefficients).map(|(column, value)| column[row] * value).sum())
    })
}

/// Whether the coefficients of `shape` are in the unit of the readings for each unit of what a sensor measures.
fn goes_with_gain(shape: &Shape, channels: &Channels) -> bool {
    let is_measured = |driver: &Driver| driver.field == channels.rotation_name;
    match (shape.acts, shape.form) {
        (Acts::Scale | Acts::Axis, _) => true,
        // The share that is late is in the columns.
        (_, Form::Delay) => false,
        (Acts::Bias, Form::Linear) => shape.drivers.first().is_some_and(is_measured),
        _ => false,
    }
}

/// Whether the part of a gyro's bias that depends on an acceleration is within the range.
fn bears_acceleration(
    shape: &Shape,
    channels: &Channels,
    columns: &[Vec<f64>],
    coefficients: &[f64],
) -> bool {
    let accelerations = shape
        .drivers
        .iter()
        .filter_map(|driver| channels.named(&driver.field))
        .filter(|channel| channel.unit.dimension() == Dimension::Acceleration);
    let Some(span) = accelerations.map(|channel| channel.span()).reduce(f64::max) else {
        return true;
    };
    let [low, high] = ends(columns, coefficients);
    !(high - low > OF_ACCELERATION_MAX * span)
}

/// Lowest and highest contribution over the rows.
fn ends(columns: &[Vec<f64>], coefficients: &[f64]) -> [f64; 2] {
    let rows = columns.first().map_or(0, Vec::len);
    let value = |row: usize| -> f64 {
        columns.iter().zip(coefficients).map(|(column, value)| column[row] * value).sum()
    };
    robust::ends((0..rows).map(value)).into()
}

#[cfg(test)]
mod tests {
    use super::is_physical;
    use crate::model::tests::channels;
    use crate::model::{Acts, Driver, Form, Shape, Wrap};

    #[test]
    fn a_bias_follows_an_acceleration_by_no_more_than_data_sheets_allow() {
        let mut channels = channels();
        let line = Shape::new("any", Acts::Bias, Driver::plain("jolt"), Form::Linear);
        let column = line.per_row(&channels).unwrap();
        // 0.2 deg/s/g, and five times that.
        assert!(is_physical(&line, &channels, &column, &[3.6e-4]));
        assert!(!is_physical(&line, &channels, &column, &[-9e-3]));
        let late = Shape::new("bandwidth", Acts::Delay, Driver::plain("jolt"), Form::Delay);
        assert!(!is_physical(&late, &channels, &column, &[1200.0]));
        // A pressure sensor is not a gyro, and a thermometer is slow.
        channels.of_sensor = true;
        assert!(is_physical(&line, &channels, &column, &[-9e-3]));
        assert!(is_physical(&late, &channels, &column, &[20.0]));
    }

    #[test]
    fn a_scale_varies_by_no_more_than_data_sheets_allow() {
        let channels = channels();
        let bump = Shape::new("any", Acts::Scale, Driver::plain("x"), Form::Bump);
        let column = vec![vec![0.0, 0.5, 1.0]];
        assert!(is_physical(&bump, &channels, &column, &[0.1]));
        assert!(!is_physical(&bump, &channels, &column, &[0.33]));
        let constant = Shape::constant("scale_factor", Acts::Scale);
        assert!(is_physical(&constant, &channels, &[vec![1.0; 3]], &[0.33]));
    }

    #[test]
    fn no_more_goes_through_a_play_than_all_of_what_is_measured() {
        let mut channels = channels();
        channels.of_sensor = true;
        let driver = Driver::new(Wrap::BranchOf, &channels.rotation_name);
        let play =
            Shape::new("hysteresis", Acts::Bias, driver, Form::Linear).with("half_width", 0.4);
        for gain in [1.0, 250.0, -0.01] {
            channels.gain = gain;
            let is_physical = |share: f64| is_physical(&play, &channels, &[], &[share * gain]);
            assert!(is_physical(0.3) && is_physical(1.02), "{gain}");
            assert!(!is_physical(-1.78), "{gain}");
        }
    }

    /// Beside a scale error, a dead zone that adds an eighth is a gyro that clips.
    #[test]
    fn a_dead_zone_adds_nothing() {
        let mut channels = channels();
        let driver = Driver::plain(&channels.rotation_name);
        let zone = Shape::new("dead_zone", Acts::DeadZone, driver, Form::DeadZone);
        for gain in [1.0, -0.01] {
            channels.gain = gain;
            let is_physical = |part: f64| is_physical(&zone, &channels, &[], &[part * gain]);
            assert!(is_physical(1.0) && !is_physical(-0.125), "{gain}");
        }
    }

    #[test]
    fn a_scale_of_minus_23_is_refused() {
        let channels = channels();
        let is_physical = |shape: &Shape, columns: &[Vec<f64>], values: &[f64]| {
            is_physical(shape, &channels, columns, values)
        };
        let constant = Shape::constant("distance_scale", Acts::Drive);
        let ones = vec![vec![1.0; 4]];
        assert!(is_physical(&constant, &ones, &[-0.4]));
        assert!(!is_physical(&constant, &ones, &[-23.4]));
        let line = Shape::new("any", Acts::Drive, Driver::plain("x"), Form::Linear);
        let x = vec![vec![0.0, 1.0, 10.0]];
        assert!(is_physical(&line, &x, &[0.05]));
        assert!(!is_physical(&line, &x, &[0.5]), "at the end of the range seen");
        let bias = Shape::constant("bias", Acts::Bias);
        assert!(is_physical(&bias, &ones, &[1e6]));
    }
}
