//! `hil campaign`: what it draws, and what it leaves.

use crate::hil::Hil;
use std::fs;
use std::path::PathBuf;

fn oven() -> Hil {
    let hil = Hil::new();
    hil.run(&["new", "oven"]).exits(0);
    hil
}

fn saved(hil: &Hil) -> Vec<PathBuf> {
    let all = fs::read_dir(hil.path("found")).unwrap().map(|entry| entry.unwrap().path());
    all.filter(|path| path.extension().is_some_and(|kind| kind == "toml")).collect()
}

/// Found by a user: plans that were not shrunk called themselves the smallest, and stayed beside those that were.
#[test]
fn a_plan_that_is_not_shrunk_says_so_and_makes_way_for_the_smallest() {
    let hil = oven();
    let campaign = |more: &[&str]| {
        let first = ["campaign", "oven/settles.toml", "--cases", "12", "--seed", "2"];
        hil.run(&[&first[..], &["--out", "found", "--quiet"], more].concat()).exits(1)
    };
    let head =
        |path: &PathBuf| fs::read_to_string(path).unwrap().lines().next().unwrap().to_owned();
    campaign(&["--shrink-max", "0"]);
    let first = saved(&hil);
    assert_eq!(first.len(), 1, "{first:?}");
    assert!(head(&first[0]).ends_with(": a case that breaks `passes`, not shrunk."));
    assert!(fs::read_to_string(hil.path("found/report.html")).unwrap().contains(", not shrunk."));
    let resumed = campaign(&[]);
    assert!(resumed.out.contains("12 done before"), "{}", resumed.out);
    let second = saved(&hil);
    assert_eq!(second.len(), 1, "{second:?}");
    assert_ne!(first, second);
    assert!(head(&second[0]).ends_with(": the smallest case that breaks `passes`."));
    // Each case tells which of its faults acted.
    let journal = fs::read_to_string(hil.path("found/cases.jsonl")).unwrap();
    for line in journal.lines().skip(1) {
        let case: serde_json::Value = serde_json::from_str(line).unwrap();
        let count = |of: &serde_json::Value| of.as_array().unwrap().len();
        assert_eq!(count(&case["case"]["schedule"]), count(&case["result"]["acted"]), "{line}");
    }
}

#[test]
fn kinds_can_be_left_out() {
    let hil = oven();
    let campaign = |more: &[&str]| {
        let first = ["campaign", "oven/settles.toml", "--cases", "1", "--shrink-max", "0"];
        hil.run(&[&first[..], &["--out", "found", "--quiet"], more].concat())
    };
    let both = campaign(&["--faults", "drop,flip", "--without", "flip"]).exits(2);
    assert!(both.err.contains("flip is asked for by --faults and left out"), "{}", both.err);
    let unknown = campaign(&["--without", "dorp"]).exits(2);
    assert!(unknown.err.contains("dorp"), "{}", unknown.err);
    campaign(&["--without", "drop,frozen_message"]);
    let account = fs::read_to_string(hil.path("found/campaign.json")).unwrap();
    let account: serde_json::Value = serde_json::from_str(&account).unwrap();
    let kinds: Vec<&str> = account["kinds"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["kind"].as_str().unwrap())
        .collect();
    assert!(kinds.contains(&"duplicate") && !kinds.contains(&"drop"), "{kinds:?}");
    assert!(!kinds.contains(&"frozen_message"), "{kinds:?}");
    // It draws others: another campaign.
    let other = campaign(&[]).exits(2);
    assert!(other.err.contains("without drop/frozen_message"), "{}", other.err);
}
