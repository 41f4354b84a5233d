//! The clock: its resolution, and how late this machine wakes a process.

use super::Needs;
use super::finding::Finding;
use record::figures;
use rustix::time::{ClockId, clock_getres};
use serde::Serialize;
use std::fs;
use std::time::{Duration, Instant};

const SLEEPS: usize = 200;
/// Length of each: about the time between two bytes on a line of 9600 baud.
const SLEEP: Duration = Duration::from_millis(1);
const READINGS: u32 = 1_000;
/// A coarser clock is no high-resolution timer. Assumption: those have 1 ns.
const RESOLUTION_S_MAX: f64 = 1e-6;
/// Lateness that does not affect a run in real time. Assumption: a tenth of the 50 ms at which the controller polls its
/// base.
const LATE_S_MAX: f64 = 5e-3;

#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ClockFacts {
    pub source: Option<String>,
    /// Resolution of the monotonic clock, in seconds.
    pub resolution_s: f64,
    /// Time to read it, in seconds.
    pub reading_s: f64,
    /// Maximum lateness of a sleep of one millisecond, in seconds.
    pub late_max_s: f64,
    /// 99th percentile of that lateness, in seconds.
    pub late_p99_s: f64,
}

pub(super) fn judge(facts: &ClockFacts, needs: &Needs, findings: &mut Vec<Finding>) {
    let ClockFacts { resolution_s, reading_s, late_max_s, late_p99_s, .. } = *facts;
    let source = facts.source.as_deref().unwrap_or("unknown");
    let what = format!(
        "source {source}, resolution {}, {} a reading",
        seconds(resolution_s),
        seconds(reading_s)
    );
    findings.push(if resolution_s <= RESOLUTION_S_MAX {
        Finding::good("clock", what)
    } else {
        let mend = "# boot a kernel with CONFIG_HIGH_RES_TIMERS and without highres=off";
        Finding::gap("clock", what, mend, None)
    });
    let what = format!(
        "a sleep of 1 ms is late by {} (99 in 100), {} at most",
        seconds(late_p99_s),
        seconds(late_max_s)
    );
    let calm =
        "# close what else is running, or run with priority:\nsudo chrt --fifo 50 hil run ...";
    findings.push(match &needs.late_max {
        Some((allowed, by)) if late_max_s > allowed.as_secs_f64() => {
            let what = format!("{what}; {} are allowed", seconds(allowed.as_secs_f64()));
            let mend = format!("{calm}\n# or raise late_ms_max in [timing]");
            Finding::gap("timing", what, mend, Some(by.clone()))
        }
        _ if late_p99_s > LATE_S_MAX => Finding::gap("timing", what, calm, None),
        _ => Finding::good("timing", what),
    });
}

fn seconds(value: f64) -> String {
    let (value, unit) = match value {
        small if small < 1e-6 => (value * 1e9, "ns"),
        small if small < 1e-3 => (value * 1e6, "us"),
        _ => (value * 1e3, "ms"),
    };
    figures::quantity((value * 10.0).round() / 10.0, 0.0, unit)
}

/// Reads the clock and sleeps, for a quarter of a second altogether.
#[expect(clippy::disallowed_methods, reason = "the clock itself is what is looked at")]
pub(super) fn gather() -> ClockFacts {
    let began = Instant::now();
    for _ in 0..READINGS {
        std::hint::black_box(Instant::now());
    }
    let reading_s = began.elapsed().as_secs_f64() / f64::from(READINGS);
    let mut late: Vec<f64> = (0..SLEEPS)
        .map(|_| {
            let began = Instant::now();
            std::thread::sleep(SLEEP);
            began.elapsed().saturating_sub(SLEEP).as_secs_f64()
        })
        .collect();
    late.sort_by(f64::total_cmp);
    let resolution = clock_getres(ClockId::Monotonic);
    let source = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
    ClockFacts {
        source: fs::read_to_string(source).ok().map(|name| name.trim().to_owned()),
        resolution_s: resolution.tv_sec as f64 + resolution.tv_nsec as f64 * 1e-9,
        reading_s,
        late_max_s: late.last().copied().unwrap_or_default(),
        late_p99_s: late.get(SLEEPS * 99 / 100 - 1).copied().unwrap_or_default(),
    }
}
