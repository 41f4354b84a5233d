//! Checks that treat each value separately: the worst one, a share, a number of exceptions.

use super::figure::{COVERAGE, Figure, Refusal, graded, is_clear, verdict};
use super::select::Sample;
use plan::Band;
use record::outcome::Verdict;

/// The worst value: by verdict, then by distance to the nearer end of the band, then by magnitude.
pub(super) fn worst(samples: &[Sample], band: Band, when: &str) -> Result<Figure, Refusal> {
    let rank = |sample: &Sample| {
        let verdict = verdict(sample.value, sample.uncertainty, band);
        let badness = match verdict {
            Verdict::Fail | Verdict::Unset => 2,
            Verdict::Marginal => 1,
            Verdict::Pass => 0,
        };
        (badness, -band.margin(sample.value))
    };
    let worst = samples.iter().max_by(|a, b| {
        let ((a_badness, a_depth), (b_badness, b_depth)) = (rank(a), rank(b));
        let by_depth = a_badness.cmp(&b_badness).then(a_depth.total_cmp(&b_depth));
        // Of equals the greater, regardless of order.
        by_depth.then(a.value.total_cmp(&b.value))
    });
    let Some(worst) = worst else {
        return Err(Refusal::Unset("no observation".to_owned()));
    };
    let statistic = format!("worst of {}{when}", samples.len());
    Figure::in_band(worst.value, worst.uncertainty, band, statistic)
}

/// The share of values inside.
pub(super) fn share(samples: &[Sample], least: f64, band: Band) -> Result<Figure, Refusal> {
    let count = samples.len();
    let share = |coverage: f64| {
        let clear = |s: &&Sample| is_clear(s.value, s.uncertainty, band, coverage);
        samples.iter().filter(clear).count() as f64 / count as f64
    };
    let value = share(0.0);
    Ok(Figure {
        value,
        uncertainty: (share(-1.0) - share(1.0)) / 2.0,
        verdict: graded(value >= least, share(COVERAGE) >= least),
        statistic: format!("share of {count} inside {band}"),
    })
}

/// The number of values outside.
pub(super) fn outside(samples: &[Sample], most: u32, band: Band) -> Result<Figure, Refusal> {
    let clear = |s: &Sample, coverage| is_clear(s.value, s.uncertainty, band, coverage);
    exceptions(samples, most, clear, &format!("outside {band}"))
}

/// The number of items outside. `is_inside` takes an item and the number of standard uncertainties by which it must be
/// inside.
pub(super) fn exceptions<T>(
    items: &[T],
    most: u32,
    is_inside: impl Fn(&T, f64) -> bool,
    what: &str,
) -> Result<Figure, Refusal> {
    let count = items.len();
    if count <= most as usize {
        // Otherwise the check would pass with no item inside.
        let least = u64::from(most) + 1;
        return Err(Refusal::Unset(format!("{count} observations of at least {least}")));
    }
    let outside =
        |coverage: f64| items.iter().filter(|item| !is_inside(item, coverage)).count() as f64;
    let (value, most) = (outside(0.0), f64::from(most));
    Ok(Figure {
        value,
        uncertainty: (outside(1.0) - outside(-1.0)) / 2.0,
        verdict: graded(value <= most, outside(COVERAGE) <= most),
        statistic: format!("number of {count} {what}"),
    })
}
