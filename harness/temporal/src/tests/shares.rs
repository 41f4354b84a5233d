//! Robustness as a share of the compared range.

use super::at;
use crate::{Formula, Monitor, NotFound, Signal, Signals, Verdict};

/// A battery: signals of very different ranges, and one without.
struct Battery;

const NAMES: [&str; 4] = ["Voltage", "Contactor", "Revolutions", "Unbounded"];
const RANGES: [Option<(f64, f64)>; 4] =
    [Some((0.0, 5.0)), Some((0.0, 1.0)), Some((-8_000.0, 8_000.0)), None];

impl Signals for Battery {
    fn find(&self, name: &str) -> Result<Signal, NotFound> {
        let index = NAMES.iter().position(|known| *known == name);
        let index = index.ok_or_else(|| NotFound::unknown(name, &NAMES))?;
        let unit = if index == 0 { "V" } else { "" }.to_owned();
        Ok(Signal { index, unit, range: RANGES[index], ..Signal::default() })
    }
}

/// The verdict while the signals have these values.
fn verdict(text: &str, values: [f64; 4]) -> Verdict {
    let formula = Formula::parse(text, &Battery).unwrap_or_else(|mistake| panic!("{mistake}"));
    let mut monitor = Monitor::new(formula);
    let updates: Vec<(usize, f64)> = values.into_iter().enumerate().collect();
    monitor.update(at(0), &updates);
    monitor.finish(at(10))
}

fn share(text: &str, values: [f64; 4]) -> f64 {
    verdict(text, values).robustness
}

#[test]
fn a_margin_is_a_share_of_the_range_of_its_comparison() {
    let now = [4.0, 1.0, 4_000.0, 3.0];
    assert_eq!(share("Voltage < 4.5", now), 0.1);
    assert_eq!(share("Voltage < 4500 mV", now), 0.1);
    assert_eq!(share("Revolutions < 6000", now), 0.125);
    assert_eq!(share("abs(Revolutions) < 6000", now), 0.25);
    assert_eq!(share("Revolutions / 2 < 3000", now), 0.125);
    assert_eq!(share("changes(Revolutions) or Voltage > 3.5", now), 0.1);
    assert_eq!(share("Voltage == 4 +- 0.5", now), 0.1);
    // Two that move in opposite directions can be twice as far apart.
    assert_eq!(share("Revolutions - (0 - Revolutions) < 9600", now), 0.05);
    // Without a range the robustness is in the unit; the same if a division by zero makes the range unbounded.
    assert_eq!(share("Unbounded < 5", now), 2.0);
    assert_eq!(share("Voltage / Contactor < 7", now), 3.0);
}

/// In absolute units the revolutions would always be the furthest away.
#[test]
fn the_comparison_that_is_nearest_by_its_own_range_decides() {
    let text = "Revolutions < 7000 and Voltage < 4.5";
    assert_eq!(share(text, [4.0, 1.0, 6_990.0, 0.0]), 10.0 / 16_000.0);
    let both = verdict("Revolutions < 7000 or Voltage < 4.5", [4.75, 1.0, 7_080.0, 0.0]);
    assert_eq!(both.robustness, -80.0 / 16_000.0);
    // The distance is in the unit of that comparison.
    assert_eq!(both.first_violation.map(|violation| violation.distance), Some(-80.0));
    let volt = verdict(text, [5.0, 1.0, 7_080.0, 0.0]);
    assert_eq!(volt.first_violation.map(|violation| violation.distance), Some(-0.5));
}
