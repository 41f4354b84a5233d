//! A summary for tests, with a measurement of each verdict.

use super::{Measurement, Outcome, PropertySummary, Summary, Verdict};

/// One measurement.
pub fn measurement(name: &str, value: f64, verdict: Verdict) -> Measurement {
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
        proves: Some(plan::Proves::TestsTheController),
    }
}

/// One property per result.
pub fn properties() -> Vec<PropertySummary> {
    let of = |name: &str, always, held| PropertySummary {
        name: name.into(),
        always,
        held,
        not_judged: None,
        margin: None,
        never_asked: None,
        broken_s: None,
        what: None,
    };
    vec![
        PropertySummary { margin: Some(0.25), ..of("fresh_heading", true, Some(true)) },
        of("pose_written_at_rest", true, Some(true)),
        PropertySummary {
            margin: Some(-0.5),
            broken_s: Some(12.5),
            what: Some("moves 1.20 s after the gyro was last heard".into()),
            ..of("stops_on_loss", true, Some(false))
        },
        PropertySummary {
            not_judged: Some("the base is real".into()),
            ..of("done_is_done", true, None)
        },
        PropertySummary {
            margin: Some(0.0),
            never_asked: Some("rises(tester.Charge == 3)".into()),
            ..of("closes when asked", true, Some(true))
        },
        of("gyro_silent", false, Some(true)),
        PropertySummary { what: Some("never reached".into()), ..of("bus_off", false, Some(false)) },
    ]
}

/// A lap run that failed.
pub fn summary() -> Summary {
    Summary {
        outcome: Outcome::Failed,
        reason: Some("2 of 5 measurements failed".into()),
        plan: "laps-observed".into(),
        title: "Laps on the square, gyro only observing".into(),
        version: "0.1.0".into(),
        seed: 7,
        bench: None,
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
        commands: Vec::new(),
        faults: Vec::new(),
        properties: Vec::new(),
        notes: Vec::new(),
    }
}
