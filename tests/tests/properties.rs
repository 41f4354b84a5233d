//! Properties of the shipped plans: our controller keeps them all, and watching them changes nothing.

use harness::operator::Answers;
use harness::run::{Prepared, simulate_watched};
use judge::properties::{Kind, PropertyVerdict};
use plan::made::Made;
use record::header::Header;
use record::outcome::Outcome;
use record::sink::{FileSink, Level, NullSink};
use std::fmt::Write as _;
use tests::plans::record_file;

/// Plans in which the base drives, except `laps-observed`, which is sixteen hours of the same.
const DRIVING: [&str; 8] = [
    "straight-accuracy",
    "straight-accuracy-mounted",
    "turn-accuracy",
    "laps-corrected",
    "laps-corrected-serial",
    "laps-uncorrected",
    "umbmark",
    "live-side",
];
/// Plans in which nothing drives.
const STANDING: [&str; 3] = ["warm-up", "temperature-calibration", "verification-dsp3000"];

fn watched(name: &str) -> Vec<PropertyVerdict> {
    let prepared = Prepared::load(name, &Made::default()).expect("the plan ships");
    let run = simulate_watched(&prepared, 1, &Answers::default(), &mut NullSink, &mut |_| true);
    assert_eq!(run.ending.outcome, Outcome::Passed, "{name}: {:?}", run.ending);
    run.properties
}

#[test]
fn every_always_property_holds_in_the_plans_that_ship() {
    let mut table = String::new();
    for name in DRIVING.iter().chain(&STANDING) {
        let mut verdicts = watched(name);
        verdicts.retain(|verdict| verdict.kind == Kind::Always);
        if table.is_empty() {
            let names: String = verdicts.iter().map(|v| format!("{:>21}", v.name)).collect();
            writeln!(table, "{:<27}{names}", "margin").expect("a string grows");
        }
        write!(table, "{name:<27}").expect("a string grows");
        for verdict in verdicts {
            assert!(verdict.held, "{name}: {verdict:?}");
            let margin = verdict.margin.map_or("-".to_owned(), |margin| format!("{margin:.2}"));
            write!(table, "{margin:>21}").expect("a string grows");
        }
        table.push('\n');
    }
    insta::assert_snapshot!(table);
}

#[test]
fn the_record_is_the_same_whether_anybody_watches_or_not() {
    for name in ["live-side", "laps-corrected"] {
        let prepared = Prepared::load(name, &Made::default()).expect("the plan ships");
        let mut file = Vec::new();
        let header = Header { plan: prepared.plan.name.as_str().to_owned(), ..Header::default() };
        let mut sink = FileSink::new(&mut file, &header, Level::Full).expect("memory takes it");
        let answers = Answers::default();
        let run = simulate_watched(&prepared, 7, &answers, &mut sink, &mut |_| true);
        drop(sink);
        assert!(run.properties.iter().any(|verdict| verdict.margin.is_some()), "{name}");
        assert!(file == record_file(&prepared, 7), "{name}: another record");
    }
}
