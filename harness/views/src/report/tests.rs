//! The page as a whole.

use super::render;
use super::samples::{header, long_run, noise};
use controller::mission::Report;
use record::header::{Band, Header, Quantity};
use record::outcome::samples::summary;
use record::outcome::{Outcome, Summary, Verdict};
use record::reader::RecordError;
use record::samples::{observation, one_of_each, record, state};
use record::{Device, Record, RecordKind};
use scraper::{Html, Selector};

/// Maximum size of a report.
const BYTES_MAX: usize = 5_000_000;

fn page(summary: &Summary, records: impl IntoIterator<Item = Record>) -> String {
    render(summary, &header(), records.into_iter().map(Ok))
}

/// Checks that the page parses without errors and requests nothing.
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

/// Returns the page without its style and the contents of its drawings.
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
    assert_eq!(count(&document, "section"), 7);
    assert_eq!(count(&document, "table.measurements tbody tr"), summary().measurements.len());
    assert_eq!(
        count(&document, "svg.plot"),
        6,
        "Fig. 3 and what is left beside its line, Fig. 8, two quantities of no figure of the paper, and the path"
    );
    assert_eq!(count(&document, "g.step"), 120);
    assert!(page.contains("160 steps; 40 of them are too short to be drawn"));
    assert!(page.contains("57600 observations; "), "a thinned log says so");
    assert!(page.contains("error of one turn in deg") && page.contains("temperature in degC"));
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
    assert_eq!(count(&document, "section"), 2, "observations and the load of the bus");
}

/// The last period of a recording is shorter than the others: its next message did not come any more.
#[test]
fn what_was_open_at_the_end_is_outside_only_beyond_the_upper_limit() {
    let band = Band { lower: Some(0.09), upper: Some(0.11), ..Band::default() };
    let (name, title) = ("period.Status".to_owned(), "Time between messages".to_owned());
    let quantity = Quantity { name, title, bands: vec![band], ..Quantity::default() };
    let header = Header { quantities: vec![quantity], ..Header::default() };
    let page = |open_s: f64| {
        let gap = |at_s: f64, value: f64, tags: &[(&str, f64)]| {
            record(at_s, Device::Device, observation("period.Status", value, tags))
        };
        let records = [gap(0.1, 0.1, &[]), gap(0.13, open_s, &[("open", 1.0)])];
        render(&summary(), &header, records.map(Ok))
    };
    assert!(!page(0.03).contains(" outside"), "{}", page(0.03));
    assert!(page(0.3).contains("1 outside"), "{}", page(0.3));
}

#[test]
fn a_record_cut_short_is_drawn_as_far_as_it_goes() {
    let records = one_of_each().into_iter().take(14).map(Ok);
    let cut = Err(RecordError::CutShort { offset: 4_711, trailing: 5 });
    let page = render(&summary(), &header(), records.chain([cut]));
    let document = assert_stands_alone(&page);
    assert!(page.contains("5 bytes of an incomplete record at byte 4711"));
    assert!(page.contains("The step that had not ended: turn by 90 deg."));
    assert_eq!(count(&document, "g.step.unfinished"), 1);
}

/// Such values result from a flipped bit in a record, or from a division by zero in a controller.
#[test]
fn places_at_the_end_of_the_numbers_are_counted_and_not_drawn() {
    let places =
        [(1.7e308, 0.0), (0.0, -1.7e308), (f64::MAX, f64::MIN), (1e13, 0.0), (f64::NAN, 1.0)];
    let drive = (0..100).map(|step| (f64::from(step) * 0.1, 0.0));
    let records = drive.chain(places).enumerate().map(|(index, (x, y))| {
        let state = RecordKind::Report(Report::State(state(x, y)));
        record(index as f64, Device::Controller, state)
    });
    let page = page(&summary(), records);
    let document = assert_stands_alone(&page);
    assert_eq!(count(&document, "svg.plot"), 1);
    assert!(page.contains("5 places are infinite or further than any bench, and not drawn."));
}

#[test]
fn text_from_outside_is_text() {
    let evil = "<img src=x onerror=alert(1)>\"'&";
    let mut hostile = summary();
    for text in [&mut hostile.title, &mut hostile.plan, &mut hostile.clock, &mut hostile.version] {
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
    let band = Band { measurement: evil.into(), paper: Some(evil.into()), ..Band::default() };
    let quantity = Quantity {
        name: evil.into(),
        unit: evil.into(),
        title: evil.into(),
        bands: vec![Band { upper: Some(0.0), ..band }],
        ..Quantity::default()
    };
    let header = Header { quantities: vec![quantity], ..Header::default() };
    let page = render(&hostile, &header, records.into_iter().map(Ok));
    let document = Html::parse_document(&page);
    assert!(document.errors.is_empty(), "{:?}", document.errors);
    assert_eq!(count(&document, "img"), 0);
    assert!(!page.contains("<img"));
    assert_eq!(count(&document, "figure"), 3, "the failure, its quantity, and the time line");
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
    let records = (0..400)
        .map(|index| record(1.0, Device::Gyro, observation(&format!("q{index:03}"), 0.5, &[])));
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
    for verdict in [Verdict::Pass, Verdict::Marginal, Verdict::Fail, Verdict::Unset] {
        assert!(sheet.contains(&format!("tr.{}", verdict.name())));
    }
}

/// Writes the page of the long run to the file in `HIL_SAMPLE_REPORT`, for inspection.
#[test]
#[ignore = "for whoever changes the page"]
fn sample_report() {
    let path = std::env::var_os("HIL_SAMPLE_REPORT").expect("HIL_SAMPLE_REPORT names a file");
    let records = long_run().chain(one_of_each().into_iter().skip(6));
    std::fs::write(path, page(&summary(), records)).unwrap();
}
