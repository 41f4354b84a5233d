//! Physical ranges of what a term may do, each with its source. What lies outside is no calibration but another fault.

use super::{Acts, Form, Shape};
use crate::dataset::Dimension;
use crate::problem::Channels;

/// What filters and buffers hold back is counted in samples: so many of them, at most.
const SAMPLES_LATE_MAX: f64 = 10.0;

/// Where the values of a kind of term lie, SI. `None` where nothing is known.
pub fn range(acts: Acts, channels: &Channels) -> Option<[f64; 2]> {
    Some(match acts {
        // A gyro that reads nothing has a scale error of -1; one that reads twice the rate is another unit or gyro
        // (data sheets of MEMS parts state 3 % and less). What has the wrong sign is found before.
        Acts::Scale => [-1.05, 1.0],
        // Effective track of a skid-steered robot: one to five times the geometric one (Mandow et al. 2007, figure 6:
        // 1.3 to 2.4; on ice more). A track that is too wide by half is a wrong file.
        Acts::Turn => [-0.8, 0.5],
        // A wheel that is half or twice as large as its file says is a wrong file.
        Acts::Drive => [-0.5, 1.0],
        // Unequal wheels: 10 % over a track of 0.1 m.
        Acts::Curvature => [-1.0, 1.0],
        // Slip takes away, and not all.
        Acts::Slip => [-1.0, 1.0],
        // A clock of ceramic or RC is within some per cent (data sheets of microcontrollers).
        Acts::Clock => [-0.05, 0.05],
        // A sensor sits on the robot.
        Acts::Reference => [-5.0, 5.0],
        // Whoever is later than a second, and than some samples where these are slow, is another recording.
        Acts::Delay => {
            let late = (SAMPLES_LATE_MAX * channels.interval()).max(1.0);
            [-late, late]
        }
        // The share of a rotation about another axis: the sine of an angle, a little more where it is scaled.
        Acts::Axis => [-1.1, 1.1],
        _ => return None,
    })
}

/// How much an acceleration may change the bias of a gyro, rad/s/(m/s^2): 1 deg/s/g, five to ten times what data sheets
/// state (ADXRS150: 0.2, MPU-6050: 0.1 deg/s/g). What follows an acceleration more than that follows the rotation or
/// the warmth that the acceleration goes with.
const OF_ACCELERATION_MAX: f64 = 0.017_453 / 9.806_65;

/// Is what `shape` adds with `coefficients` within the range? `columns` are its columns over the rows.
pub fn is_physical(
    shape: &Shape,
    channels: &Channels,
    columns: &[Vec<f64>],
    coefficients: &[f64],
) -> bool {
    if shape.acts == Acts::Bias && !channels.of_sensor {
        return bears_acceleration(shape, channels, columns, coefficients);
    }
    if shape.acts == Acts::Delay && channels.of_sensor {
        // A probe in a thick wall is minutes late.
        return true;
    }
    let Some([low, high]) = range(shape.acts, channels) else { return true };
    let inside = |value: f64| value >= low && value <= high;
    if matches!(shape.form, Form::Delay) || shape.acts == Acts::Axis {
        return coefficients.iter().all(|value| inside(*value));
    }
    let rows = columns.first().map_or(0, Vec::len);
    // Every so many rows say it.
    let stride = rows.div_ceil(2000).max(1);
    (0..rows).step_by(stride).all(|row| {
        inside(columns.iter().zip(coefficients).map(|(column, value)| column[row] * value).sum())
    })
}

/// Is the part of a gyro's bias that goes with an acceleration within the range?
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
    let rows = columns.first().map_or(0, Vec::len);
    let (low, high) = (0..rows)
        .map(|row| {
            columns.iter().zip(coefficients).map(|(column, value)| column[row] * value).sum()
        })
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), value: f64| {
            (low.min(value), high.max(value))
        });
    !(high - low > OF_ACCELERATION_MAX * span)
}

#[cfg(test)]
mod tests {
    use super::is_physical;
    use crate::model::tests::channels;
    use crate::model::{Acts, Driver, Form, Shape};

    #[test]
    fn a_bias_follows_an_acceleration_by_no_more_than_data_sheets_allow() {
        let mut channels = channels();
        let line = Shape::new("any", Acts::Bias, Driver::plain("jolt"), Form::Linear);
        let column = line.per_row(&channels).unwrap();
        // 0.2 deg/s/g, and 5 of them.
        assert!(is_physical(&line, &channels, &column, &[3.6e-4]));
        assert!(!is_physical(&line, &channels, &column, &[-9e-3]));
        let late = Shape::new("bandwidth", Acts::Delay, Driver::plain("jolt"), Form::Delay);
        assert!(!is_physical(&late, &channels, &column, &[1200.0]));
        // A pressure sensor is no gyro, and a thermometer is slow.
        channels.of_sensor = true;
        assert!(is_physical(&line, &channels, &column, &[-9e-3]));
        assert!(is_physical(&late, &channels, &column, &[20.0]));
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
