//! Statistics over many campaigns.

use emulators::random::RandomStream;

/// Campaigns with one search for one mutant.
#[derive(Debug, Clone)]
pub struct Score {
    /// Runs of each campaign until the mutant was found; `None` if it was not found within `runs_max`.
    pub runs: Vec<Option<u64>>,
    /// Runs after which a campaign gives up.
    pub runs_max: u64,
}

impl Score {
    fn spent(&self) -> impl Iterator<Item = u64> {
        self.runs.iter().map(|runs| runs.unwrap_or(self.runs_max))
    }

    pub fn median(&self) -> u64 {
        let mut spent: Vec<u64> = self.spent().collect();
        spent.sort_unstable();
        spent.get(spent.len() / 2).copied().unwrap_or_default()
    }

    pub fn missed(&self) -> usize {
        self.runs.iter().filter(|runs| runs.is_none()).count()
    }

    /// Expected runs until it is found: all runs divided by all finds, the maximum-likelihood estimate if every run has
    /// the same probability of a find and campaigns end early. Counts at least one find.
    pub fn expected(&self) -> f64 {
        let found = (self.runs.len() - self.missed()).max(1);
        self.spent().sum::<u64>() as f64 / found as f64
    }

    /// Draws as many campaigns from these, with replacement.
    fn drawn_again(&self, chance: &mut RandomStream) -> Self {
        let count = self.runs.len();
        let pick = |_| {
            let share = 0.5 + 0.5 * chance.symmetric_uniform();
            self.runs[((share * count as f64) as usize).min(count - 1)]
        };
        Self { runs: (0..count).map(pick).collect(), runs_max: self.runs_max }
    }
}

/// Formats `52 (61)`: median and expected runs, and how many campaigns found nothing.
pub fn cell(score: &Score) -> String {
    let missed = match score.missed() {
        0 => String::new(),
        missed => format!(", {missed} missed"),
    };
    format!("{} ({:.0}{missed})", score.median(), score.expected())
}

/// Geometric mean over mutants of the expected runs, relative to those by chance.
fn ratio(pairs: &[(Score, Score)]) -> f64 {
    let logs = pairs.iter().map(|(one, chance)| (one.expected() / chance.expected()).ln());
    (logs.sum::<f64>() / pairs.len().max(1) as f64).exp()
}

/// Resamplings of the bootstrap.
const RESAMPLINGS: usize = 2_000;

/// The ratio with its 95 % interval, by bootstrap over campaigns.
pub fn ratio_and_interval(pairs: &[(Score, Score)]) -> (f64, f64, f64) {
    let mut chance = RandomStream::new(1, "score", "bootstrap");
    let mut again: Vec<f64> = (0..RESAMPLINGS)
        .map(|_| {
            let drawn: Vec<_> = pairs
                .iter()
                .map(|(a, b)| (a.drawn_again(&mut chance), b.drawn_again(&mut chance)))
                .collect();
            ratio(&drawn)
        })
        .collect();
    again.sort_by(f64::total_cmp);
    (ratio(pairs), again[RESAMPLINGS / 40], again[RESAMPLINGS - 1 - RESAMPLINGS / 40])
}
