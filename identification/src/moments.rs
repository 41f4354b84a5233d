//! Sums over pairs of numbers, of which lines are made.

/// Means of pairs, and sums of squares and products about them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moments {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) xx: f64,
    pub(crate) xy: f64,
    pub(crate) yy: f64,
}

impl Moments {
    pub(crate) fn of(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let n = pairs.clone().count().max(1) as f64;
        let (x, y) = pairs.clone().fold((0.0, 0.0), |(x, y), (a, b)| (x + a / n, y + b / n));
        let sums = Self { x, y, xx: 0.0, xy: 0.0, yy: 0.0 };
        pairs.fold(sums, |sums, (a, b)| Self {
            xx: sums.xx + (a - x).powi(2),
            xy: sums.xy + (a - x) * (b - y),
            yy: sums.yy + (b - y).powi(2),
            ..sums
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Moments;

    #[test]
    fn a_line_is_made_of_them() {
        let pairs = [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)];
        let Moments { x, y, xx, xy, yy } = Moments::of(pairs.into_iter());
        assert_eq!((x, y), (1.0, 3.0));
        assert_eq!((xy / xx, yy - xy * xy / xx), (2.0, 0.0));
        assert_eq!(Moments::of(std::iter::empty()).xx, 0.0);
    }
}
