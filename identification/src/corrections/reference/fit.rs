//! How wide a reference is evened out, beside a lag and a delay of the sensor.

use super::evened;
use crate::robust::Moments;
use crate::signal::{bends, first_order, interpolate_along};
use crate::{late, robust};
use std::cell::RefCell;
use std::rc::Rc;

/// Readings and their reference in one stretch of time.
#[derive(Debug, Clone, Default)]
pub struct Stretch {
    pub times: Vec<f64>,
    pub reference: Vec<f64>,
    pub readings: Vec<f64>,
}

impl Stretch {
    /// As a delay at first sight sees it.
    fn seen(&self) -> late::Stretch<'_> {
        let readings = self.readings.iter().copied().enumerate().collect();
        late::Stretch { times: &self.times, truth: &self.reference, readings }
    }

    /// Parts of about as many rows each.
    fn pieces(&self) -> impl Iterator<Item = Self> + '_ {
        let rows = self.times.len();
        let size = rows.div_ceil(rows.div_ceil(PIECE).max(1)).max(1);
        (0..rows).step_by(size).map(move |from| {
            let part = |of: &[f64]| of[from..(from + size).min(rows)].to_vec();
            let [times, reference, readings] =
                [&self.times, &self.reference, &self.readings].map(|of| part(of));
            Self { times, reference, readings }
        })
    }
}

/// Rows that take part: of a longer record, stretches of this many rows evenly spread over it.
const ROWS: usize = 12_000;
const PIECE: usize = 1_000;
/// Rows at either end of a stretch that do not count: a lag does not know what came before.
const ENDS: usize = 10;
/// Price of a number of the model, in nats, beside half the logarithm of the rows.
const PRICE: f64 = 6.0;
/// Least share of the mean gain in each quarter of the rows, by level and by slope: noise does not know its input.
const EVERYWHERE: f64 = 0.25;
/// Most that noise keeps of the row before.
const KEPT_MAX: f64 = 0.999;
/// Widths, lags and delays that are tried, in steps between rows; then nearer ones.
const TRIED: [f64; 6] = [0.3, 0.6, 1.5, 4.0, 10.0, 30.0];
const ROUNDS: usize = 6;

/// Width, lag and delay, s.
type Numbers = [f64; 3];

/// The width with which the readings are predicted best, s; none where a lag and a delay do as well without. Slow noise of the
/// sensor hides the noise of the reference: where none is seen beside all of what is left, it is looked for beside what is new in
/// each row.
pub fn width(stretches: &[Stretch]) -> Option<f64> {
    let pieces = Pieces::of(stretches)?;
    [false, true].into_iter().find_map(|is_slow| pieces.clone().beside(is_slow)?.width())
}

/// The rows that take part.
#[derive(Clone)]
struct Pieces {
    all: Vec<Stretch>,
    /// Which of their rows count, one after the other.
    counts: Vec<bool>,
    step: f64,
    /// How late the readings are at first sight, in steps: what follows a reference late is not told by evening it out.
    late: Option<f64>,
    /// Whether noise keeps a share of the row before.
    is_slow: bool,
    /// Independent rows, and their share of all that count and follow one that does.
    free: f64,
    share: f64,
    /// What was evened out and lagged last, with the width and the lag: the numbers change one by one.
    evened: RefCell<Option<(f64, Rows)>>,
    lagged: RefCell<Option<([f64; 2], Rows)>>,
    /// How well the readings are predicted with the numbers that were tried.
    known: RefCell<Vec<(Numbers, f64)>>,
}

/// Values of the rows of each piece.
type Rows = Rc<Vec<Vec<f64>>>;

impl Pieces {
    fn of(stretches: &[Stretch]) -> Option<Self> {
        let rows: usize = stretches.iter().map(|one| one.times.len()).sum();
        let every = rows.div_ceil(ROWS).max(1);
        let all: Vec<Stretch> = stretches.iter().flat_map(Stretch::pieces).step_by(every).collect();
        let steps = all.iter().flat_map(|one| one.times.windows(2).map(|two| two[1] - two[0]));
        let step = robust::median(steps.collect());
        let at_sight: Vec<late::Stretch<'_>> = all.iter().map(Stretch::seen).collect();
        let late = late::delay(&at_sight, step).map(|delay| delay / step);
        // Rows that lie nearer to an end than they are late have no reference.
        let ends = ENDS + late.map_or(0, |late| late.abs().ceil() as usize);
        let counts = all.iter().flat_map(|one| {
            let last = one.times.len().saturating_sub(ends);
            (0..one.times.len()).map(move |row| row >= ends && row < last)
        });
        let found = Self {
            counts: counts.collect(),
            all,
            step,
            late,
            is_slow: false,
            free: 0.0,
            share: 1.0,
            evened: RefCell::default(),
            lagged: RefCell::default(),
            known: RefCell::default(),
        };
        (step > 0.0).then_some(found)
    }

    /// The same where noise keeps a share of the row before, or does not.
    fn beside(self, is_slow: bool) -> Option<Self> {
        let mut found = Self { is_slow, ..self };
        let plain = found.left([0.0; 3]);
        let used: Vec<f64> = found.counted(&plain).collect();
        let limit = robust::GROSS * robust::spread(&used);
        for (counts, left) in found.counts.iter_mut().zip(&plain) {
            *counts &= left.abs() <= limit;
        }
        if !is_slow {
            let alike = found.kept(&plain).min(0.99);
            found.share = (1.0 - alike) / (1.0 + alike);
        }
        found.free = found.share * found.pairs(&plain).count() as f64;
        let square: f64 = found.counted(&plain).map(|left| left * left).sum();
        (found.free > 100.0 && square > 0.0).then_some(found)
    }

    /// The width with which the readings are predicted best.
    fn width(&self) -> Option<f64> {
        let mut best: [Option<(f64, Numbers)>; 2] = [None, None];
        for free in [[false, false], [false, true], [true, false], [true, true]] {
            for with_width in [false, true] {
                let free = [with_width, free[0], free[1]];
                let found = self.fitted(free);
                let best = &mut best[usize::from(with_width)];
                if best.is_none_or(|(value, _)| found.0 > value) {
                    *best = Some(found);
                }
            }
        }
        let (without, with) = (best[0]?, best[1]?);
        (with.0 > without.0 && self.gains_everywhere(without.1, with.1)).then_some(with.1[0])
    }

    fn counted<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        values.iter().zip(&self.counts).filter(|(_, counts)| **counts).map(|(value, _)| *value)
    }

    /// Values of rows that count, each after that of the row before, which counts too.
    fn pairs<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = [f64; 2]> + 'a {
        let rows = 1..values.len();
        rows.filter(|&row| self.counts[row - 1] && self.counts[row])
            .map(|row| [values[row - 1], values[row]])
    }

    /// Share of each of those values that it keeps of the one before.
    fn kept(&self, values: &[f64]) -> f64 {
        let (mut square, mut product) = (f64::MIN_POSITIVE, 0.0);
        for [before, now] in self.pairs(values) {
            square += before * before;
            product += before * now;
        }
        (product / square).clamp(0.0, KEPT_MAX)
    }

    /// What counts of each of those values: what is new in it, if noise is slow.
    fn news(&self, values: &[f64]) -> Vec<f64> {
        let kept = if self.is_slow { self.kept(values) } else { 0.0 };
        self.pairs(values).map(|[before, now]| now - kept * before).collect()
    }

    /// The reference evened out over `width`.
    fn evened(&self, width: f64) -> Rows {
        let of = |one: &Stretch| evened(&one.times, &one.reference, width);
        last(&self.evened, width, || self.all.iter().map(of).collect())
    }

    /// And behind by `lag`.
    fn lagged(&self, width: f64, lag: f64) -> Rows {
        let even = self.evened(width);
        if lag <= 0.0 {
            return even;
        }
        let of = |(one, even): (&Stretch, &Vec<f64>)| {
            first_order(&one.times, even, &bends(&one.times, even), lag)
        };
        last(&self.lagged, [width, lag], || self.all.iter().zip(&*even).map(of).collect())
    }

    /// What the sensor sees of the reference.
    fn seen(&self, [width, lag, delay]: Numbers) -> Vec<f64> {
        let mut found = Vec::with_capacity(self.counts.len());
        for (one, now) in self.all.iter().zip(&*self.lagged(width, lag)) {
            if delay == 0.0 {
                found.extend(now);
            } else {
                let at = one.times.iter().map(|time| time - delay);
                found.extend(interpolate_along(&one.times, now, &bends(&one.times, now), at));
            }
        }
        found
    }

    /// The readings less offset and gain times what is seen.
    fn left(&self, numbers: Numbers) -> Vec<f64> {
        let seen = self.seen(numbers);
        let readings = self.all.iter().flat_map(|one| &one.readings);
        let pairs: Vec<(f64, f64)> = seen.iter().copied().zip(readings.copied()).collect();
        let used = pairs.iter().zip(&self.counts).filter(|(_, counts)| **counts);
        let Moments { x, y, xx, xy, .. } = Moments::of(used.map(|(pair, _)| *pair));
        let gain = if xx > 0.0 { xy / xx } else { 1.0 };
        pairs.iter().map(|(one, other)| other - y - gain * (one - x)).collect()
    }

    /// Logarithm of the likelihood.
    fn value(&self, numbers: Numbers) -> f64 {
        let known = self.known.borrow().iter().find(|one| one.0 == numbers).map(|one| one.1);
        known.unwrap_or_else(|| {
            let square: f64 = self.news(&self.left(numbers)).iter().map(|new| new * new).sum();
            let value = -0.5 * self.free * square.max(f64::MIN_POSITIVE).ln();
            self.known.borrow_mut().push((numbers, value));
            value
        })
    }

    /// Logarithm of the likelihood less the price, at the best of the numbers that are free.
    fn fitted(&self, free: [bool; 3]) -> (f64, Numbers) {
        let value = |numbers: Numbers| self.value(numbers);
        let mut best = (value([0.0; 3]), [0.0; 3]);
        for round in 0..2 {
            for index in (0..3).filter(|&index| free[index]) {
                let signs: &[f64] = if index == 2 { &[1.0, -1.0] } else { &[1.0] };
                if round == 0 || best.1[index] == 0.0 {
                    let near = TRIED.iter().flat_map(|tried| signs.iter().map(move |s| s * tried));
                    for tried in near.chain(self.late.filter(|_| index == 2)) {
                        let mut numbers = best.1;
                        numbers[index] = tried * self.step;
                        best = better(best, (value(numbers), numbers));
                    }
                }
                let mut factor = 1.6;
                for _ in 0..ROUNDS {
                    for by in [factor, 1.0 / factor] {
                        let mut numbers = best.1;
                        numbers[index] *= by;
                        best = better(best, (value(numbers), numbers));
                    }
                    factor = factor.sqrt();
                }
            }
        }
        let count = free.iter().filter(|free| **free).count() as f64;
        (best.0 - count * (PRICE + 0.5 * self.free.ln()), best.1)
    }

    /// Whether the squares fall alike wherever the reference stands, and however fast it moves.
    fn gains_everywhere(&self, without: Numbers, with: Numbers) -> bool {
        let [before, after] = [without, with].map(|numbers| self.news(&self.left(numbers)));
        let seen = self.seen(with);
        let level: Vec<f64> = self.pairs(&seen).map(|[_, now]| now).collect();
        let slope: Vec<f64> = self.pairs(&seen).map(|[before, now]| (now - before).abs()).collect();
        let gains: Vec<f64> = before
            .iter()
            .zip(&after)
            .map(|(before, after)| before * before - after * after)
            .collect();
        [level, slope].into_iter().all(|by| {
            let mut rows: Vec<usize> = (0..by.len()).collect();
            rows.sort_by(|a, b| by[*a].total_cmp(&by[*b]));
            let mean = |rows: &[usize]| {
                let n = rows.len().max(1) as f64;
                let mean = rows.iter().map(|&row| gains[row]).sum::<f64>() / n;
                let square = rows.iter().map(|&row| (gains[row] - mean).powi(2)).sum::<f64>() / n;
                (mean, (square / (n * self.share).min(n)).sqrt())
            };
            let (all, _) = mean(&rows);
            rows.chunks(rows.len().div_ceil(4).max(1)).all(|quarter| {
                let (gain, error) = mean(quarter);
                gain + 2.0 * error >= EVERYWHERE * all
            })
        })
    }
}

/// The values of `key`: those of last time, if it is the same.
fn last<K: PartialEq + Copy>(
    kept: &RefCell<Option<(K, Rows)>>,
    key: K,
    find: impl FnOnce() -> Vec<Vec<f64>>,
) -> Rows {
    if let Some((of, values)) = &*kept.borrow()
        && *of == key
    {
        return Rc::clone(values);
    }
    let found = Rc::new(find());
    *kept.borrow_mut() = Some((key, Rc::clone(&found)));
    found
}

fn better(one: (f64, Numbers), other: (f64, Numbers)) -> (f64, Numbers) {
    if other.0 > one.0 { other } else { one }
}

#[cfg(test)]
mod tests {
    use super::{PIECE, Pieces, ROWS, Stretch};

    /// The one-run records of a fleet are as good as one long record.
    #[test]
    fn pieces_are_spread_evenly_over_a_long_record_however_it_is_cut() {
        let record = |rows: usize, from: usize| {
            let times: Vec<f64> = (from..from + rows).map(|row| row as f64).collect();
            // Noise enough that rows count as independent.
            let readings = times.iter().map(|time| (time * time * 0.7).sin()).collect();
            Stretch { reference: times.clone(), times, readings }
        };
        for (rows, count) in [(400, 100), (2_600, 20), (ROWS * 4, 1)] {
            let all: Vec<Stretch> = (0..count).map(|one| record(rows, one * rows)).collect();
            let pieces = Pieces::of(&all).expect("rows enough").all;
            let used: usize = pieces.iter().map(|one| one.times.len()).sum();
            assert!((ROWS / 2..=ROWS + PIECE).contains(&used), "{rows}: {used}");
            let starts: Vec<f64> = pieces.iter().map(|one| one.times[0]).collect();
            let widest = starts.windows(2).map(|two| two[1] - two[0]).fold(0.0, f64::max);
            let even = (rows * count) as f64 / pieces.len() as f64;
            assert!(widest < 1.5 * even, "{rows}: {widest} of {even}");
        }
    }
}
