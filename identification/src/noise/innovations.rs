//! Innovations of columns of observations, for known gains. When the covariance has settled, observations that are alike share
//! their gains.

/// Maximum number of states: the level and the coloured parts.
pub const STATES_MAX: usize = 5;
/// Maximum number of columns filtered together: a single column waits for its own last state at each step, several keep
/// the processor busy.
const LANES: usize = 8;

/// Effect of an observation on the state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// Share of itself that each state keeps.
    pub keep: [f64; STATES_MAX],
    /// Share of the innovation that each state takes.
    pub gain: [f64; STATES_MAX],
}

impl Gains {
    /// Those of a filter with fewer states.
    pub fn of<const S: usize>(keep: [f64; S], gain: [f64; S]) -> Self {
        let of = |few: [f64; S]| {
            let mut all = [0.0; STATES_MAX];
            all[..S].copy_from_slice(&few);
            all
        };
        Self { keep: of(keep), gain: of(gain) }
    }
}

/// The Kalman filter for given times and a given noise. Observations share their gains once it has settled.
#[derive(Debug, Clone, Default)]
pub struct Filter {
    /// Number of states, including the level.
    pub states: usize,
    /// Whether the first state is a level that accumulates the sum of the others.
    pub levels: bool,
    /// Whether the state restarts at each observation.
    pub starts: Vec<bool>,
    /// Time since the previous observation.
    pub step: Vec<f64>,
    /// Gain from the states to each observation.
    pub seen: Vec<f64>,
    /// One over the standard deviation of the innovation; 0 for an unused observation.
    pub weight: Vec<f64>,
    /// Index of the gains of each observation.
    pub which: Vec<u32>,
    /// The distinct gains.
    pub gains: Vec<Gains>,
}

impl Filter {
    /// Stores the gains of the next observation and returns their index.
    pub fn push(&mut self, gains: Gains) -> u32 {
        let which = self.gains.len() as u32;
        self.gains.push(gains);
        self.which.push(which);
        which
    }

    /// The innovations of each column, of equal variance.
    pub fn innovations<C: AsRef<[f64]>>(&self, columns: &[C]) -> Vec<Vec<f64>> {
        if self.states == 0 {
            let weigh = |column: &C| {
                column.as_ref().iter().zip(&self.weight).map(|(v, weight)| v * weight).collect()
            };
            return columns.iter().map(weigh).collect();
        }
        self.each(columns)
    }

    fn with_states<O: Observation, const N: usize>(&self, columns: [&[f64]; N]) -> [Vec<f64>; N] {
        match self.states {
            1 => self.run::<O, 1, N>(columns),
            2 => self.run::<O, 2, N>(columns),
            3 => self.run::<O, 3, N>(columns),
            4 => self.run::<O, 4, N>(columns),
            _ => self.run::<O, STATES_MAX, N>(columns),
        }
    }

    fn run<O: Observation, const S: usize, const N: usize>(
        &self,
        columns: [&[f64]; N],
    ) -> [Vec<f64>; N] {
        let n = self.weight.len();
        let columns = columns.map(|column| &column[..n]);
        let mut found = [(); N].map(|()| vec![0.0; n]);
        let mut state = [[0.0; N]; S];
        for i in 0..n {
            let Gains { keep, gain } = &self.gains[self.which[i] as usize];
            let weight = self.weight[i];
            if self.starts[i] {
                state = [[0.0; N]; S];
            }
            let expected = O::expected(&mut state, keep, self.step[i], self.seen[i]);
            for lane in 0..N {
                let innovation = columns[lane][i] - expected[lane];
                for a in 0..S {
                    state[a][lane] += gain[a] * innovation;
                }
                found[lane][i] = innovation * weight;
            }
        }
        found
    }
}

/// A filter that takes several columns side by side.
pub(super) trait Several {
    /// The innovations of each of these.
    fn several<const N: usize>(&self, columns: [&[f64]; N]) -> [Vec<f64>; N];

    /// The innovations of each of any number of columns.
    fn each<C: AsRef<[f64]>>(&self, columns: &[C]) -> Vec<Vec<f64>> {
        let mut found = Vec::with_capacity(columns.len());
        for several in columns.chunks(LANES) {
            let several: Vec<&[f64]> = several.iter().map(AsRef::as_ref).collect();
            match *several.as_slice() {
                [a, b, c, d, e, f, g, h] => found.extend(self.several([a, b, c, d, e, f, g, h])),
                [a, b, c, d, ref rest @ ..] => {
                    found.extend(self.several([a, b, c, d]));
                    found.extend(self.few(rest));
                }
                ref few => found.extend(self.few(few)),
            }
        }
        found
    }

    /// The innovations of each of less than four columns.
    fn few(&self, columns: &[&[f64]]) -> Vec<Vec<f64>> {
        match *columns {
            [a, b, c] => self.several([a, b, c]).into(),
            [a, b] => self.several([a, b]).into(),
            ref others => others.iter().flat_map(|one| self.several([one])).collect(),
        }
    }
}

impl Several for Filter {
    fn several<const N: usize>(&self, columns: [&[f64]; N]) -> [Vec<f64>; N] {
        if self.levels {
            self.with_states::<Levels, N>(columns)
        } else {
            self.with_states::<Rows, N>(columns)
        }
    }
}

/// What an observation measures.
trait Observation {
    /// Advances the states of each lane to the next observation and returns its expected value.
    fn expected<const S: usize, const N: usize>(
        state: &mut [[f64; N]; S],
        keep: &[f64; STATES_MAX],
        step: f64,
        seen: f64,
    ) -> [f64; N];
}

/// The observation is the sum of all states.
struct Rows;

impl Observation for Rows {
    #[inline(always)]
    fn expected<const S: usize, const N: usize>(
        state: &mut [[f64; N]; S],
        keep: &[f64; STATES_MAX],
        _step: f64,
        seen: f64,
    ) -> [f64; N] {
        let mut sum = [0.0; N];
        for a in 0..S {
            for lane in 0..N {
                state[a][lane] *= keep[a];
                sum[lane] += state[a][lane];
            }
        }
        sum.map(|sum| seen * sum)
    }
}

/// The observation is the first state, which accumulates the previous values of the others.
struct Levels;

impl Observation for Levels {
    #[inline(always)]
    fn expected<const S: usize, const N: usize>(
        state: &mut [[f64; N]; S],
        keep: &[f64; STATES_MAX],
        step: f64,
        _seen: f64,
    ) -> [f64; N] {
        for lane in 0..N {
            let rate: f64 = (1..S).map(|a| state[a][lane]).sum();
            state[0][lane] += step * rate;
            for a in 1..S {
                state[a][lane] *= keep[a];
            }
        }
        state[0]
    }
}

/// Inputs that determine the covariance after an observation, besides the previous covariance.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Inputs {
    pub step: f64,
    pub activity: f64,
    pub seen: f64,
    pub own: f64,
    pub new_run: bool,
}

/// The previous observation: once the covariance has settled, the next has the same gains.
#[derive(Default)]
pub(super) struct Last {
    pub inputs: Option<Inputs>,
    pub which: u32,
    pub weight: f64,
    pub log_variance: f64,
    pub is_settled: bool,
}

/// Time steps that differ by less than this share are equal: the rest is rounding.
const STEP_EQUAL: f64 = 1e-9;
/// The covariance has settled once an observation changes it by less than this share.
const SETTLED: f64 = 1e-14;

impl Last {
    pub fn is_like(&self, now: &Inputs) -> bool {
        self.inputs.is_some_and(|last| {
            let steps_equal = (now.step - last.step).abs() <= STEP_EQUAL * last.step;
            steps_equal && Inputs { step: last.step, ..*now } == last
        })
    }

    pub fn repeats(&self, now: &Inputs) -> bool {
        self.is_settled && self.is_like(now)
    }
}

pub(super) fn has_settled<const S: usize>(before: &[[f64; S]; S], after: &[[f64; S]; S]) -> bool {
    let pairs = before.iter().flatten().zip(after.iter().flatten());
    pairs.into_iter().all(|(before, after)| (before - after).abs() <= SETTLED * after.abs())
}

#[cfg(test)]
mod tests {
    use super::{Filter, Gains, STATES_MAX};

    /// A column is whitened to the same values alone and among others.
    #[test]
    fn company_changes_nothing() {
        let n = 50;
        for levels in [false, true] {
            let mut filter = Filter {
                states: 3,
                levels,
                starts: (0..n).map(|i| i % 20 == 0).collect(),
                step: vec![0.5; n],
                seen: (0..n).map(|i| 1.0 + 0.1 * (i % 3) as f64).collect(),
                weight: (0..n).map(|i| if i == 7 { 0.0 } else { 2.0 }).collect(),
                ..Filter::default()
            };
            for i in 0..n {
                let (keep, gain) = ([0.9; STATES_MAX], [0.1 + 0.001 * i as f64; STATES_MAX]);
                filter.push(Gains { keep, gain });
            }
            let columns: Vec<Vec<f64>> =
                (0..23).map(|k| (0..n).map(|i| ((i * (k + 3)) as f64).sin()).collect()).collect();
            let together = filter.innovations(&columns);
            let alone: Vec<Vec<f64>> =
                columns.iter().flat_map(|column| filter.innovations(&[column])).collect();
            assert_eq!(together, alone);
        }
    }
}
