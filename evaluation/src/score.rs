//! Scores over the outcomes of many cases.

use crate::run::Outcome;
use identification::finding::Verdict;
use serde::Serialize;

/// A share of cases, with their total.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Share {
    /// Cases with the property.
    pub of: usize,
    /// Cases that could have it.
    pub out_of: usize,
}

impl Share {
    /// Counts a property over the cases in which it is defined.
    pub fn count(of: impl Iterator<Item = bool>) -> Self {
        of.fold(Self::default(), |share, has| Self {
            of: share.of + usize::from(has),
            out_of: share.out_of + 1,
        })
    }

    /// The share as a number; `None` without cases.
    pub fn value(self) -> Option<f64> {
        (self.out_of > 0).then(|| self.of as f64 / self.out_of as f64)
    }

    /// Wilson's 95 % interval of the probability (Wilson 1927, without continuity correction).
    pub fn wilson(self) -> Option<[f64; 2]> {
        const NORMAL_95: f64 = 1.959_963_984_540_054;
        let p = self.value()?;
        let (n, z2) = (self.out_of as f64, NORMAL_95 * NORMAL_95);
        let centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half = NORMAL_95 / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
        Some([(centre - half).max(0.0), (centre + half).min(1.0)])
    }
}

/// How well the effects of a group of cases were found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// Common properties of the cases.
    pub of: Vec<String>,
    /// Size, or 0 where sizes are mixed.
    pub z: f64,
    /// Number of cases.
    pub cases: usize,
    /// Cases without a finding; they count as not detected.
    pub failed: usize,
    /// An effect was found, or structure was reported as left.
    pub detected: Share,
    /// The verdict is `Explained`.
    pub explained: Share,
    /// The first effect is a true one.
    pub first: Share,
    /// The first effect would be a true one with the candidates and the noise known.
    pub ceiling: Share,
    /// Every true cause is among effects and rivals.
    pub within: Share,
    /// Mean number of rivals of the first effect.
    pub rivals: Option<f64>,
    /// Median ratio of the gain to the oracle's.
    pub gain_median: Option<f64>,
    /// Worst ratio of the gain to the oracle's.
    pub gain_worst: Option<f64>,
    /// Largest error on fresh data over that of the plain model.
    pub rise_worst: Option<f64>,
    /// Number of gains.
    pub gains: usize,
    /// 95 % intervals that contain the truth.
    pub covered: Share,
}

impl Found {
    /// Scores of those outcomes.
    pub fn of(names: &[&str], z: f64, outcomes: &[&Outcome]) -> Self {
        let share = |of: fn(&Outcome) -> bool| Share::count(outcomes.iter().map(|o| of(o)));
        let mut gains: Vec<f64> = outcomes.iter().filter_map(|o| o.gain_ratio).collect();
        gains.sort_by(f64::total_cmp);
        let rivals: Vec<usize> = outcomes.iter().filter_map(|o| o.rivals).collect();
        let mean = rivals.iter().sum::<usize>() as f64 / rivals.len() as f64;
        Self {
            of: names.iter().map(|&name| name.to_owned()).collect(),
            z,
            cases: outcomes.len(),
            failed: outcomes.iter().filter(|o| o.failed.is_some()).count(),
            detected: share(|o| o.detected),
            explained: share(|o| o.explained),
            first: share(|o| o.first),
            ceiling: Share::count(outcomes.iter().filter_map(|o| o.ceiling)),
            within: share(|o| o.within),
            rivals: (!rivals.is_empty()).then_some(mean),
            gain_median: median(&gains),
            gain_worst: gains.first().copied(),
            rise_worst: outcomes
                .iter()
                .flat_map(|o| &o.errors)
                .filter(|[before, ..]| *before > 0.0)
                .map(|[before, after, _]| after / before)
                .reduce(f64::max),
            gains: gains.len(),
            covered: Share::count(outcomes.iter().filter_map(|o| o.covered)),
        }
    }
}

/// False alarms in one class of noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Alarms {
    /// Kind of the data, or `all`.
    pub group: String,
    /// Class of noise, or `all`.
    pub noise: String,
    /// Effects reported in noise alone.
    pub alarms: Share,
    /// Wilson's 95 % interval of their probability.
    pub ci95: Option<[f64; 2]>,
    /// Cases in which structure was reported as left, without an effect.
    pub left: usize,
    /// Cases without a finding; they do not count.
    pub failed: usize,
}

impl Alarms {
    /// False alarms of those outcomes.
    pub fn of(group: &str, noise: &str, outcomes: &[&Outcome]) -> Self {
        let found: Vec<&&Outcome> = outcomes.iter().filter(|o| o.failed.is_none()).collect();
        let alarms = Share::count(found.iter().map(|o| o.false_alarm));
        Self {
            group: group.into(),
            noise: noise.into(),
            alarms,
            ci95: alarms.wilson(),
            left: found
                .iter()
                .filter(|o| o.verdict == Some(Verdict::StructureLeft) && !o.false_alarm)
                .count(),
            failed: outcomes.len() - found.len(),
        }
    }
}

/// Times of one kind of data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Times {
    /// The kind.
    pub group: String,
    /// Median, s.
    pub median: Option<f64>,
    /// Maximum, s.
    pub max: Option<f64>,
    /// Rows of the largest set.
    pub rows_max: usize,
}

impl Times {
    /// Times of those outcomes.
    pub fn of(group: &str, outcomes: &[&Outcome]) -> Self {
        let mut seconds: Vec<f64> = outcomes.iter().map(|o| o.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        Self {
            group: group.into(),
            median: median(&seconds),
            max: seconds.last().copied(),
            rows_max: outcomes.iter().map(|o| o.rows).max().unwrap_or(0),
        }
    }
}

/// Time and memory of one large set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cost {
    /// Name of the case.
    pub case: String,
    /// Its rows.
    pub rows: usize,
    /// Time on one core, s.
    pub seconds: f64,
    /// Peak resident memory of the process, including the set itself, MB.
    pub peak_megabytes: Option<f64>,
    /// Why there is no finding.
    pub failed: Option<String>,
}

/// Median of sorted numbers.
fn median(sorted: &[f64]) -> Option<f64> {
    let n = sorted.len();
    (n > 0).then(|| (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilsons_interval_is_the_published_one() {
        // 1 in 180: 0.098 % to 3.08 %; 0 in 10: 0 to 27.75 % (Brown, Cai, DasGupta 2001).
        let [low, high] = Share { of: 1, out_of: 180 }.wilson().expect("some");
        assert!((low - 0.000_98).abs() < 1e-4 && (high - 0.030_8).abs() < 3e-4, "{low} {high}");
        let [low, high] = Share { of: 0, out_of: 10 }.wilson().expect("some");
        assert!(low == 0.0 && (high - 0.277_5).abs() < 1e-3);
        assert_eq!(Share::default().wilson(), None);
    }

    #[test]
    fn a_case_without_a_finding_is_not_detected_and_no_alarm() {
        let failed = Outcome { failed: Some("refused".into()), ..Outcome::default() };
        let found =
            Outcome { detected: true, first: true, gain_ratio: Some(0.5), ..Outcome::default() };
        let both = Found::of(&["a"], 6.0, &[&failed, &found]);
        assert_eq!((both.failed, both.detected), (1, Share { of: 1, out_of: 2 }));
        assert_eq!((both.gain_median, both.gains), (Some(0.5), 1));
        let alarms = Alarms::of("series", "white", &[&failed]);
        assert_eq!((alarms.alarms.out_of, alarms.failed), (0, 1));
    }
}
