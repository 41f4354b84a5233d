//! Past values of the signals, kept while a moment's truth is open.

use std::collections::VecDeque;

/// The values of the signals at moments in order; each holds until the next.
#[derive(Debug, Clone)]
pub(crate) struct History {
    width: usize,
    times: VecDeque<i64>,
    /// `width` values for each time.
    values: VecDeque<f64>,
}

impl History {
    pub(crate) fn new(width: usize) -> Self {
        Self { width, times: VecDeque::new(), values: VecDeque::new() }
    }

    pub(crate) fn push(&mut self, at: i64, values: &[f64]) {
        let last = self.values.len().saturating_sub(self.width);
        let bits = |value: &f64| value.to_bits();
        let is_same = self.values.range(last..).map(bits).eq(values.iter().map(bits));
        if is_same && !self.times.is_empty() {
            return;
        }
        self.times.push_back(at);
        self.values.extend(values);
    }

    /// Drops what is only needed for moments before `at`.
    pub(crate) fn forget_before(&mut self, at: i64) {
        while self.times.get(1).is_some_and(|next| *next <= at) {
            self.times.pop_front();
            self.values.drain(..self.width);
        }
    }

    /// The values at `at`, in slot order.
    pub(crate) fn at(&self, at: i64) -> impl Iterator<Item = f64> {
        let found = self.times.partition_point(|time| *time <= at).saturating_sub(1);
        self.values.iter().skip(found * self.width).take(self.width).copied()
    }
}
