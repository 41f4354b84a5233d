//! Which errors have an inverse: a reading tells the truth only where it rises with it.

use super::formula::{Formula, call, number};
use crate::fit::Found;
use crate::late::SENSOR_LATE_MAX;
use crate::model::{Acts, Form, Shape};
use crate::units::{lasting, short};

/// Standard errors at which a slope differs from zero. Within its error of zero, a reading agrees with any truth (Fieller
/// 1954). Errors of real data are those of a noise model that they keep roughly, hence four and not two.
const TOLD: f64 = 4.0;

/// A coefficient of the constants that act so: the sum and its error. One that was given has no error.
fn sum_of(found: &[Found], is_it: impl Fn(&Shape) -> bool) -> (f64, f64) {
    let all = found.iter().filter(|one| is_it(&one.shape));
    let values = all.filter_map(|one| one.coefficients.first().copied());
    values.fold((0.0, 0.0), |(sum, error): (f64, f64), (value, of)| {
        (sum + value, if of.is_nan() { error } else { error.hypot(of) })
    })
}

fn is_gain(shape: &Shape) -> bool {
    (shape.acts, shape.form) == (Acts::Scale, Form::Constant)
}

/// By how much readings rise for one of what is measured, and its error.
fn gain(found: &[Found]) -> (f64, f64) {
    let (scale, error) = sum_of(found, is_gain);
    (1.0 + scale, error)
}

fn rises((slope, error): (f64, f64)) -> bool {
    slope > TOLD * error
}

/// Why readings of `field` cannot be compensated at all by what was `found`.
pub(super) fn refusal(field: &str, found: &[Found]) -> Option<String> {
    let why = |text: String| Some(format!("`{field}` has no compensation: {text}"));
    let (gain, error) = gain(found);
    let (late, _) = sum_of(found, |shape| (shape.acts, shape.form) == (Acts::Delay, Form::Delay));
    if late.abs() > SENSOR_LATE_MAX {
        let (time, way) = (lasting(late.abs()), if late > 0.0 { "late" } else { "early" });
        return why(format!(
            "its time stamps are {time} {way}, longer than any sensor takes; set its clock or that of the reference, and \
             identify again"
        ));
    }
    if rises((gain, error)) {
        return None;
    }
    let size = format!("{} +- {}", short(gain), short(error));
    if rises((-gain, error)) {
        return why(format!(
            "it falls where the reference rises (gain {size}), and no wrong sign explains that; see whether both are the same \
             quantity"
        ));
    }
    why(format!(
        "its gain of {size} could as well be zero, so that a reading says nothing about the truth"
    ))
}

/// Whether readings beyond the limit of the `knee` still rise with what is measured, so that they tell it. Where they rise more
/// steeply, they do if they rise at all.
pub(super) fn rises_beyond(knee: &Found, found: &[Found]) -> bool {
    let ((gain, of_gain), (less, of_less)) =
        (gain(found), knee.coefficients.first().copied().unwrap_or((1.0, 0.0)));
    less <= 0.0 || rises((gain - less, of_gain.hypot(of_less)))
}

/// The truth of `straight`, which readings of this `gain` would tell if they did not rise by `less` of it beyond the limits
/// of `knee`.
pub(super) fn unbent(straight: Formula, knee: &Shape, gain: f64, less: f64) -> Formula {
    let Some(limit) = knee.number("limit").filter(|_| gain > less) else { return straight };
    let lower = knee.number("lower_limit").unwrap_or(-limit);
    let within = call("clamp", [straight.clone(), number(lower), number(limit)]);
    straight.clone() + number(gain / (gain - less) - 1.0) * (straight - within)
}

#[cfg(test)]
mod tests {
    use super::{refusal, rises_beyond};
    use crate::fit::Found;
    use crate::model::{Acts, Driver, Form, Shape};

    fn with_gain(gain: f64, error: f64) -> Found {
        Found::new(&Shape::constant("scale_factor", Acts::Scale), vec![(gain - 1.0, error)])
    }

    fn said(found: &[Found]) -> String {
        refusal("x", found).unwrap_or_default()
    }

    #[test]
    fn what_does_not_rise_with_the_truth_or_is_hours_late_is_refused() {
        assert_eq!(refusal("x", &[with_gain(0.005, 4e-6)]), None);
        assert!(
            said(&[with_gain(0.002, 0.003)])
                .contains("gain of 0.00200 +- 0.00300 could as well be zero")
        );
        assert!(said(&[with_gain(0.9, f64::INFINITY)]).contains("could as well be zero"));
        assert!(said(&[with_gain(-8.3, 0.2)]).contains("it falls where the reference rises"));
        let late = |by: f64| {
            let shape = Shape::new("delay", Acts::Delay, Driver::plain("x"), Form::Delay);
            Found::new(&shape, vec![(by, 1.0)])
        };
        assert_eq!(refusal("x", &[with_gain(1.0, 0.01), late(12.0)]), None);
        assert!(said(&[with_gain(1.0, 0.01), late(-7200.0)]).contains("2.00 h early"));
    }

    #[test]
    fn a_knee_is_flat_where_nothing_rises_beyond_it() {
        let rises = |(less, error): (f64, f64)| {
            let shape =
                Shape::new("saturation", Acts::Saturation, Driver::plain("x"), Form::Saturation);
            let knee = Found::new(&shape, vec![(less, error)]);
            rises_beyond(&knee, &[with_gain(0.95, 0.01), knee.clone()])
        };
        assert_eq!(
            [-0.5, 0.4, 0.9, 1.0].map(|less| rises((less, 0.05))),
            [true, true, false, false]
        );
        // Few readings lie beyond a limit.
        assert!(rises((-0.5, 0.6)));
    }
}
