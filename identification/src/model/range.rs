//! Physical ranges of what a term may do, each with its source. What lies outside is no calibration but another fault.

use super::{Acts, Form, Shape};

/// Where the values of a kind of term lie, SI. `None` where nothing is known.
pub fn range(acts: Acts) -> Option<[f64; 2]> {
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
        // Whoever is later than a second is another recording.
        Acts::Delay => [-1.0, 1.0],
        // The share of a rotation about another axis: the sine of an angle, a little more where it is scaled.
        Acts::Axis => [-1.1, 1.1],
        _ => return None,
    })
}

/// Is what `shape` adds with `coefficients` within the range? `columns` are its columns over the rows.
pub fn is_physical(shape: &Shape, columns: &[Vec<f64>], coefficients: &[f64]) -> bool {
    let Some([low, high]) = range(shape.acts) else { return true };
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

#[cfg(test)]
mod tests {
    use super::is_physical;
    use crate::model::{Acts, Driver, Form, Shape};

    #[test]
    fn a_scale_of_minus_23_is_refused() {
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
