//! Assigns values with their own times to the rows nearest in time.

use super::super::error::Defect;
use super::Cell;
use record::figures;

/// Assigns values to rows, without interpolation: a row without a value near it gets none.
#[derive(Debug)]
pub(super) struct Nearest {
    times: Vec<f64>,
    /// A value belongs to a row no further away than this: the median step of the rows.
    reach: f64,
    columns: Vec<Column>,
}

#[derive(Debug)]
struct Column {
    values: Vec<f64>,
    /// Time distance of each value from its row.
    distances: Vec<f64>,
    given: u64,
}

impl Nearest {
    /// For rows at these times, in seconds, and this many channels, the first of which is the time.
    pub(super) fn new(times: &[f64], channels: usize) -> Result<Self, Defect> {
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if !steps.iter().all(|step| *step > 0.0) {
            let why =
                "the times of the rows do not ascend, and channels of other groups go by them";
            return Err(Defect::OtherRaster(why));
        }
        let middle = steps.len() / 2;
        let reach = match steps.is_empty() {
            true => 0.0,
            false => *steps.select_nth_unstable_by(middle, f64::total_cmp).1,
        };
        let column = || Column {
            values: vec![f64::NAN; times.len()],
            distances: vec![f64::INFINITY; times.len()],
            given: 0,
        };
        let columns = (1..channels).map(|_| column()).collect();
        Ok(Self { times: times.to_owned(), reach, columns })
    }

    /// Takes a record: its time, and one value per channel.
    pub(super) fn take(&mut self, cells: &[Cell]) {
        let [Cell::Number(time), values @ ..] = cells else { return };
        let row = self.row(*time);
        for (column, cell) in self.columns.iter_mut().zip(values) {
            let Cell::Number(value) = cell else { continue };
            column.given += 1;
            let Some((row, distance)) = row else { continue };
            if distance < column.distances[row] {
                column.values[row] = *value;
                column.distances[row] = distance;
            }
        }
    }

    /// The row nearest to a time and its distance; `None` if none is near.
    fn row(&self, time: f64) -> Option<(usize, f64)> {
        let after = self.times.partition_point(|row| *row < time);
        let rows = [after.checked_sub(1), Some(after)].into_iter().flatten();
        let distances = rows.filter_map(|row| Some((row, (self.times.get(row)? - time).abs())));
        let nearest = distances.min_by(|one, other| one.1.total_cmp(&other.1));
        nearest.filter(|(_, distance)| *distance <= self.reach)
    }

    /// The values of the channel with this number, counted after the time, one per row; and a notice about the use of
    /// its values.
    pub(super) fn column(&self, number: usize) -> (Vec<f64>, String) {
        let Some(column) = self.columns.get(number) else {
            return (vec![f64::NAN; self.times.len()], String::new());
        };
        let used = column.distances.iter().filter(|distance| distance.is_finite());
        let (count, most) =
            used.fold((0_u64, 0_f64), |(count, most), distance| (count + 1, most.max(*distance)));
        let told = format!(
            "{count} of {} values are at the rows nearest in time, at most {} s from them",
            column.given,
            figures::value(most, 0.0)
        );
        (column.values.clone(), told)
    }
}

#[cfg(test)]
mod tests {
    use super::{Cell, Nearest};

    #[test]
    fn each_value_is_at_the_nearest_row_and_none_is_made_up() {
        let times = [0.0, 1.0, 2.0, 3.0, 10.0];
        let mut nearest = Nearest::new(&times, 2).unwrap();
        for (time, value) in [(-1.5, 1.0), (0.875, 2.0), (1.25, 3.0), (3.5, 4.0), (6.0, 5.0)] {
            nearest.take(&[Cell::Number(time), Cell::Number(value)]);
        }
        nearest.take(&[Cell::Number(10.0), Cell::Missing]);
        let (values, told) = nearest.column(0);
        let found: Vec<_> =
            values.iter().map(|value| (!value.is_nan()).then_some(*value)).collect();
        assert_eq!(found, [None, Some(2.0), None, Some(4.0), None]);
        assert_eq!(told, "2 of 5 values are at the rows nearest in time, at most 0.5 s from them");
        assert!(Nearest::new(&[0.0, 0.0], 2).is_err());
    }

    /// Found by a user: times that are no whole binary fractions were told with sixteen digits.
    #[test]
    fn a_distance_is_told_with_the_digits_that_mean_something() {
        let mut nearest = Nearest::new(&[0.0, 50.0, 100.0], 2).unwrap();
        nearest.take(&[Cell::Number(50.0 + 0.02), Cell::Number(1.0)]);
        assert!((50.0_f64 + 0.02 - 50.0).to_string().len() > 10);
        assert!(nearest.column(0).1.ends_with("at most 0.02 s from them"), "{nearest:?}");
    }
}
