//! The cost of monitoring: updates from frames with two signals each, into monitors of one formula.
//!
//! A full bus of 1 Mbit/s carries about 9,000 frames of eight bytes per second.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use temporal::{Formula, Monitor, NotFound, Signal, Signals};
use wire::time::{Span, Timestamp};

struct Letters;

impl Signals for Letters {
    fn find(&self, name: &str) -> Result<Signal, NotFound> {
        let index = ["a", "b", "c"].iter().position(|letter| *letter == name);
        let index = index.ok_or_else(|| NotFound::unknown(name, &["a", "b", "c"]))?;
        Ok(Signal { index, ..Signal::default() })
    }
}

const FORMULAS: [(&str, &str); 8] = [
    ("comparison", "a < 900"),
    ("response", "a > 500 -> within 100 ms: b < 300"),
    ("edge and response", "rises(a > 500) -> within 100 ms: b < 300"),
    ("settling", "rises(a > 500) -> within 100 ms: for 1 s: b < 900"),
    ("ten seconds", "for 10 s: a < 999"),
    ("past", "a > 500 -> once [0, 1 s]: b > 500"),
    ("until", "a < 900 until [0, 1 s] b > 500"),
    ("until later", "a < 900 until [100 ms, 10 s] b > 500"),
];

/// Frames, one per millisecond, with noise in both signals.
fn frames() -> Vec<[(usize, f64); 2]> {
    let mut state = 1u64;
    let mut next = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 % 1_000.0
    };
    (0..10_000).map(|_| [(0, next()), (1, next())]).collect()
}

fn updates(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("update");
    group.throughput(Throughput::Elements(1));
    let frames = frames();
    for (name, text) in FORMULAS {
        let formula = Formula::parse(text, &Letters).expect("the formula is right");
        let mut monitor = Monitor::new(formula);
        let (mut now, mut frame) = (Timestamp::ZERO, frames.iter().cycle());
        group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
            bencher.iter(|| {
                now += Span::from_millis(1);
                if let Some(values) = frame.next() {
                    monitor.update(now, black_box(values));
                }
            });
        });
    }
    let formula = Formula::parse("a > 500 -> within 100 ms: b < 300", &Letters);
    let mut monitor = Monitor::new(formula.expect("the formula is right"));
    let mut now = Timestamp::ZERO;
    group.bench_function("signals of other frames", |bencher| {
        bencher.iter(|| {
            now += Span::from_millis(1);
            monitor.update(now, black_box(&[(7, 1.0), (8, 2.0)]));
        });
    });
    group.finish();
    criterion.bench_function("read a formula", |bencher| {
        let text = "rises(a > 500) -> within 100 ms: (b < 300 and for 1 s: abs(a - b) < 900)";
        bencher.iter(|| Formula::parse(black_box(text), &Letters));
    });
}

criterion_group!(benches, updates);
criterion_main!(benches);
