//! Delays in sentences.

use super::phrases::{is_in_rows, of_axis};
use crate::finding::Effect;
use crate::late::SENSOR_LATE_MAX;
use crate::units::{short, unit_of_time};

pub(super) fn is_delay(effect: &Effect) -> bool {
    (effect.term.as_str(), effect.name.as_str()) == ("delay", "delay")
}

/// Sentence for a common delay or lead of all these axes; `None` if they differ. Beyond what a sensor takes it is two clocks.
pub(super) fn delay(effects: &[&Effect]) -> Option<String> {
    let sizes = effects.iter().map(|effect| effect.parameters.first().map(|one| one.value));
    let sizes: Vec<f64> = sizes.collect::<Option<_>>()?;
    let late = sizes.iter().all(|size| *size >= 0.0);
    let ends = sizes.iter().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), size| {
        (low.min(size.abs()), high.max(size.abs()))
    });
    if !(late || sizes.iter().all(|size| *size < 0.0)) || ends.1 > SAME_DELAY * ends.0 {
        return None;
    }
    let is_of_rows = effects.iter().all(|effect| is_in_rows(&effect.parameters[0]));
    let (unit, one) = if is_of_rows { ("rows", 1.0) } else { unit_of_time(ends.1) };
    let [low, high] = [ends.0, ends.1].map(|size| short(size / one));
    let size = if low == high { low } else { format!("{low} to {high}") };
    let way = if late { "later" } else { "earlier" };
    let axes: Vec<String> = effects.iter().map(|effect| of_axis(effect)).collect();
    let of = match axes.as_slice() {
        [one] => one.clone(),
        [others @ .., last] => {
            let axes = others.iter().map(|axis| axis.trim_start_matches(" of axis "));
            let last = last.trim_start_matches(" of axis ");
            format!(" of axes {} and {last}", axes.collect::<Vec<_>>().join(", "))
        }
        [] => String::new(),
    };
    let has_time = effects.iter().all(|effect| effect.parameters[0].unit == "s");
    if has_time && ends.0 > SENSOR_LATE_MAX {
        return Some(format!(
            "The clocks of what is measured{of} and of the reference are {size} {unit} apart: its time stamps come {way}."
        ));
    }
    Some(format!("What is measured{of} comes {size} {unit} {way} than the reference."))
}

/// Delays of axes within this factor are one delay.
const SAME_DELAY: f64 = 1.5;
