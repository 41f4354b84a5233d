//! Converts values of any size to values that fit on an axis.

use super::super::frame::Axis;
use super::super::thin::Point;
use record::figures;

/// Smaller or larger values are drawn with another power of ten.
const SIZE_MIN: f64 = 1e-3;
const SIZE_MAX: f64 = 1e5;

/// An axis further from zero than this multiple of its length is drawn relative to its begin.
const FAR: f64 = 1e4;

/// Conversion of values to positions on an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ruler {
    offset: f64,
    factor: f64,
    /// Label of the axis: quantity and unit.
    pub label: String,
}

impl Ruler {
    /// Creates a ruler for values of `name` in `unit` from the lowest to the highest.
    pub(super) fn new(name: &str, unit: &str, (low, high): (f64, f64)) -> Self {
        let mut ruler = Self { offset: 0.0, factor: 1.0, label: figures::axis_label(name, unit) };
        if !(low.is_finite() && high.is_finite()) {
            return ruler;
        }
        if high > low && low.abs().min(high.abs()) > FAR * (high - low) {
            ruler.offset = low;
            let name = format!("{name} - {}", figures::value(low, 0.0));
            ruler.label = figures::axis_label(&name, unit);
            return ruler;
        }
        let size = low.abs().max(high.abs());
        if size > 0.0 && !(SIZE_MIN..SIZE_MAX).contains(&size) {
            let thousands = (size.log10() / 3.0).floor() as i32;
            ruler.factor = 10_f64.powi(-3 * thousands);
            let unit = if unit == "1" { "" } else { unit };
            let unit = format!("10{} {unit}", superscript(3 * thousands));
            ruler.label = figures::axis_label(name, unit.trim_end());
        }
        ruler
    }

    pub(super) fn around(name: &str, unit: &str, values: impl IntoIterator<Item = f64>) -> Self {
        Self::new(name, unit, ends(values))
    }

    pub(super) fn place(&self, value: f64) -> f64 {
        (value - self.offset) * self.factor
    }

    pub(super) fn axis(&self, values: impl IntoIterator<Item = f64>) -> Axis {
        Axis::around(&*self.label, values.into_iter().map(|value| self.place(value)))
    }
}

/// Converts points with two rulers, without those that are not finite.
pub(super) fn placed(points: &[Point], x: &Ruler, y: &Ruler) -> Vec<Point> {
    points
        .iter()
        .map(|point| (x.place(point.0), y.place(point.1)))
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect()
}

fn superscript(exponent: i32) -> String {
    let raised = |c: char| match c {
        '-' => '\u{207b}',
        '1' => '\u{b9}',
        '2' => '\u{b2}',
        '3' => '\u{b3}',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    exponent.to_string().chars().map(raised).collect()
}

/// Returns the lowest and highest finite value; without any, an inverted infinite range.
pub(super) fn ends(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let finite = values.into_iter().filter(|value| value.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
}

#[cfg(test)]
mod tests {
    use super::Ruler;

    #[test]
    fn small_figures_get_a_power_of_ten() {
        let ruler = Ruler::new("rate", "rad/s", (-2e-5, 1e-5));
        assert_eq!(ruler.label, "rate in 10⁻⁶ rad/s");
        assert!((ruler.place(-2e-5) + 20.0).abs() < 1e-9);
        assert_eq!(Ruler::new("rate", "1", (0.0, 3e7)).label, "rate in 10⁶");
        assert_eq!(Ruler::new("rate", "deg/s", (0.0, 0.02)).label, "rate in deg/s");
    }

    #[test]
    fn seconds_since_1970_begin_at_zero() {
        let ruler = Ruler::new("time", "s", (1.7e9, 1.7e9 + 60.0));
        assert_eq!(ruler.label, "time - 1700000000 in s");
        assert!((ruler.place(1.7e9 + 60.0) - 60.0).abs() < 1e-6);
        assert_eq!(Ruler::new("x", "", (f64::INFINITY, f64::NEG_INFINITY)).place(3.0), 3.0);
    }
}
