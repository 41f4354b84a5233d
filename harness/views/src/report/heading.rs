//! Identity and outcome of the run.

use super::collect::Collected;
use super::{measurements, properties};
use maud::{Markup, html};
use record::figures;
use record::outcome::{Counts, Measurement, Outcome, PropertySummary, Summary, Verdict};

pub(super) fn heading(summary: &Summary, collected: &Collected) -> Markup {
    let outcome = summary.outcome;
    let counts = Counts::of(&summary.measurements);
    html! {
        header.(outcome.name()) {
            p.outcome { (outcome.name()) }
            h1 { (summary.title) }
            p.lead { (counts) ". " (reason(summary)) }
            @if let Some(title) = collected.steps.unfinished() {
                @if outcome != Outcome::Passed {
                    p.lead { "The step that had not ended: " (title) "." }
                }
            }
            @if let Some(cut) = &collected.cut {
                p.lead.cut { "Drawn from what could be read: " (cut) "." }
            }
            dl {
                (fact("plan", &summary.plan))
                (fact("seed", &summary.seed.to_string()))
                (fact("clock", &summary.clock))
                (fact("bus", &summary.bus))
                (fact("device under test", &summary.device_under_test))
                (fact("bench time", &figures::duration(summary.simulated_s)))
                (fact("took", &figures::duration(summary.wall_s)))
                (fact("events", &grouped(summary.events)))
                (fact("records", &grouped(collected.records)))
                @if let Some(run) = summary.repetition() {
                    (fact("run", &run.to_string()))
                }
                @if let Some(bench) = &summary.bench {
                    (fact("started", &bench.started))
                    (fact("host", &bench.host))
                    @if let Some(file) = &bench.file {
                        (fact("bench file", file))
                    }
                    @for (name, value) in &bench.about {
                        (fact(name, value))
                    }
                }
                @if let Some(timing) = &summary.timing {
                    (fact("late, 99 % of the time", &format!("at most {:.1} ms", timing.late.p99_ms)))
                    (fact("late, at worst", &format!("{:.1} ms", timing.late.max_ms)))
                    (fact("scheduling", &timing.scheduling))
                }
                (fact("exit status", &outcome.exit_status().to_string()))
                (fact("hil", &summary.version))
            }
        }
    }
}

fn reason(summary: &Summary) -> String {
    let broken = summary.properties.iter().filter(|one| one.is_broken());
    let of = |reason: &String| broken.clone().find(|one| one.breach() == *reason);
    match (&summary.reason, summary.outcome) {
        (Some(reason), _) => match of(reason) {
            Some(first) => property(first, broken.count() - 1),
            None => reason.clone(),
        },
        (None, Outcome::Passed) => String::new(),
        (None, _) => failed(&summary.measurements),
    }
}

/// A sentence about the property that broke first, and the number of others.
fn property(first: &PropertySummary, others: usize) -> String {
    let others = match others {
        0 => String::new(),
        others => {
            let counted = figures::counted(others as u64, "more property", "more properties");
            format!("; {counted} failed")
        }
    };
    format!("Failed: property {} {}{others}.", first.name, properties::result(first))
}

fn failed(measurements: &[Measurement]) -> String {
    let failed =
        measurements.iter().filter(|one| matches!(one.verdict, Verdict::Fail | Verdict::Unset));
    let told = failed.map(|one| match measurements::reason(one) {
        Some(reason) => format!("{}: {reason}", one.name),
        None => one.name.clone(),
    });
    let told: Vec<String> = told.collect();
    if told.is_empty() {
        "No reason was given.".to_owned()
    } else {
        format!("{}.", told.join("; "))
    }
}

pub(super) fn fact(name: &str, value: &str) -> Markup {
    html! { div { dt { (name) } dd { (value) } } }
}

/// Formats a count with thin spaces between thousands.
pub(super) fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::reason;
    use record::outcome::Summary;
    use record::outcome::samples::{properties, summary};

    #[test]
    fn a_property_that_broke_is_called_one() {
        let of = |reason: &str| Summary {
            reason: Some(reason.to_owned()),
            properties: properties(),
            ..summary()
        };
        let what = "moves 1.20 s after the gyro was last heard";
        assert_eq!(
            reason(&of(&format!("broke stops_on_loss at 12.500 s: {what}"))),
            format!(
                "Failed: property stops_on_loss broke at 12.500 s: {what}; 1 more property failed."
            )
        );
        assert_eq!(
            reason(&of("bus_off never reached")),
            "Failed: property bus_off did not come about; 1 more property failed."
        );
        assert_eq!(reason(&of("the program ended")), "the program ended");
    }

    #[test]
    fn thousands_are_set_apart() {
        assert_eq!(super::grouped(34_567_890), "34\u{202f}567\u{202f}890");
        assert_eq!(super::grouped(0), "0");
        assert_eq!(super::grouped(999), "999");
    }
}
