//! What many campaigns say together.

use emulators::random::RandomStream;

/// Campaigns with one search for one mistake.
#[derive(Debug, Clone)]
pub struct Score {
    /// Runs of each until the mistake was found; none where it was not within `runs_max`.
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

    /// Expected runs until it is found: all runs over all finds, the estimate of greatest likelihood where a find is as
    /// likely in every run and campaigns end early. At least one find is counted.
    pub fn expected(&self) -> f64 {
        let found = (self.runs.len() - self.missed()).max(1);
        self.spent().sum::<u64>() as f64 / found as f64
    }

    /// So many campaigns drawn from these, each as often as chance says.
    fn drawn_again(&self, chance: &mut RandomStream) -> Self {
        let count = self.runs.len();
        let pick = |_| {
            let share = 0.5 + 0.5 * chance.symmetric_uniform();
            self.runs[((share * count as f64) as usize).min(count - 1)]
        };
        Self { runs: (0..count).map(pick).collect(), runs_max: self.runs_max }
    }
}

/// `52 (61)`: median and expected runs, and how many campaigns found nothing.
pub fn cell(score: &Score) -> String {
    let missed = match score.missed() {
        0 => String::new(),
        missed => format!(", {missed} missed"),
    };
    format!("{} ({:.0}{missed})", score.median(), score.expected())
}

/// Geometric mean over mistakes of expected runs, as a share of those by chance.
fn ratio(pairs: &[(Score, Score)]) -> f64 {
    let logs = pairs.iter().map(|(one, chance)| (one.expected() / chance.expected()).ln());
    (logs.sum::<f64>() / pairs.len().max(1) as f64).exp()
}

/// Resamplings of the bootstrap.
const RESAMPLINGS: usize = 2_000;

/// The same with its 95 % interval, by bootstrap over campaigns.
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
