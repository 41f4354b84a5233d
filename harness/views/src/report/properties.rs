//! Results of the plan's properties, and those that this bench could not judge.

use super::listed;
use maud::{Markup, html};
use record::figures;
use record::outcome::{PropertySummary, Verdict};

/// Renders the table; `None` if the plan declares no properties.
pub(super) fn table(properties: &[PropertySummary]) -> Option<Markup> {
    if properties.is_empty() {
        return None;
    }
    let rows = html! { @for property in properties { (row(property)) } };
    let heads = ["property", "verdict", "must hold", "#least margin", "result"];
    Some(listed::table(Some("properties"), &heads, &rows))
}

fn row(property: &PropertySummary) -> Markup {
    let verdict = match property.held {
        None => Verdict::NotJudged,
        Some(false) => Verdict::Fail,
        Some(true) => Verdict::Pass,
    };
    html! {
        tr.(verdict.name()) {
            td { strong { (property.name) } }
            td { span.verdict { (verdict.in_words()) } }
            td { (if property.always { "always" } else { "sometimes" }) }
            td.number { (property.margin.and_then(figures::least_margin).unwrap_or_else(|| "-".to_owned())) }
            td { (result(property)) }
        }
    }
}

pub(super) fn result(property: &PropertySummary) -> String {
    if let Some(why) = property.untested() {
        return format!("held, but was {why}");
    }
    let what = property.what.as_deref().unwrap_or("-");
    match (property.held, property.always) {
        (None, _) => {
            format!("not judged: {}", property.not_judged.as_deref().unwrap_or("nobody says why"))
        }
        (Some(true), true) if property.margin.is_none() => "nothing to judge".to_owned(),
        (Some(true), true) => "held".to_owned(),
        (Some(true), false) => "came about".to_owned(),
        (Some(false), true) => match property.broken_s {
            Some(at_s) => format!("broke at {at_s:.3} s: {what}"),
            None => what.to_owned(),
        },
        (Some(false), false) => "did not come about".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::{PropertySummary, result, table};
    use record::outcome::samples::properties;

    #[test]
    fn each_property_is_told_in_words() {
        let told: Vec<String> =
            properties().iter().map(|one| format!("{}: {}", one.name, result(one))).collect();
        insta::assert_snapshot!(told.join("\n"));
        let page = table(&properties()).unwrap().into_string();
        for (verdict, count) in [("not_judged", 1), ("fail", 2), ("pass", 4)] {
            assert_eq!(page.matches(&format!("tr class=\"{verdict}\"")).count(), count, "{page}");
        }
        assert!(table(&[]).is_none());
    }

    #[test]
    fn what_was_never_judged_broke_at_no_time() {
        let never = PropertySummary {
            broken_s: None,
            what: Some("never judged: no value of cells.VoltageMax".into()),
            ..properties()[2].clone()
        };
        assert_eq!(result(&never), "never judged: no value of cells.VoltageMax");
    }
}
