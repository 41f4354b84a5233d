//! `hil report`: runs of any length and any end, and campaigns.

use crate::hil::{Hil, TURN};
use std::fs;

/// Maximum size of a report.
const BYTES_MAX: usize = 5_000_000;

/// A log at rest with more readings than a plot has columns.
const LOG: &str = r#"
name = "log"
title = "Sixteen hours at rest"
devices = "paper-table"
steps = [{ log = { duration_s = 57600, interval_s = 2 } }]

[[measurement]]
name = "rate"
doc = "Rate at rest"
quantity = "gyro.rate"
unit = "deg/s"
check = { all_within = [-1, 1] }
"#;

fn page(hil: &Hil, run: &str) -> String {
    fs::read_to_string(hil.path(run).join("report.html")).unwrap()
}

#[test]
fn sixteen_hours_of_readings_and_of_laps_stay_small_and_say_what_they_lack() {
    let hil = Hil::new();
    fs::write(hil.path("log.toml"), LOG).unwrap();
    hil.run(&["run", "./log.toml", "--out", "log", "--quiet"]).exits(0);
    let log = page(&hil, "log");
    assert!(log.len() < BYTES_MAX, "{} bytes", log.len());
    assert!(log.contains("28800 observations; "), "all are counted");
    assert!(log.contains("drawn, the lowest and the highest of each column"));
    assert!(log.contains("between these; <code>hil show</code> prints all of them"));

    hil.run(&["run", "laps-observed", "--out", "laps", "--quiet"]).exits(0);
    let laps = page(&hil, "laps");
    assert!(laps.len() < BYTES_MAX, "{} bytes", laps.len());
    assert!(laps.contains("bench time</dt><dd>17 h"));
    for figure in ["As Fig. 5 of the paper", "As Fig. 9 of the paper"] {
        assert!(laps.contains(figure), "{figure}");
    }
    assert_eq!(laps.matches("<figure>").count(), laps.matches("class=\"data\"").count());
}

#[test]
fn a_run_that_was_cut_short_is_drawn_as_far_as_it_goes() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--out", "run"]).exits(0);
    let record = hil.path("run/record.hilrec");
    let whole = fs::read(&record).unwrap();
    fs::write(&record, &whole[..whole.len() * 2 / 3]).unwrap();
    fs::remove_file(hil.path("run/summary.json")).unwrap();
    hil.run(&["report", "run"]).exits(0);
    let cut = page(&hil, "run");
    assert!(cut.contains("no summary says how the run ended: it was killed, or is still running"));
    assert!(cut.contains("Drawn from what could be read: the record is cut short"));
    assert!(cut.contains("The step that had not ended: "), "{cut}");
    assert!(cut.contains("Steps, faults and verdicts") && !cut.contains("Paper against measured"));
    assert!(!hil.path("run/summary.json").exists(), "drawing judges nothing");
}

#[test]
fn a_record_of_another_version_is_refused_by_name() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--out", "run"]).exits(0);
    let record = hil.path("run/record.hilrec");
    let mut bytes = fs::read(&record).unwrap();
    for (format, says) in [
        (9_u16, ["record format 9 is newer than 3", "use the version of hil that wrote it"]),
        (0, ["record format 0 is older than 2", "hil run PLAN --seed N"]),
    ] {
        // After the eight bytes of the magic number.
        bytes[8..10].copy_from_slice(&format.to_le_bytes());
        fs::write(&record, &bytes).unwrap();
        let ran = hil.run(&["report", "run"]).exits(2);
        // The message is wrapped and indented.
        let said: String = ran.err.split_whitespace().collect::<Vec<_>>().join(" ");
        let said = said.replace(" │ ", " ");
        assert!(says.iter().all(|words| said.contains(words)), "{said}");
    }
}

#[test]
fn a_campaign_is_drawn_and_drawn_again_from_what_it_left() {
    let plan = TURN.replace("steps = [", "steps = [\n    { use_calibration = \"temperature\" },");
    let hil = Hil::with_plan(&plan);
    let run = ["campaign", "./turn.toml", "--out", "found", "--quiet"];
    let broken = hil.run(&[&run[..], &["--cases", "150"]].concat());
    assert!(broken.status <= Some(1), "{broken:?}");
    let drawn = page(&hil, "found");
    assert!(drawn.contains("150 of 150 cases"), "{drawn}");
    assert!(drawn.contains("Random faults: One turn"));
    assert!(drawn.contains("What was tried") && drawn.contains("Margins"));
    let account = fs::read(hil.path("found/campaign.json")).unwrap();
    let mut account: serde_json::Value = serde_json::from_slice(&account).unwrap();
    let found = account["end"]["found"].as_array().unwrap().clone();
    assert_eq!(broken.status == Some(1), !found.is_empty());
    for one in &found {
        let command =
            format!("hil run {} --seed {}", one["plan"].as_str().unwrap(), one["case"]["seed"]);
        let shown = drawn.replace("<span class=\"whole\">", "").replace("</span>", "");
        assert!(shown.contains(&command), "{command}");
        let arguments: Vec<&str> = command.split(' ').skip(1).collect();
        let again = hil.run(&arguments).exits(1);
        assert!(again.out.contains(one["property"].as_str().unwrap()), "{}", again.out);
        let link = format!("<a href=\"{}\">", one["file"].as_str().unwrap());
        assert!(drawn.contains(&link), "{link}");
    }

    fs::remove_file(hil.path("found/report.html")).unwrap();
    let again = hil.run(&["report", "found"]).exits(0);
    assert_eq!(again.out, "found/report.html\n");
    assert_eq!(page(&hil, "found"), drawn);

    // As a killed campaign leaves it: no end, and an incomplete journal.
    account["asked"] = 1_000.into();
    account.as_object_mut().unwrap().remove("end");
    fs::write(hil.path("found/campaign.json"), account.to_string()).unwrap();
    hil.run(&["report", "found"]).exits(0);
    let cut = page(&hil, "found");
    assert!(cut.contains("150 of 1\u{202f}000 cases") && cut.contains("It did not finish"));
}
