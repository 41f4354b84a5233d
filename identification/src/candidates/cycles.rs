//! Whether angles go far enough round to tell an error that repeats with them.

use std::f64::consts::TAU;

/// Sectors of a cycle, and the share of the values from which one counts as seen.
const SECTORS: usize = 36;
const SEEN_MIN: f64 = 0.001;

/// The longest part of a cycle of that order that none of these angles is in, in sectors. A few that lie apart do not count.
fn gap(order: u8, angles: &[f64]) -> usize {
    let mut counts = [0_usize; SECTORS];
    for angle in angles.iter().filter(|angle| angle.is_finite()) {
        let part = (f64::from(order) * angle / TAU).rem_euclid(1.0) * SECTORS as f64;
        counts[(part as usize).min(SECTORS - 1)] += 1;
    }
    let is_empty = |at: usize| (counts[at % SECTORS] as f64) < SEEN_MIN * angles.len() as f64;
    let from = |from: usize| (from..from + SECTORS).take_while(|at| is_empty(*at)).count();
    (0..SECTORS).map(from).max().unwrap_or(0)
}

/// Whether these angles tell a cycle of that order from a line: they go through more than a third of it, over which it turns from
/// one slope to the opposite one.
pub(super) fn tells_cycles(order: u8, angles: &[f64]) -> bool {
    3 * gap(order, angles) < 2 * SECTORS
}

/// Whether these angles go all the way round: what is wrong with them repeats, and is no curve that ends somewhere.
pub(super) fn go_round(angles: &[f64]) -> bool {
    gap(1, angles) == 0
}

#[cfg(test)]
mod tests {
    use super::super::library;
    use super::{go_round, tells_cycles};
    use crate::dataset::{Column, Constant, Dataset, Drive, Kind, Role, Unit};
    use crate::problem::{Known, Problem};

    #[test]
    fn a_small_part_of_a_cycle_is_a_line() {
        let up_to =
            |most: f64| (0..=100).map(|i| most * f64::from(i) / 100.0).collect::<Vec<f64>>();
        let tells = |most: f64| [1, 2, 5].map(|order| tells_cycles(order, &up_to(most)));
        assert_eq!(tells(6.2), [true; 3]);
        assert!(go_round(&up_to(6.2)) && !go_round(&up_to(5.0)));
        assert_eq!(tells(2.0), [false, true, true]);
        assert_eq!(tells(0.9), [false, false, true]);
        // About zero as about any other angle, and beside a wild one.
        let mut about: Vec<f64> = (-65..=65).map(|i| 0.01 * f64::from(i)).collect();
        about.extend(about.clone().repeat(10));
        about.push(3.0);
        assert!(!tells_cycles(1, &about) && tells_cycles(6, &about));
        assert!(tells_cycles(1, &[0.0, 1.6, 3.1, 4.7].repeat(5)), "four headings");
    }

    /// A slope of the ground stood for the wheelbase of a car that went straight on.
    #[test]
    fn ground_has_a_slope_for_who_drives_about_on_it() {
        let offers = |most: f64| {
            let of = |value: fn(f64) -> f64| (0..600).map(|row| value(f64::from(row))).collect();
            let heading = (0..600).map(|row| most * (f64::from(row) / 20.0).sin()).collect();
            let column = |name, role, unit, values| Column::new(name, role, unit, values);
            let columns = vec![
                column("time", Role::Time, Unit::Second, of(|row| 0.1 * row)),
                column("way", Role::DriveDistance, Unit::Metre, of(|row| 0.05 * row)),
                column("steer", Role::SteerAngle, Unit::Radian, of(|row| 0.2 * (row / 20.0).cos())),
                column("x", Role::ReferenceX, Unit::Metre, of(|row| 0.05 * row)),
                column("y", Role::ReferenceY, Unit::Metre, of(|row| (row / 20.0).sin())),
                column("heading", Role::ReferenceHeading, Unit::Radian, heading),
            ];
            let run = (0..600).map(|row| row / 100).collect();
            let mut dataset = Dataset::new("car", Kind::Odometry, columns, run);
            dataset.drive = Some(Drive::Tricycle);
            let base = Constant { value: 0.3, unit: Unit::Metre };
            dataset.constants.insert("wheelbase".to_owned(), base);
            let problem = Problem::new(&dataset, Known::default()).unwrap();
            let block = &problem.blocks[0];
            let offered = library::library(block, problem.channels_of(block));
            offered.iter().any(|one| one.shape.name == "ground_slope")
        };
        assert!(!offers(0.65));
        assert!(offers(2.5));
    }
}
