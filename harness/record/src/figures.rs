//! Formats figures for people: the uncertainty sets the digits, bands read as text.

/// Digits of an uncertainty (GUM 7.2.6: at most two).
const UNCERTAINTY_DIGITS: i32 = 2;

/// Digits of a figure without uncertainty.
const EXACT_DIGITS: i32 = 4;

/// Most digits of a limit: it is stated, and rounded like a figure it would be another one.
const LIMIT_DIGITS: i32 = 9;

/// Digits that tell any two numbers apart.
const DIGITS_MAX: i32 = 17;

/// An uncertainty below this share of its value is a rounding error of the arithmetic and is not shown.
const ROUNDING: f64 = 1e-12;

/// A figure that needs more decimals than this is written with an exponent.
const DECIMALS_MAX: i32 = 9;

/// So is one from here on: above it a double does not hold every whole number.
const WHOLE_MAX: f64 = 9_007_199_254_740_992.0;

/// A value, rounded where its standard uncertainty makes further digits meaningless.
pub fn value(value: f64, uncertainty: f64) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    if is_said(value, uncertainty) {
        let decimals = UNCERTAINTY_DIGITS - 1 - exponent(uncertainty);
        return rounded(value, decimals);
    }
    exact(value, EXACT_DIGITS)
}

fn is_said(value: f64, uncertainty: f64) -> bool {
    uncertainty.is_finite() && uncertainty > ROUNDING * value.abs()
}

/// A value without uncertainty, to this many digits.
pub fn exact(value: f64, digits: i32) -> String {
    if value.fract() == 0.0 && value.abs() < WHOLE_MAX {
        return positive_zero(format!("{value:.0}"));
    }
    let written = rounded(value, digits - 1 - exponent(value));
    match written.contains('.') && !written.contains('e') {
        true => written.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => written,
    }
}

/// A value with its unit and its standard uncertainty, if it has them.
pub fn quantity(value: f64, uncertainty: f64, unit: &str) -> String {
    let mut text = self::value(value, uncertainty);
    if is_said(value, uncertainty) {
        text += &format!(" ± {}", self::value(uncertainty, uncertainty));
    }
    with_unit(text, unit)
}

/// Like [`quantity`], with as many digits as it takes to be on the same side of each limit as the value, and, where it has no
/// uncertainty, with the decimals of the limits: 1013.51 beside 1013.5 is not 1014.
pub fn quantity_beside(
    value: f64,
    uncertainty: f64,
    unit: &str,
    limits: impl IntoIterator<Item = f64>,
) -> String {
    let shown = |limit: f64| (limit, stated(limit).parse::<f64>().unwrap_or(limit));
    let shown: Vec<(f64, f64)> = limits.into_iter().map(shown).collect();
    let is_told = |text: &str| {
        let number = text.parse::<f64>();
        let is_so = |number: f64| {
            let mut limits = shown.iter();
            limits.all(|(limit, shown)| {
                value == *limit || number.partial_cmp(shown) == value.partial_cmp(limit)
            })
        };
        number.is_ok_and(is_so)
    };
    let is_said = is_said(value, uncertainty);
    if !value.is_finite() || is_said && is_told(&self::value(value, uncertainty)) {
        return quantity(value, uncertainty, unit);
    }
    let behind =
        |(_, shown): &(f64, f64)| shown.to_string().split_once('.').map(|(_, behind)| behind.len());
    let decimals = shown.iter().filter_map(behind).max().unwrap_or(0) as i32;
    let least = if is_said || value == 0.0 { 0 } else { decimals + 1 + exponent(value) };
    let longer =
        (least.clamp(EXACT_DIGITS, DIGITS_MAX)..=DIGITS_MAX).map(|digits| exact(value, digits));
    let longer = longer.take_while(|text| !text.contains('e')).find(|text| is_told(text));
    let mut text = longer.unwrap_or_else(|| value.to_string());
    if is_said {
        text += &format!(" ± {}", self::value(uncertainty, uncertainty));
    }
    with_unit(text, unit)
}

/// A value with its unit, rounded to its standard uncertainty, which is not shown.
pub fn quantity_alone(value: f64, uncertainty: f64, unit: &str) -> String {
    with_unit(self::value(value, uncertainty), unit)
}

/// A limit with its unit, as exact as it was stated.
pub fn limit(limit: f64, unit: &str) -> String {
    with_unit(stated(limit), unit)
}

fn stated(limit: f64) -> String {
    if !limit.is_finite() {
        return limit.to_string();
    }
    // As many as a figure with all its decimals has.
    let digits = (DECIMALS_MAX + 1).saturating_add(exponent(limit));
    exact(limit, digits.clamp(EXACT_DIGITS, LIMIT_DIGITS))
}

/// A band in words.
pub fn band(lower: Option<f64>, upper: Option<f64>, unit: &str) -> String {
    let text = match (lower, upper) {
        (None, None) => return "none".to_owned(),
        (None, Some(upper)) => format!("at most {}", stated(upper)),
        (Some(lower), None) => format!("at least {}", stated(lower)),
        (Some(lower), Some(upper)) if lower == upper => stated(lower),
        (Some(lower), Some(upper)) if lower == -upper => format!("±{}", stated(upper)),
        (Some(lower), Some(upper)) => format!("{} to {}", stated(lower), stated(upper)),
    };
    with_unit(text, unit)
}

/// The label of an axis.
pub fn axis_label(name: &str, unit: &str) -> String {
    match unit {
        "" | "1" => name.to_owned(),
        _ => format!("{name} in {unit}"),
    }
}

/// A duration in seconds, in readable units.
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() || seconds < 0.0 {
        return format!("{seconds} s");
    }
    // Round first: 59.96 s is a minute, not 60.0 s.
    let tenths = (seconds * 10.0).round() as u64;
    let whole = seconds.round() as u64;
    match whole {
        _ if tenths < 600 => format!("{}.{} s", tenths / 10, tenths % 10),
        0..3_600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3_600, whole / 60 % 60),
    }
}

/// How often: "once", or "3 times".
pub fn times(count: u64) -> String {
    match count {
        1 => "once".to_owned(),
        _ => format!("{count} times"),
    }
}

/// A number of things: "1 case", or "3 cases".
pub fn counted(count: u64, one: &str, many: &str) -> String {
    if count == 1 { format!("1 {one}") } else { format!("{count} {many}") }
}

/// The least margin of a property, a share of its limit; `None` if it shows as zero. A comparison for equality that
/// holds has a margin of zero, and one that is broken shows by how much in its unit.
pub fn least_margin(margin: f64) -> Option<String> {
    let is_shown = margin.is_finite() && margin.abs() >= 0.0005;
    is_shown.then(|| format!("{margin:.3}"))
}

/// Appends the unit, if any, to a formatted number.
pub fn with_unit(text: String, unit: &str) -> String {
    // A bare "1" is the SI notation for no unit.
    match unit {
        "" | "1" => text,
        "%" => format!("{text} %"),
        _ => format!("{text} {unit}"),
    }
}

/// A value to the 15 digits that every number of 64 bits holds: those behind them come from the arithmetic of its scaling. A whole
/// number has all its digits; the shortest text ends with zeros that it has not.
pub fn all_digits(value: f64) -> String {
    const WIDEST: f64 = 18_446_744_073_709_551_616.0;
    if (WHOLE_MAX..=WIDEST).contains(&value.abs()) {
        return format!("{value:.0}");
    }
    if value.fract() == 0.0 {
        return value.to_string();
    }
    format!("{value:.14e}").parse().unwrap_or(value).to_string()
}

/// The power of ten of the first significant digit.
fn exponent(value: f64) -> i32 {
    value.abs().log10().floor() as i32
}

fn rounded(value: f64, decimals: i32) -> String {
    match usize::try_from(decimals.max(0)) {
        Ok(decimals) if decimals <= DECIMALS_MAX as usize && value.abs() < WHOLE_MAX => {
            positive_zero(format!("{value:.decimals$}"))
        }
        _ => format!("{value:.2e}"),
    }
}

/// Drops the sign of a value that was rounded to zero.
fn positive_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::{band, counted, duration, least_margin, quantity, quantity_beside, value};
    use proptest::prelude::*;

    #[test]
    fn a_long_whole_number_has_all_its_digits() {
        for (value, shown) in [
            (1_152_921_504_606_846_976.0, "1152921504606846976"),
            (-9_223_372_036_854_775_808.0, "-9223372036854775808"),
            (4.25, "4.25"),
            (7.0 * 0.05, "0.35"),
            (-5_941.0 * 0.01, "-59.41"),
            (9_007_199_254_740_991.0, "9007199254740991"),
            (f64::INFINITY, "inf"),
            (1e25, "10000000000000000000000000"),
        ] {
            assert_eq!(super::all_digits(value), shown);
        }
    }

    #[test]
    fn one_thing_is_one() {
        assert_eq!(counted(1, "case", "cases"), "1 case");
        assert_eq!(counted(0, "case", "cases"), "0 cases");
    }

    #[test]
    fn the_uncertainty_decides_the_digits() {
        for (v, u, written) in [
            (-0.314_159, 0.2, "-0.31"),
            (-0.314_159, 0.02, "-0.314"),
            (1_234.56, 25.0, "1235"),
            (1_234.56, 2_500.0, "1235"),
            (-0.001, 0.2, "0.00"),
            (0.0, 0.0, "0"),
            (300.0, 0.0, "300"),
            (-0.52, 0.0, "-0.52"),
            (0.953_333_3, 0.0, "0.9533"),
            (-0.000_012_1, 0.0, "-0.0000121"),
            (1.5e-12, 0.0, "1.50e-12"),
            (1e300, 0.0, "1.00e300"),
            (-3.4e38, 1e36, "-3.40e38"),
            (f64::NAN, 0.2, "NaN"),
            (1.25, f64::NAN, "1.25"),
            (0.1, 6.84e-18, "0.1"),
        ] {
            assert_eq!(value(v, u), written, "{v} {u}");
        }
        assert_eq!(quantity(-0.52, 0.004, "deg/K"), "-0.5200 ± 0.0040 deg/K");
        assert_eq!(quantity(1.0, 0.0, "1"), "1");
        assert_eq!(quantity(0.1, 6.84e-18, "s"), "0.1 s");
    }

    #[test]
    fn a_value_is_told_from_a_limit() {
        for (value, uncertainty, limit, written) in [
            (117.804, 0.0, 117.8, "117.804 s"),
            (117.8 + 1e-7, 0.0, 117.8, "117.8000001 s"),
            (117.8 + 1e-13, 0.0, 117.8, "117.8000000000001 s"),
            (117.9, 0.0, 117.8, "117.9 s"),
            (117.804, 0.02, 117.8, "117.804 ± 0.020 s"),
            (117.800_4, 0.02, 117.8, "117.8004 ± 0.020 s"),
            (118.0, 0.02, 117.8, "118.000 ± 0.020 s"),
            (117.8, 0.0, 117.8, "117.8 s"),
            (123_456.5, 0.0, 123_456.4, "123456.5 s"),
            (123_456.45, 0.0, 123_456.4, "123456.45 s"),
            (123_456.3, 0.0, 123_456.4, "123456.3 s"),
            (1_013.51, 0.0, 1_013.5, "1013.51 s"),
            (1_234.5, 0.0, 1_234.5, "1234.5 s"),
            (1_012.98, 0.0, 1_013.0, "1012.98 s"),
            (0.0, 0.0, 0.25, "0 s"),
            (f64::NAN, 0.0, 0.25, "NaN s"),
            (f64::INFINITY, 0.0, 0.25, "inf s"),
            (123_456.3, 0.0, 123_456.2, "123456.3 s"),
            (117.799_6, 0.02, 117.8, "117.7996 ± 0.020 s"),
            (118.0, 0.0, 117.999_999_999_99, "118 s"),
        ] {
            assert_eq!(quantity_beside(value, uncertainty, "s", [limit]), written);
        }
        let both = [123_456.2, 123_456.4];
        assert_eq!(quantity_beside(123_456.3, 0.0, "s", both), "123456.3 s");
    }

    #[test]
    fn a_margin_that_shows_as_zero_is_not_shown() {
        assert_eq!(least_margin(-0.000_02), None);
        assert_eq!(least_margin(0.0), None);
        assert_eq!(least_margin(0.25).as_deref(), Some("0.250"));
        assert_eq!(least_margin(-0.5).as_deref(), Some("-0.500"));
    }

    #[test]
    fn a_band_is_said_in_words() {
        assert_eq!(band(Some(-0.25), Some(0.25), "deg"), "±0.25 deg");
        assert_eq!(band(Some(0.9), None, ""), "at least 0.9");
        assert_eq!(band(None, Some(3.0), "%"), "at most 3 %");
        assert_eq!(band(Some(-0.6), Some(-0.44), "deg/K"), "-0.6 to -0.44 deg/K");
        assert_eq!(band(Some(0.0), Some(0.0), ""), "0");
        assert_eq!(band(None, None, "deg"), "none");
        assert_eq!(band(Some(123_456.2), Some(123_456.4), "km"), "123456.2 to 123456.4 km");
        assert_eq!(band(None, Some(48_137_154.1), "m"), "at most 48137154.1 m");
        assert_eq!(band(Some(0.1 + 0.2), None, ""), "at least 0.3");
        assert_eq!(band(Some(0.001_23), Some(1e-12), ""), "0.00123 to 1.00e-12");
    }

    #[test]
    fn time_is_said_in_two_units() {
        assert_eq!(duration(1.23), "1.2 s");
        assert_eq!(duration(59.96), "1 min 00 s");
        assert_eq!(duration(125.0), "2 min 05 s");
        assert_eq!(duration(57_600.0), "16 h 00 min");
    }

    proptest! {
        #[test]
        fn a_written_value_is_within_its_uncertainty(v in -1e6f64..1e6, u in 1e-6f64..1e3) {
            let back: f64 = value(v, u).parse().unwrap();
            prop_assert!((back - v).abs() <= u.max(0.5), "{} {}", v, u);
        }

        #[test]
        fn no_figure_panics(v in any::<f64>(), u in any::<f64>()) {
            let _ = (quantity(v, u, "m"), band(Some(v), Some(u), "m"), duration(v));
            let _ = quantity_beside(v, u, "m", [u, v]);
        }
    }
}
