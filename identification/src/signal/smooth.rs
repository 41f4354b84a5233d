//! Level and slope of a noisy channel: the cubic smoothing spline, as a Kalman smoother of an integrated Wiener process
//! (Wahba 1978, Wecker and Ansley 1983). Maximum likelihood sets the amount of smoothing.

/// A channel, smoothed.
#[derive(Debug, Clone, PartialEq)]
pub struct Smooth {
    /// Its level at each sample.
    pub level: Vec<f64>,
    /// Its slope at each sample, per second.
    pub slope: Vec<f64>,
}

/// Maximum number of samples from which the smoothing is chosen.
const CHOICE_SAMPLES_MAX: usize = 4000;
/// Factor between tried ratios of process noise to measurement noise, in units of the sample interval.
const RATIO_STEP: f64 = 10.0;
const RATIO_EXPONENT_MIN: i32 = -12;
const RATIO_EXPONENT_MAX: i32 = 6;

/// Smooths `values` at increasing `times`; missing values (NaN) are bridged.
pub fn smooth(times: &[f64], values: &[f64]) -> Smooth {
    let present = values.iter().filter(|value| value.is_finite()).count();
    if present < 3 {
        let level = values.iter().copied().find(|value| value.is_finite()).unwrap_or(f64::NAN);
        return Smooth { level: vec![level; values.len()], slope: vec![0.0; values.len()] };
    }
    let ratio = choose(times, values);
    Filter::new(times, values, ratio).smoothed()
}

fn typical_interval(times: &[f64]) -> f64 {
    let mut intervals: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    intervals.sort_by(f64::total_cmp);
    intervals.get(intervals.len() / 2).copied().filter(|dt| *dt > 0.0).unwrap_or(1.0)
}

fn choose(times: &[f64], values: &[f64]) -> f64 {
    let interval = typical_interval(times);
    let middle = times.len().saturating_sub(CHOICE_SAMPLES_MAX) / 2;
    let range = middle..times.len().min(middle + CHOICE_SAMPLES_MAX);
    let (times, values) = (&times[range.clone()], &values[range]);
    let unit = 1.0 / interval.powi(3);
    (RATIO_EXPONENT_MIN..=RATIO_EXPONENT_MAX)
        .map(|exponent| unit * RATIO_STEP.powi(exponent))
        .map(|ratio| (Filter::new(times, values, ratio).log_likelihood, ratio))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(unit, |(_, ratio)| ratio)
}

type State = [f64; 2];
/// Variances of level and slope, and their covariance in the middle.
type Covariance = [f64; 3];

/// A diffuse start, in units of the measurement noise: wider than the process wanders over the record.
fn start(times: &[f64], ratio: f64) -> Covariance {
    let span = (times[times.len() - 1] - times[0]).max(1e-9);
    let wide = 1e7 * (1.0 + ratio * span.powi(3));
    [wide, 0.0, wide / (span * span)]
}

/// The covariance `dt` later.
fn advanced([a, b, c]: Covariance, dt: f64, ratio: f64) -> Covariance {
    [
        a + 2.0 * dt * b + dt * dt * c + ratio * dt.powi(3) / 3.0,
        b + dt * c + ratio * dt * dt / 2.0,
        c + ratio * dt,
    ]
}

/// Products of three series beside a smooth course of each of them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Beside {
    /// Sums of the products of their innovations.
    pub products: [[f64; 3]; 3],
    /// Number of innovations, and the logarithm of the determinant of their covariance.
    count: f64,
    log_det: f64,
}

impl Beside {
    /// Ratios that are tried for samples that lie `interval` apart.
    pub fn ratios(interval: f64) -> impl Iterator<Item = f64> {
        let unit = interval.powi(-3);
        (RATIO_EXPONENT_MIN..=RATIO_EXPONENT_MAX)
            .map(move |exponent| unit * RATIO_STEP.powi(exponent))
    }

    /// Adds a stretch of time. A row takes part if all of its values are numbers.
    pub fn add(&mut self, times: &[f64], values: [&[f64]; 3], ratio: f64) {
        let is_known = |i: &usize| values.iter().all(|values| values[*i].is_finite());
        let mut rows = (0..times.len()).filter(is_known);
        let Some(first) = rows.next() else { return };
        let mut states: [State; 3] = std::array::from_fn(|k| [values[k][first], 0.0]);
        let mut p = start(times, ratio);
        let (mut before, mut used) = (first, 0_usize);
        for i in std::iter::once(first).chain(rows) {
            let dt = times[i] - times[before];
            p = advanced(p, dt, ratio);
            let s = p[0] + 1.0;
            let gain = [p[0] / s, p[1] / s];
            p = [p[0] / s, p[1] / s, p[2] - gain[1] * p[1]];
            let mut errors = [0.0; 3];
            for ((state, values), error) in states.iter_mut().zip(values).zip(&mut errors) {
                state[0] += dt * state[1];
                *error = values[i] - state[0];
                state[0] += gain[0] * *error;
                state[1] += gain[1] * *error;
            }
            // The first two only locate the start of the course.
            if used >= 2 {
                for (row, one) in self.products.iter_mut().zip(errors) {
                    row.iter_mut().zip(errors).for_each(|(sum, other)| *sum += one * other / s);
                }
                self.log_det += s.ln();
                self.count += 1.0;
            }
            (before, used) = (i, used + 1);
        }
    }

    /// Logarithm of the likelihood of a series that leaves this sum of squares.
    pub fn log_likelihood(&self, square: f64) -> f64 {
        -0.5 * (self.count * (square / self.count.max(1.0)).ln() + self.log_det)
    }

    /// Variance of the white noise of one that leaves this sum of squares beside the two others.
    pub fn variance(&self, square: f64) -> f64 {
        square / (self.count - 2.0).max(1.0)
    }
}

struct Filter {
    predicted: Vec<(State, Covariance)>,
    updated: Vec<(State, Covariance)>,
    intervals: Vec<f64>,
    log_likelihood: f64,
}

impl Filter {
    fn new(times: &[f64], values: &[f64], ratio: f64) -> Self {
        let n = values.len();
        let first = values.iter().copied().find(|v| v.is_finite()).unwrap_or(0.0);
        let mut state: State = [first, 0.0];
        let mut p = start(times, ratio);
        let (mut sum, mut log_det, mut used) = (0.0, 0.0, 0_usize);
        let mut filter = Self {
            predicted: Vec::with_capacity(n),
            updated: Vec::with_capacity(n),
            intervals: Vec::with_capacity(n),
            log_likelihood: 0.0,
        };
        for i in 0..n {
            let dt = if i == 0 { 0.0 } else { times[i] - times[i - 1] };
            if i > 0 {
                state[0] += dt * state[1];
                p = advanced(p, dt, ratio);
            }
            filter.intervals.push(dt);
            filter.predicted.push((state, p));
            if values[i].is_finite() {
                let s = p[0] + 1.0;
                let e = values[i] - state[0];
                let gain = [p[0] / s, p[1] / s];
                state[0] += gain[0] * e;
                state[1] += gain[1] * e;
                p = [p[0] / s, p[1] / s, p[2] - gain[1] * p[1]];
                // The first two only locate the start of the channel.
                if used >= 2 {
                    sum += e * e / s;
                    log_det += s.ln();
                }
                used += 1;
            }
            filter.updated.push((state, p));
        }
        let count = used.saturating_sub(2) as f64;
        // A perfect fit (a channel that is a ramp) must not win by an infinite margin.
        let floor = 1e-24 * (1.0 + first * first);
        filter.log_likelihood = -0.5 * (count * (sum / count.max(1.0) + floor).ln() + log_det);
        filter
    }

    /// Rauch, Tung and Striebel's backward pass.
    fn smoothed(self) -> Smooth {
        let n = self.updated.len();
        let mut level = vec![0.0; n];
        let mut slope = vec![0.0; n];
        let mut next = self.updated[n - 1].0;
        (level[n - 1], slope[n - 1]) = (next[0], next[1]);
        for i in (0..n - 1).rev() {
            let dt = self.intervals[i + 1];
            let (x, p) = self.updated[i];
            let (ahead, q) = self.predicted[i + 1];
            let determinant = q[0] * q[2] - q[1] * q[1];
            if determinant > 0.0 {
                // P F' Q^-1, with F = [1 dt; 0 1].
                let a = [[p[0] + dt * p[1], p[1]], [p[1] + dt * p[2], p[2]]];
                let inverse = [q[2] / determinant, -q[1] / determinant, q[0] / determinant];
                let d = [next[0] - ahead[0], next[1] - ahead[1]];
                let v =
                    [inverse[0] * d[0] + inverse[1] * d[1], inverse[1] * d[0] + inverse[2] * d[1]];
                next = [
                    x[0] + a[0][0] * v[0] + a[0][1] * v[1],
                    x[1] + a[1][0] * v[0] + a[1][1] * v[1],
                ];
            } else {
                next = x;
            }
            (level[i], slope[i]) = (next[0], next[1]);
        }
        Smooth { level, slope }
    }
}

#[cfg(test)]
mod tests {
    use super::smooth;

    #[test]
    fn the_slope_of_a_quantised_sine_is_found() {
        let times: Vec<f64> = (0..3600).map(f64::from).collect();
        let omega = std::f64::consts::TAU / 1800.0;
        let values: Vec<f64> =
            times.iter().map(|t| (10.0 * (omega * t).sin() / 0.1).round() * 0.1).collect();
        let found = smooth(&times, &values);
        let worst = (100..3500)
            .map(|i| (found.slope[i] - 10.0 * omega * (omega * times[i]).cos()).abs())
            .fold(0.0, f64::max);
        assert!(worst < 0.12 * 10.0 * omega, "{worst}");
    }

    #[test]
    fn a_ramp_without_noise_and_with_a_gap_is_itself() {
        let times: Vec<f64> = (0..50).map(|i| f64::from(i) * 2.0).collect();
        let mut values: Vec<f64> = times.iter().map(|t| 3.0 + 0.25 * t).collect();
        values[20] = f64::NAN;
        let found = smooth(&times, &values);
        assert!((found.level[20] - 13.0).abs() < 1e-4);
        assert!(found.slope.iter().all(|slope| (slope - 0.25).abs() < 1e-4));
    }
}
