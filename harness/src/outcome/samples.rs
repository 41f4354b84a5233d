//! A summary for tests, with a measurement of each verdict.

use super::{Measurement, Outcome, Summary, Verdict};

pub(crate) fn measurement(name: &str, value: f64, verdict: Verdict) -> Measurement {
    Measurement {
        name: name.into(),
        value: Some(value),
        unit: "deg".into(),
        lower: Some(-1.0),
        upper: Some(1.0),
        verdict,
        paper: Some("all within ±1.0 deg (4.1, Fig. 5)".into()),
        statistic: "worst of 80".into(),
        uncertainty: 0.2,
        observations: 80,
    }
}

/// A run of laps that failed.
pub(crate) fn summary() -> Summary {
    Summary {
        outcome: Outcome::Failed,
        reason: Some("2 of 5 measurements failed".into()),
        plan: "laps-observed".into(),
        title: "Laps on the square, gyro only observing".into(),
        version: "0.1.0".into(),
        seed: 7,
        clock: "virtual".into(),
        bus: "memory".into(),
        device_under_test: "in-process".into(),
        simulated_s: 57_600.0,
        wall_s: 12.34,
        events: 34_567_890,
        measurements: vec![
            measurement("return_orientation_ccw", 0.314_159, Verdict::Pass),
            measurement("return_orientation_cw", -0.81, Verdict::Marginal),
            measurement("stop_error", 1.25, Verdict::Fail),
            Measurement {
                value: None,
                observations: 0,
                paper: None,
                statistic: "share inside".into(),
                unit: "%".into(),
                lower: Some(90.0),
                upper: None,
                uncertainty: 0.0,
                ..measurement("share_within_one_degree", 0.0, Verdict::Unset)
            },
            Measurement {
                unit: "deg/K".into(),
                lower: Some(-0.6),
                upper: Some(-0.44),
                paper: Some("-0.52 (Eq. 5)".into()),
                statistic: "slope of 300 points".into(),
                uncertainty: 0.004,
                observations: 300,
                ..measurement("slope", -0.521_23, Verdict::Pass)
            },
        ],
        artifacts: vec!["calibration.toml".into()],
        timing: None,
        ports: Vec::new(),
        faults: Vec::new(),
        properties: Vec::new(),
    }
}
