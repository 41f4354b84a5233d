//! The page of a campaign.

use super::{Gathered, page};
use campaign::{Account, Case, CaseResult, End, FoundCase, Line, Struck, Violated};
use plan::faults::{Fault, FaultKind, Schedule, Target, When};
use scraper::{Html, Selector};
use wire::time::Span;

const HOSTILE: &str = "</script><img src=x onerror=alert(1)>\u{202e}\u{7}";

fn fault(kind: &str, at_s: i64) -> Fault {
    let when = When::At(Span::from_secs(at_s));
    Fault { when, ..Fault::new(Target::Gyro, FaultKind::typical(kind).unwrap()) }
}

fn line(number: u64) -> Line {
    let kind = if number.is_multiple_of(3) { "stuck" } else { "drop" };
    let margin = if number % 10 == 7 { -0.5 } else { 0.4 };
    let violated = (margin < 0.0).then(|| Violated {
        property: "fresh_heading".into(),
        at_s: 3.0,
        what: HOSTILE.into(),
    });
    let result = CaseResult {
        outcome: "passed".into(),
        passed: violated.is_none(),
        violated: violated.into_iter().collect(),
        margins: [("fresh_heading".to_owned(), margin), ("recovers".to_owned(), 0.9)].into(),
        reached: ["gyro_silent".to_owned()].into(),
        ..CaseResult::default()
    };
    let case = Case { seed: number, schedule: Schedule { faults: vec![fault(kind, 5)] } };
    Line { number, case, result, announced: false }
}

fn account(end: Option<End>) -> Account {
    let struck = |kind: &str| Struck { kind: kind.into(), target: "gyro".into() };
    Account {
        plan: "laps".into(),
        title: HOSTILE.into(),
        seed: 3,
        search: "margins".into(),
        asked: 200,
        faults_max: 4,
        carried_out_by: "2 threads".into(),
        horizon_s: 100.0,
        kinds: ["drop", "stuck", "over_range"].map(struck).into(),
        phases: vec!["lap".into(), HOSTILE.into()],
        states: vec!["gyro_silent".into(), "bus_off".into()],
        end,
        ..Account::new()
    }
}

fn ended(file: Option<&str>) -> End {
    let case = Case { seed: 7, schedule: Schedule { faults: vec![fault("drop", 5)] } };
    let found = FoundCase {
        property: "fresh_heading".into(),
        number: 7,
        times: 10,
        what: HOSTILE.into(),
        case,
        plan: format!("runs/x/{HOSTILE}.toml"),
        file: file.map(str::to_owned),
        ..FoundCase::default()
    };
    End { wall_s: 3.0, found: vec![found], ..End::default() }
}

fn drawn(account: &Account, cases: u64) -> (String, Html) {
    let mut gathered = Gathered::of(account);
    (0..cases).for_each(|number| gathered.add(&line(number)));
    let text = page(account, &gathered);
    let document = Html::parse_document(&text);
    assert!(document.errors.is_empty(), "{:?}", document.errors);
    (text, document)
}

fn texts(page: &Html, selector: &str) -> Vec<String> {
    let selector = Selector::parse(selector).unwrap();
    page.select(&selector).map(|found| found.text().collect()).collect()
}

/// Found by a user: cases that broke a comparison for equality were drawn as held, with a margin of zero.
#[test]
fn a_case_that_broke_is_broken_whatever_its_margin() {
    let mut gathered = Gathered::of(&account(None));
    for number in 0..40 {
        let mut line = line(number);
        let breaks = (3..6).contains(&number);
        line.result.violated.clear();
        if breaks {
            let (property, what) = ("echoed".to_owned(), "other".to_owned());
            line.result.violated.push(Violated { property, at_s: 1.0, what });
        }
        line.result.margins = [("echoed".to_owned(), 0.0)].into();
        gathered.add(&line);
    }
    let page = Html::parse_document(&page(&account(None), &gathered));
    assert_eq!(texts(&page, ".plots .legend span"), ["●37 held", "●3 broken"]);
    let csv = Selector::parse("a[download='margin-echoed.csv']").unwrap();
    let href = page.select(&csv).next().unwrap().attr("href").unwrap();
    assert_eq!(href.matches(",broken").count(), 3, "{href}");
    assert_eq!(href.matches(",held").count(), 37);
}

/// Found by a user: faults that never began, or changed nothing, were counted as tried and held.
#[test]
fn only_faults_that_acted_count_as_tried() {
    let mut gathered = Gathered::of(&account(None));
    for number in 0..30 {
        let mut line = line(number);
        let faults = &mut line.case.schedule.faults;
        faults.push(fault("over_range", 9));
        line.result.acted = vec![3, 0];
        gathered.add(&line);
    }
    let text = page(&account(None), &gathered);
    let told = "3 kinds of faults, 1 of which never acted. Of 60 faults drawn, 30 did nothing and are not counted: ";
    assert!(text.contains(told), "{text}");
    let page = Html::parse_document(&text);
    // `over_range` was drawn at a time of the run in each case.
    assert_eq!(texts(&page, ".heat tbody td:not(.untried):not(:first-child)").len(), 2 * 2);
}

#[test]
fn a_step_with_a_label_has_one_column() {
    let labels = [("lap".to_owned(), vec!["first lap".to_owned()])].into();
    let phases = vec!["lap".into(), "first lap".into()];
    let account = Account { labels, phases, ..account(None) };
    let (_, page) = drawn(&account, 10);
    let heads = texts(&page, ".heat th");
    assert_eq!(heads.iter().filter(|head| *head == "first lap").count(), 1, "{heads:?}");
    assert!(!heads.contains(&"lap".to_owned()), "{heads:?}");
}

#[test]
fn the_page_says_what_broke_how_to_see_it_again_and_what_was_tried() {
    let (text, page) = drawn(&account(Some(ended(Some("laps-fresh.toml")))), 100);
    assert_eq!(texts(&page, "header .outcome"), ["broken"]);
    assert_eq!(
        texts(&page, "header .lead")[0],
        "100 of 200 cases, 1 property broken. Runs ended: 10 failed, 90 passed."
    );
    assert_eq!(texts(&page, "a[href='laps-fresh.toml']"), ["laps-fresh.toml"]);
    assert!(texts(&page, ".broken code")[0].ends_with(".toml --seed 7"));
    assert!(texts(&page, "pre")[0].starts_with("[[fault]]"));
    assert_eq!(texts(&page, ".verdict"), ["broken", "held"]);
    assert!(text.contains("1 of which never acted"));
    // 34 multiples of three below 100, of which 27, 57 and 87 end in 7.
    assert_eq!(
        texts(&page, ".heat td.shade1"),
        [
            "11 %7 of 66; 5 to 20 %",
            "11 %7 of 66; 5 to 20 %",
            "9 %3 of 34; 3 to 23 %",
            "9 %3 of 34; 3 to 23 %"
        ]
    );
    assert_eq!(texts(&page, ".heat td.untried").len(), 2 * 2 + 4);
    assert_eq!(texts(&page, "svg.plot").len(), 2);
    assert_eq!(texts(&page, ".reason"), ["no case"]);
    assert!(!text.contains("<img") && !text.contains("<script"), "text from outside is text");
    assert!(!text.contains('\u{202e}') && !text.contains('\u{7}'));
}

#[test]
fn one_that_was_interrupted_is_drawn_as_far_as_it_went() {
    let (_, page) = drawn(&account(None), 5);
    assert_eq!(texts(&page, "header .outcome"), ["interrupted"]);
    assert!(
        texts(&page, ".cut")[0].starts_with("It did not finish; this page shows the cases so far")
    );
    let stopped = End { stopped: true, ..End::default() };
    let (_, page) = drawn(&account(Some(stopped)), 0);
    assert!(texts(&page, ".cut")[0].starts_with("It was stopped before the end"));
    let (_, page) = drawn(&account(Some(End::default())), 5);
    assert_eq!(texts(&page, "header .outcome"), ["held"]);
}

/// Found by a user: with fewer cases than before, the page spoke of 40 of 20 cases.
#[test]
fn cases_beyond_those_asked_for_are_not_counted() {
    let (text, page) = drawn(&account(Some(ended(None))), 300);
    assert!(texts(&page, "header .lead")[0].starts_with("200 of 200 cases, "), "{text}");
}

#[test]
fn a_link_leads_nowhere_outside() {
    for name in ["https://example.org/x", "../x.toml", "javascript:alert(1)", "/etc/passwd", ".."] {
        let (_, page) = drawn(&account(Some(ended(Some(name)))), 10);
        let links = Selector::parse("a:not(.data)").unwrap();
        assert_eq!(page.select(&links).count(), 0, "{name}");
    }
}

#[test]
fn many_cases_fit_one_page() {
    let asked = Account { asked: 200_000, ..account(Some(ended(None))) };
    let (text, _) = drawn(&asked, 200_000);
    assert!(text.len() < 1_000_000, "{} bytes", text.len());
    assert!(text.contains("the lowest and the highest of each column"));
}
