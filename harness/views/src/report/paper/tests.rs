//! Which figures a record gets.

use super::Figures;
use crate::report::collect::Collected;
use controller::calibration::{Calibration, Factor};
use controller::mission::{Command, HeadingSource};
use record::header::Header;
use record::samples::{observation, record};
use record::{Device, Record, RecordKind};
use scraper::{Html, Selector};

fn told(command: Command) -> Record {
    record(0.0, Device::Plan, RecordKind::Command(Box::new(command)))
}

fn corrected() -> Record {
    let line = Factor::TemperatureLine { slope_deg_per_celsius: -0.52, intercept_deg: 19.23 };
    told(Command::SetCalibration(Calibration {
        factors: [line].into_iter().collect(),
        ..Calibration::default()
    }))
}

/// Two turns of the table, or the ends of two laps: one in each direction.
fn observed(quantity: &str, values: [f64; 2], extra: &[(&str, f64)]) -> Vec<Record> {
    let one = |(index, value): (usize, f64)| {
        let run = index as f64 + 1.0;
        let common = [("run", run), ("direction", 1.5 - run), ("temperature", 20.0 + 10.0 * run)];
        let tags: Vec<_> = common.iter().chain(extra).copied().collect();
        record(run, Device::Plan, observation(quantity, value, &tags))
    };
    values.into_iter().enumerate().map(one).collect()
}

fn page(records: Vec<Record>) -> (Vec<String>, Html) {
    let collected = Collected::of(&Header::default(), records.into_iter().map(Ok));
    let figures = Figures::of(&Header::default(), &collected);
    let text = figures.plots().map(maud::Markup::into_string).unwrap_or_default();
    let page = Html::parse_fragment(&text);
    let titles = Selector::parse("h3").unwrap();
    let of = |title: String| title.split(" of the paper").next().unwrap_or_default().to_owned();
    (page.select(&titles).map(|title| of(title.text().collect())).collect(), page)
}

#[test]
fn the_error_of_a_turn_is_fig_3_before_and_fig_6_after_its_correction() {
    let turn = observed("table.error", [3.6, -1.5], &[("angle", 360.0)]);
    let (before, _) = page(turn.clone());
    assert_eq!(before, ["As Fig. 3", "As Fig. 3"]);
    let after = [vec![corrected()], turn.clone()].concat();
    assert_eq!(page(after.clone()).0, ["As Fig. 6"]);
    let both = [turn, after].concat();
    assert_eq!(page(both).0, ["As Fig. 3", "As Fig. 3", "As Fig. 6"]);
    let quarter = observed("table.error", [3.6, -1.5], &[("angle", 90.0)]);
    assert!(page(quarter).0.is_empty(), "the paper has none of a quarter of a turn");
}

#[test]
fn what_closes_the_loops_tells_figs_7_and_8_from_fig_9() {
    let lap = || {
        [
            ("lap.return_x", [0.01, -0.02]),
            ("lap.return_y", [0.03, 0.2]),
            ("lap.return_heading", [0.5, -0.4]),
        ]
        .into_iter()
        .flat_map(|(quantity, values)| observed(quantity, values, &[]))
        .chain(observed("lap.gyro_error", [0.1, 0.2], &[]))
        .collect::<Vec<_>>()
    };
    let (by_gyro, document) = page(lap());
    assert_eq!(by_gyro, ["As Fig. 7", "As Fig. 8"]);
    let text: String = document.root_element().text().collect();
    assert!(text.contains("1 outside") && text.contains("within ±1.2 deg (Fig. 7)"), "{text}");
    assert!(text.contains("median ccw 1.0, 3.0 cm"), "{text}");
    let odometry = told(Command::SetHeadingSource(HeadingSource::Odometry));
    let (by_odometry, _) = page([vec![odometry], lap()].concat());
    assert_eq!(by_odometry, ["As Fig. 5", "Beside Fig. 9", "As Fig. 9"]);
}

#[test]
fn every_figure_says_what_the_paper_gives_and_has_its_data() {
    let all = [
        observed("gyro.rate", [0.01, 0.02], &[]),
        observed("gyro.temperature", [20.0, 30.0], &[]),
        observed("bias.residual_test", [0.001, -0.002], &[]),
        observed("bias.residual_none", [0.01, 0.012], &[]),
        observed("table.error", [3.6, -1.5], &[]),
    ];
    let (titles, document) = page(all.concat());
    let of_2 = ["As Fig. 2", "As Fig. 2"];
    assert_eq!(titles, [&of_2[..], &["As section 2"], &["As Fig. 3"; 2]].concat());
    let count = |selector: &str| document.select(&Selector::parse(selector).unwrap()).count();
    assert_eq!(count("a.data"), titles.len());
    // A log of two seconds does not reach two hours.
    assert_eq!(count("i.line.paper"), titles.len() - of_2.len());
}
