//! The page as a whole.

use super::samples::{block, diagnostics, effect, finding, model};
use super::{BLOCKS_MAX, page};
use identification::finding::{Compensation, Finding, HeldOut, Verdict};
use identification::model::Model;
use identification::outcome::{BlockDiagnostics, Diagnostics, RunError, Series};
use scraper::{Html, Selector};

/// Maximum size of a report.
const BYTES_MAX: usize = 5_000_000;

/// Checks that the page parses without errors, requests nothing, and shows no NaN or the like.
fn assert_stands_alone(page: &str) -> Html {
    let document = Html::parse_document(page);
    assert!(document.errors.is_empty(), "{:?}", document.errors);
    for word in
        ["http://", "https://", "<script", "@import", "url(", "src=", "NaN", "could not be drawn"]
    {
        assert!(!page.contains(word), "{word}");
    }
    assert!(page.len() < BYTES_MAX, "{} bytes", page.len());
    document
}

fn texts(document: &Html, selector: &str) -> Vec<String> {
    let selector = Selector::parse(selector).unwrap();
    document.select(&selector).map(|element| element.text().collect()).collect()
}

#[test]
fn the_error_of_a_plain_number_has_no_unit() {
    let held_out = HeldOut { before: 14.6, after: 0.49, ..finding().held_out };
    let one = |unit: &str| {
        let compensation = Compensation {
            of: "probe".into(),
            unit: unit.into(),
            inputs: Vec::new(),
            steps: Vec::new(),
            held_out: held_out.clone(),
            left_out: Vec::new(),
        };
        let finding = Finding { compensation: Some(compensation), ..finding() };
        page(&finding, &model(), &diagnostics(300))
    };
    assert!(one("1").contains("its error is 0.49 root mean square"));
    assert!(one("V").contains("its error is 0.49 V root mean square"));
}

#[test]
fn a_page_has_every_part() {
    let page = page(&finding(), &model(), &diagnostics(300));
    let document = assert_stands_alone(&page);
    assert_eq!(
        texts(&document, "h2"),
        [
            "From plain to rich",
            "What was found",
            "What is left",
            "What to do next",
            "Figures of gyro_angle",
            "The model",
            "The noise that remains"
        ]
    );
    assert_eq!(
        texts(&document, "figure h3"),
        [
            "Error of each model on runs that took no part",
            "Shupe effect",
            "Residual over time",
            "Residual over run",
            "Residual over temperature",
            "Residual over voltage",
            "Does the residual remember?",
            "How far does averaging help?",
            "Error of each run left out of the fit",
        ]
    );
    assert_eq!(texts(&document, "svg.plot").len(), 1 + 1 + 4 * 2 + 2 + 2);
    assert_eq!(texts(&document, "a.data").len(), 1 + 2 + 4 * 2 + 2 + 1);
    let change = &texts(&document, "p.change")[0];
    assert!(change.starts_with("error 0.2100 → 0.0600 deg (-71 %)"), "{change}");
    assert!(change.contains("0.0550 to 0.0660"), "{change}");
    assert_eq!(texts(&document, "table.model tbody tr").len(), 2);
    assert!(page.contains("next-experiment.toml") && page.contains("decided in 9 of 10 cases"));
    assert!(page.contains("10.0 % of the variance of what remains"));
}

#[test]
fn the_same_finding_gives_the_same_bytes() {
    let draw = || page(&finding(), &model(), &diagnostics(3_000));
    assert!(draw() == draw());
}

#[test]
fn the_data_of_a_figure_are_in_the_page() {
    let page = page(&finding(), &model(), &diagnostics(300));
    let document = Html::parse_document(&page);
    let selector = Selector::parse("a.data[download='gyro_angle-by-run.csv']").unwrap();
    let link = document.select(&selector).next().unwrap().attr("href").unwrap();
    assert!(
        link.starts_with(
            "data:text/csv;charset=utf-8,run,label,before%20in%20deg,after%20in%20deg%0A1,turn%201,"
        ),
        "{link}"
    );
    assert_eq!(link.matches("%0A").count(), 1 + 30, "a header and thirty runs");
}

/// A block with more channels and effects than are drawn.
fn busy(count: usize) -> BlockDiagnostics {
    let mut busy = block(count);
    busy.channels = (0..60)
        .map(|i| Series { name: format!("channel {i}"), ..busy.channels[0].clone() })
        .collect();
    busy.effects = vec![busy.effects[0].clone(); 64];
    busy
}

#[test]
fn two_days_at_full_rate_hide_no_outlier() {
    let mut long = block(576_000);
    long.after[123_456] = 9.0;
    let run_labels = (0..long.by_run.len()).map(|run| format!("run {run}")).collect();
    let page = page(&finding(), &model(), &Diagnostics { blocks: vec![long], run_labels });
    assert_stands_alone(&page);
    assert!(page.contains("576000 points, drawn as columns"), "a thinned figure says so");
    assert!(page.contains("in each plot at most 1<"), "an outlier is told of");
}

#[test]
fn any_number_of_figures_fits_one_page() {
    // The maximum number of individual marks, and the maximum number of columns.
    for (observations, blocks) in [(400, 1), (400, BLOCKS_MAX), (400, 3 * BLOCKS_MAX), (5_000, 1)] {
        let blocks = vec![busy(observations); blocks];
        let page = page(&finding(), &model(), &Diagnostics { blocks, run_labels: Vec::new() });
        assert_stands_alone(&page);
        assert!(page.contains(" more channels are not drawn"));
        assert!(page.contains(" weaker effects are not drawn"));
    }
}

#[test]
fn nothing_found_in_nothing_is_a_page_too() {
    let nothing = Finding {
        verdict: Verdict::NothingMissing,
        effects: Vec::new(),
        left: Vec::new(),
        compensation: None,
        compensation_also: Vec::new(),
        next_experiment: None,
        path: Vec::new(),
        ..finding()
    };
    let bare = Model { terms: Vec::new(), ..model() };
    let page = page(&nothing, &bare, &Diagnostics::default());
    let document = assert_stands_alone(&page);
    assert_eq!(texts(&document, "h2"), ["What was found", "What is left", "The model"]);
    assert!(page.contains("No effect was added") && page.contains("No cause that was tried shows"));
}

#[test]
fn numbers_that_are_none_are_left_out() {
    let broken = |mut values: Vec<f64>| {
        values[3] = f64::NAN;
        values[5] = f64::INFINITY;
        values
    };
    let mut odd = block(100);
    (odd.before, odd.after) = (broken(odd.before), broken(odd.after));
    odd.time = broken(odd.time);
    odd.autocorrelation.1[0] = f64::NAN;
    odd.allan[4].2 = 0.0;
    odd.by_run.push(RunError { run: 10, before: f64::NAN, after: 0.0 });
    odd.effects[0].observed[2].1 = f64::NAN;
    odd.channels[1].values = vec![3.0; 100];
    let empty = BlockDiagnostics {
        time: Vec::new(),
        run: Vec::new(),
        before: Vec::new(),
        after: Vec::new(),
        channels: Vec::new(),
        effects: Vec::new(),
        autocorrelation: (Vec::new(), Vec::new()),
        allan: Vec::new(),
        by_run: Vec::new(),
        ..odd.clone()
    };
    let blocks = vec![odd, empty];
    let page = page(&finding(), &model(), &Diagnostics { blocks, run_labels: Vec::new() });
    assert_stands_alone(&page);
    assert!(page.contains("Constant, so not drawn: voltage."));
}

#[test]
fn text_from_outside_is_text() {
    let evil = "<img src=x onerror=alert(1)>\"'&";
    let mut hostile = finding();
    hostile.dataset = evil.into();
    hostile.notices = vec![evil.into()];
    hostile.noise_floor.unit = evil.into();
    hostile.held_out.unit = evil.into();
    hostile.held_out.quantity = Some(evil.into());
    hostile.effects.push(effect(evil, &[evil]));
    let rival = &mut hostile.effects[0].rivals[0];
    (rival.name, rival.term, rival.drivers) = (evil.into(), evil.into(), vec![evil.into()]);
    rival.separated_by = Some(evil.into());
    let parameter = &mut hostile.effects[1].parameters[0];
    (parameter.name, parameter.unit) = (evil.into(), evil.into());
    hostile.left[0].shape = evil.into();
    hostile.left[0].drivers = vec![evil.into()];
    let next = hostile.next_experiment.as_mut().unwrap();
    (next.plan, next.expected_gain) = (evil.into(), evil.into());
    next.separates = vec![evil.into()];
    let mut model = model();
    model.terms[0].name = evil.into();
    model.terms[0].parameters[0].unit = evil.into();
    let mut block = block(8);
    for text in [&mut block.label, &mut block.unit, &mut block.time_unit] {
        *text = evil.into();
    }
    (block.channels[0].name, block.channels[0].unit) = (evil.into(), evil.into());
    let curve = &mut block.effects[0];
    (curve.name, curve.driver, curve.unit) = (evil.into(), evil.into(), evil.into());
    block.noise[0].name = evil.into();
    block.by_run = (0..2).map(|run| RunError { run, before: 1.0, after: 2.0 }).collect();
    let diagnostics = Diagnostics { blocks: vec![block], run_labels: vec![evil.into(); 2] };
    let page = page(&hostile, &model, &diagnostics);
    let document = Html::parse_document(&page);
    assert!(document.errors.is_empty(), "{:?}", document.errors);
    assert!(texts(&document, "img").is_empty());
    assert!(!page.contains("<img"));
}

/// Writes a page to the file in `HIL_SAMPLE_REPORT`, for inspection.
#[test]
#[ignore = "for whoever changes the page"]
fn sample_report() {
    let path = std::env::var_os("HIL_SAMPLE_REPORT").expect("HIL_SAMPLE_REPORT names a file");
    std::fs::write(path, page(&finding(), &model(), &diagnostics(300))).unwrap();
}

/// No error falls with a sign that was stated wrongly, and the page says both.
#[test]
fn beside_an_effect_nothing_else_is_missing() {
    let found = Finding { verdict: Verdict::NothingMissing, ..finding() };
    let word = |finding: &Finding| {
        texts(&assert_stands_alone(&page(finding, &model(), &diagnostics(300))), "p.outcome")
    };
    assert_eq!(word(&found), ["nothing else is missing"]);
    assert_eq!(word(&Finding { effects: Vec::new(), ..found }), ["nothing is missing"]);
}
