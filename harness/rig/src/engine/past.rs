//! Smallest and largest value of a quantity over the time that has just passed.

use std::collections::VecDeque;
use wire::time::{Span, Timestamp};

/// Most values kept of each end. A value is kept only until a later one lies further out, so that even a fast signal needs few;
/// only one that rises or falls all the time needs each.
const KEPT_MAX: usize = 1_000_000;

/// The values that may still be the smallest or largest of a window, oldest first: the smallest of a window is the first in it.
/// (A monotonic queue: each value is put in and taken out once, however long the window is.)
#[derive(Debug, Clone, Default)]
pub(super) struct Past {
    span: Span,
    /// The values are known from here on.
    since: Option<Timestamp>,
    last: Option<(Timestamp, f64)>,
    lows: VecDeque<(Timestamp, f64)>,
    highs: VecDeque<(Timestamp, f64)>,
}

impl Past {
    /// Looks back as far as this, too.
    pub(super) fn reach(&mut self, span: Span) {
        self.span = self.span.max(span);
    }

    pub(super) fn add(&mut self, now: Timestamp, value: f64) {
        self.since.get_or_insert(now);
        let from = now - self.span;
        if let Some((last, kept)) = self.last.filter(|(last, _)| *last < from) {
            // A signal keeps its value until its next message: before a window without one, it had this.
            let until = (now - Span::from_nanos(1)).max(last);
            put(&mut self.lows, (until, kept), from, |lower| lower < kept);
            put(&mut self.highs, (until, kept), from, |higher| higher > kept);
        }
        self.last = Some((now, value));
        put(&mut self.lows, (now, value), from, |kept| kept < value);
        put(&mut self.highs, (now, value), from, |kept| kept > value);
        for queue in [&mut self.lows, &mut self.highs] {
            if queue.len() > KEPT_MAX {
                queue.pop_front();
                self.since = queue.front().map(|(at, _)| *at);
            }
        }
    }

    /// Forgets the values: the windows begin anew.
    pub(super) fn forget(&mut self) {
        *self = Self { span: self.span, ..Self::default() };
    }

    /// Smallest and largest value of the last `span`, or `None` if the values are not known for so long.
    pub(super) fn range(&self, span: Span) -> Option<(f64, f64)> {
        let from = self.last?.0 - span;
        if self.since? > from {
            return None;
        }
        let first = |queue: &VecDeque<(Timestamp, f64)>| {
            let place = queue.partition_point(|(at, _)| *at < from);
            queue.get(place).map(|(_, value)| *value)
        };
        Some((first(&self.lows)?, first(&self.highs)?))
    }
}

/// Puts a value behind those that lie further out, and takes out those from before `from`.
fn put(
    queue: &mut VecDeque<(Timestamp, f64)>,
    new: (Timestamp, f64),
    from: Timestamp,
    is_further: impl Fn(f64) -> bool,
) {
    while queue.back().is_some_and(|(_, kept)| !is_further(*kept)) {
        queue.pop_back();
    }
    queue.push_back(new);
    while queue.front().is_some_and(|(at, _)| *at < from) {
        queue.pop_front();
    }
}

#[cfg(test)]
mod tests {
    use super::{KEPT_MAX, Past, Span, Timestamp};
    use proptest::prelude::*;

    fn at(ms: i64) -> Timestamp {
        Timestamp::ZERO + Span::from_millis(ms)
    }

    #[test]
    fn a_window_is_known_once_something_is_as_old() {
        let mut past = Past::default();
        past.reach(Span::from_secs(2));
        past.add(at(0), 5.0);
        past.add(at(1_000), 1.0);
        assert_eq!(past.range(Span::from_secs(2)), None);
        assert_eq!(past.range(Span::ZERO), Some((1.0, 1.0)));
        past.add(at(2_500), 3.0);
        assert_eq!(past.range(Span::from_secs(2)), Some((1.0, 3.0)));
        past.forget();
        past.add(at(3_500), 2.0);
        assert_eq!(past.range(Span::from_secs(2)), None);
    }

    /// Found by a user: after five seconds without power, the first value alone was called steady for half a second.
    #[test]
    fn a_silence_is_as_steady_as_the_value_before_it() {
        let mut past = Past::default();
        past.reach(Span::from_millis(500));
        for ms in [0, 500, 1_000] {
            past.add(at(ms), 300.0);
        }
        past.add(at(6_050), 0.0);
        assert_eq!(past.range(Span::from_millis(500)), Some((0.0, 300.0)));
        assert_eq!(past.range(Span::ZERO), Some((0.0, 0.0)));
        past.add(at(6_300), 1.0);
        assert_eq!(past.range(Span::from_millis(500)), Some((0.0, 300.0)));
        past.add(at(6_600), 1.0);
        assert_eq!(past.range(Span::from_millis(500)), Some((1.0, 1.0)));
    }

    /// A steady 1 kHz signal took a million values, and a window of more was never known.
    #[test]
    fn a_long_window_of_a_fast_signal_is_known_and_takes_little() {
        let mut past = Past::default();
        past.reach(Span::from_secs(1_200));
        for ms in 0..=1_200_000 {
            past.add(at(ms), if ms % 2 == 0 { 1.0 } else { 2.0 });
            assert!(past.lows.len() + past.highs.len() <= 4);
        }
        assert_eq!(past.range(Span::from_secs(1_200)), Some((1.0, 2.0)));
    }

    #[test]
    fn a_ramp_is_bounded_and_what_is_forgotten_is_not_known() {
        let mut past = Past::default();
        past.reach(Span::from_secs(1_200));
        (0..=1_200_000).for_each(|ms| past.add(at(ms), ms as f64));
        assert_eq!(past.lows.len(), KEPT_MAX);
        assert_eq!(past.range(Span::from_secs(1_200)), None);
        assert_eq!(past.range(Span::from_secs(1)), Some((1_199_000.0, 1_200_000.0)));
    }

    proptest! {
        /// As somebody finds it who keeps all values.
        #[test]
        fn any_window_has_the_ends_of_its_values(
            steps in prop::collection::vec((0i64..500, -5i8..5), 1..100),
            spans in prop::collection::vec(0i64..4_000, 1..4),
        ) {
            let mut past = Past::default();
            spans.iter().for_each(|&ms| past.reach(Span::from_millis(ms)));
            let longest = spans.iter().max().copied().unwrap_or_default();
            let (mut now, mut all) = (0, Vec::new());
            for (passed, value) in steps {
                now += passed;
                let value = f64::from(value);
                past.add(at(now), value);
                // What was there before a longer silence was there until just now.
                if let Some((_, kept, _)) = all.last().filter(|_| passed > longest).copied() {
                    all.push((now, kept, true));
                }
                all.push((now, value, false));
                for &span in &spans {
                    let is_inside = |until: i64, is_kept: bool| {
                        if is_kept { until + span > now } else { until + span >= now }
                    };
                    let inside = all.iter().filter(|(until, _, kept)| is_inside(*until, *kept));
                    let inside = inside.map(|(_, value, _)| *value);
                    let expected = (all[0].0 + span <= now).then(|| {
                        inside.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                            (low.min(value), high.max(value))
                        })
                    });
                    prop_assert_eq!(past.range(Span::from_millis(span)), expected);
                }
            }
        }
    }
}
