//! A long run for tests.

use controller::mission::Report;
use record::header::{Band, Header, Quantity};
use record::samples::{observation, record, state};
use record::{Device, Record, RecordKind};
use std::collections::BTreeMap;
use wire::units::{Angle, Length, Pose};

pub(super) fn header() -> Header {
    let band = |direction: f64| Band {
        measurement: "table_error".into(),
        lower: Some(-0.25),
        upper: Some(0.25),
        paper: Some("all within ±0.25 deg (Fig. 6)".into()),
        tags: BTreeMap::from([("direction".to_owned(), direction)]),
    };
    let quantity = |name: &str, unit: &str, title: &str, bands: Vec<Band>| Quantity {
        name: name.into(),
        unit: unit.into(),
        title: title.into(),
        bands,
        ..Quantity::default()
    };
    Header {
        harness: "0.1.0".into(),
        plan: "laps-observed".into(),
        seed: 7,
        quantities: vec![
            quantity("table.error", "deg", "Error of a full turn", vec![band(-1.0), band(1.0)]),
            quantity("gyro.temperature", "degC", "Temperature of the gyro", Vec::new()),
            quantity("lap.return_x", "m", "Return position", Vec::new()),
        ],
        ..Header::default()
    }
}

/// Returns a deterministic number between -1 and 1 that looks random.
pub(super) fn noise(index: u32) -> f64 {
    let mixed = (index ^ 0x9e37_79b9).wrapping_mul(0x85eb_ca6b);
    let mixed = (mixed ^ (mixed >> 13)).wrapping_mul(0xc2b2_ae35);
    f64::from((mixed ^ (mixed >> 16)) >> 8) / f64::from(1 << 23) - 1.0
}

fn truth(x: f64, y: f64) -> RecordKind {
    let pose = Pose { x: Length::from_m(x), y: Length::from_m(y), heading: Angle::ZERO };
    RecordKind::Truth { pose, bias_rad_per_s: 0.0, coil_celsius: 20.0 }
}

/// Sixteen hours: table runs over temperature, laps with their return, a log, paths and steps.
pub(super) fn long_run() -> impl Iterator<Item = Record> {
    const RUNS: u32 = 40;
    (0..RUNS).flat_map(|run| {
        let begin = f64::from(run) * 1_440.0;
        let run_tag = f64::from(run);
        let mut all = Vec::new();
        let step = |at_s: f64, inner: &str, title: Option<&str>| {
            let path = format!("steps[0].repeat[{run}]{inner}");
            let kind = match title {
                Some(title) => RecordKind::StepBegan { path, title: title.to_owned() },
                None => RecordKind::StepEnded { path },
            };
            record(begin + at_s, Device::Plan, kind)
        };
        all.push(step(0.0, "", Some(&format!("run {run}"))));
        for (inner, title, from_s, to_s) in [
            (".steps[0]", "static bias test", 0.0, 20.0),
            (".steps[1]", "lap cw", 100.0, 164.0),
            (".steps[2]", "lap ccw", 300.0, 364.0),
        ] {
            all.push(step(from_s, inner, Some(title)));
            all.push(step(to_s, inner, None));
        }
        for second in 0..1_440 {
            let warm = 40.0 - 18.0 * (-(begin + f64::from(second)) / 4_000.0).exp();
            let kind =
                observation("gyro.temperature", warm + 0.02 * noise(run * 1_440 + second), &[]);
            all.push(record(begin + f64::from(second), Device::Gyro, kind));
        }
        for direction in [1.0, -1.0] {
            let temperature = 40.0 - 18.0 * (-begin / 4_000.0).exp();
            let tags = [("direction", direction), ("run", run_tag), ("temperature", temperature)];
            let chance = |salt: u32| noise(run * 17 + salt + direction as u32);
            let at = begin + 200.0 + 100.0 * direction;
            let mut observe = |quantity: &str, value: f64| {
                all.push(record(at, Device::Absolute, observation(quantity, value, &tags)));
            };
            observe("table.error", 0.22 * chance(1));
            observe("lap.gyro_error", 1.1 * chance(2));
            observe("lap.return_x", 0.03 * chance(3) + 0.01 * direction);
            observe("lap.return_y", 0.055 * chance(4));
            for step in 0..640 {
                let along = f64::from(step) / 40.0;
                let (side, rest) = (along.div_euclid(4.0), along.rem_euclid(4.0));
                let (x, y) = match side as u8 {
                    0 => (rest, 0.0),
                    1 => (4.0, rest),
                    2 => (4.0 - rest, 4.0),
                    _ => (0.0, 4.0 - rest),
                };
                let drift = 0.03 * chance(5) * along / 16.0;
                let (x, y) = if direction > 0.0 { (x, y) } else { (y, x) };
                let at = at + f64::from(step) * 0.1;
                all.push(record(at, Device::Base, truth(x + drift, y - drift)));
                let state = RecordKind::Report(Report::State(state(x, y)));
                all.push(record(at, Device::Controller, state));
            }
        }
        all.push(step(1_430.0, "", None));
        all
    })
}
