//! The page as a whole.

use super::render;
use crate::outcome::samples::summary;
use crate::outcome::{Outcome, Summary, Verdict};
use crate::record::header::{Band, Header, Quantity};
use crate::record::reader::RecordError;
use crate::record::samples::{observation, one_of_each, record, state};
use crate::record::{Device, Record, RecordKind};
use controller::mission::Report;
use scraper::{Html, Selector};
use std::collections::BTreeMap;
use wire::units::{Angle, Length, Pose};

/// What a report may take.
const BYTES_MAX: usize = 5_000_000;

fn header() -> Header {
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
    };
    Header {
        harness: "0.1.0".into(),
        plan: "laps-observed".into(),
        seed: 7,
        quantities: vec![
            quantity(
                "table.error",
                "deg",
                "Error of a full turn",
                vec![band(-1.0), band(1.0)],
            ),
            quantity(
                "gyro.temperature",
                "degC",
                "Temperature of the gyro",
                Vec::new(),
            ),
            quantity("lap.return_x", "m", "Return position", Vec::new()),
        ],
    }
}

/// A number between -1 and 1 that looks like chance and is not.
fn noise(index: u32) -> f64 {
    f64::from(index.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 23) - 1.0
}

fn truth(x: f64, y: f64) -> RecordKind {
    let pose = Pose {
        x: Length::from_m(x),
        y: Length::from_m(y),
        heading: Angle::ZERO,
    };
    RecordKind::Truth {
        pose,
        bias_rad_per_s: 0.0,
        coil_celsius: 20.0,
    }
}

/// Sixteen hours: table runs over temperature, laps with their return, a log, paths and steps.
fn long_run() -> impl Iterator<Item = Record> {
    const RUNS: u32 = 40;
    (0..RUNS).flat_map(|run| {
        let begin = f64::from(run) * 1_440.0;
        let (id, run_tag) = (format!("steps[0].repeat[{run}]"), f64::from(run));
        let mut all = vec![record(
            begin,
            Device::Plan,
            RecordKind::StepBegan {
                path: id.clone(),
                title: format!("run {run}"),
            },
        )];
        for second in 0..1_440 {
            let warm = 40.0 - 18.0 * (-(begin + f64::from(second)) / 4_000.0).exp();
            let kind = observation(
                "gyro.temperature",
                warm + 0.02 * noise(run * 1_440 + second),
                &[],
            );
            all.push(record(begin + f64::from(second), Device::Gyro, kind));
        }
        for direction in [1.0, -1.0] {
            let temperature = 40.0 - 18.0 * (-begin / 4_000.0).exp();
            let tags = [
                ("direction", direction),
                ("run", run_tag),
                ("temperature", temperature),
            ];
            let chance = |salt: u32| noise(run * 17 + salt + direction as u32);
            let at = begin + 200.0 + 100.0 * direction;
            let mut observe = |quantity: &str, value: f64| {
                all.push(record(
                    at,
                    Device::Absolute,
                    observation(quantity, value, &tags),
                ));
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
        all.push(record(
            begin + 500.0,
            Device::Plan,
            RecordKind::StepEnded { path: id },
        ));
        all
    })
}

fn page(summary: &Summary, records: impl IntoIterator<Item = Record>) -> String {
    render(summary, &header(), records.into_iter().map(Ok))
}

/// Parses without complaint, and asks nobody for anything.
fn assert_stands_alone(page: &str) -> Html {
    let document = Html::parse_document(page);
    assert!(document.errors.is_empty(), "{:?}", document.errors);
    for word in ["http://", "https://", "<script", "@import", "url(", "src="] {
        assert!(!page.contains(word), "{word}");
    }
    assert!(page.len() < BYTES_MAX, "{} bytes", page.len());
    document
}

fn count(document: &Html, selector: &str) -> usize {
    document.select(&Selector::parse(selector).unwrap()).count()
}

/// The page without its style and without the inside of its drawings.
fn skeleton(page: &str) -> String {
    let mut text = String::new();
    for part in page.split_inclusive('>') {
        text += part;
        text.push('\n');
    }
    let mut hidden = None;
    let mut kept = String::new();
    for line in text.lines() {
        for tag in ["style", "svg"] {
            if line.starts_with(&format!("<{tag}")) {
                kept += &format!("<{tag} …>\n");
                hidden = Some(format!("</{tag}>"));
            }
        }
        match &hidden {
            Some(end) if line.ends_with(end.as_str()) => hidden = None,
            Some(_) => {}
            None => kept += &format!("{line}\n"),
        }
    }
    kept
}

#[test]
fn sixteen_hours_fit_one_page() {
    let page = page(&summary(), long_run());
    let document = assert_stands_alone(&page);
    assert_eq!(count(&document, "section"), 5);
    assert_eq!(
        count(&document, "table.measurements tbody tr"),
        summary().measurements.len()
    );
    assert_eq!(
        count(&document, "svg.plot"),
        5,
        "four quantities, two of them in one plot, and the path"
    );
    assert_eq!(count(&document, "g.step"), 40);
    assert!(
        page.contains("57600 observations; "),
        "a thinned log says so"
    );
    assert!(page.contains("table.error in deg") && page.contains("temperature in degC"));
}

#[test]
fn the_skeleton_of_a_small_run() {
    insta::assert_snapshot!(skeleton(&page(&summary(), one_of_each())));
}

#[test]
fn an_empty_run_is_a_page_too() {
    let nothing = Summary {
        outcome: Outcome::Error,
        reason: None,
        measurements: Vec::new(),
        artifacts: Vec::new(),
        ..summary()
    };
    let page = render(&nothing, &Header::default(), []);
    let document = assert_stands_alone(&page);
    assert!(page.contains("Nothing was observed."));
    assert!(page.contains("No reason was given."));
    assert_eq!(count(&document, "section"), 2);
}

#[test]
fn a_record_cut_short_is_drawn_as_far_as_it_goes() {
    let records = one_of_each().into_iter().take(14).map(Ok);
    let cut = Err(RecordError::CutShort {
        offset: 4_711,
        trailing: 5,
    });
    let page = render(&summary(), &header(), records.chain([cut]));
    let document = assert_stands_alone(&page);
    assert!(page.contains("5 bytes of an incomplete record at byte 4711"));
    assert!(page.contains("The step that had not ended: turn by 90 deg."));
    assert_eq!(count(&document, "g.step.unfinished"), 1);
}

#[test]
fn text_from_outside_is_text() {
    let evil = "<img src=x onerror=alert(1)>\"'&";
    let mut hostile = summary();
    for text in [
        &mut hostile.title,
        &mut hostile.plan,
        &mut hostile.clock,
        &mut hostile.version,
    ] {
        *text = evil.into();
    }
    hostile.reason = Some(evil.into());
    hostile.artifacts = vec![evil.into()];
    let first = &mut hostile.measurements[2];
    (first.name, first.unit, first.statistic) = (evil.into(), evil.into(), evil.into());
    first.paper = Some(evil.into());
    let (path, title) = (evil.to_owned(), evil.to_owned());
    let records = [
        record(0.0, Device::Plan, RecordKind::StepBegan { path, title }),
        record(1.0, Device::Base, RecordKind::Note(evil.into())),
        record(2.0, Device::Base, observation(evil, 1.0, &[])),
    ];
    let band = Band {
        measurement: evil.into(),
        paper: Some(evil.into()),
        ..Band::default()
    };
    let quantity = Quantity {
        name: evil.into(),
        unit: evil.into(),
        title: evil.into(),
        bands: vec![Band {
            upper: Some(0.0),
            ..band
        }],
    };
    let header = Header {
        quantities: vec![quantity],
        ..Header::default()
    };
    let page = render(&hostile, &header, records.into_iter().map(Ok));
    let document = Html::parse_document(&page);
    assert!(document.errors.is_empty(), "{:?}", document.errors);
    assert_eq!(count(&document, "img"), 0);
    assert!(!page.contains("<img"));
    assert_eq!(count(&document, "figure"), 2);
}

#[test]
fn wild_values_are_counted_and_not_drawn() {
    let values = [f64::NAN, f64::INFINITY, 1e300, 0.5];
    let records = values.map(|value| record(1.0, Device::Gyro, observation("odd", value, &[])));
    let page = page(&summary(), records);
    assert_stands_alone(&page);
    assert!(page.contains("3 were no numbers."));
}

#[test]
fn too_many_quantities_are_counted() {
    let records = (0..400).map(|index| {
        record(
            1.0,
            Device::Gyro,
            observation(&format!("q{index:03}"), 0.5, &[]),
        )
    });
    let page = page(&summary(), records);
    assert_stands_alone(&page);
    assert!(page.contains("At most 40 plots are drawn"));
    assert!(page.contains("144 observations of yet more quantities were not kept."));
}

#[test]
fn every_quantity_at_full_rate_stays_below_the_bound() {
    let records = (0..60).flat_map(|quantity| {
        (0..3_000).map(move |index| {
            let direction = if index % 2 == 0 { 1.0 } else { -1.0 };
            let tags = [("direction", direction), ("run", f64::from(index))];
            let value = noise(index + 7_919 * quantity);
            record(
                f64::from(index),
                Device::Gyro,
                observation(&format!("q{quantity:02}"), value, &tags),
            )
        })
    });
    assert_stands_alone(&page(&summary(), records));
}

#[test]
fn a_verdict_has_its_colour_in_the_sheet() {
    let sheet = include_str!("style.css");
    for verdict in [
        Verdict::Pass,
        Verdict::Marginal,
        Verdict::Fail,
        Verdict::Unset,
    ] {
        assert!(sheet.contains(&format!("tr.{}", verdict.name())));
    }
}

/// Writes the page of the long run where `HIL_SAMPLE_REPORT` says, to be looked at.
#[test]
#[ignore = "for whoever changes the page"]
fn sample_report() {
    let path = std::env::var_os("HIL_SAMPLE_REPORT").expect("HIL_SAMPLE_REPORT names a file");
    let records = long_run().chain(one_of_each().into_iter().skip(6));
    std::fs::write(path, page(&summary(), records)).unwrap();
}
