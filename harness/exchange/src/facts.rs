//! Facts about a run as a whole, for formats that have a place for them.

use crate::tables::survey::Survey;
use record::outcome::Summary;
use std::collections::BTreeMap;

/// Plan, seed, versions, whether the record is complete, and the result of the run if known.
pub(crate) fn facts(survey: &Survey, summary: Option<&Summary>) -> BTreeMap<String, String> {
    let header = &survey.header;
    let mut facts = BTreeMap::from([
        ("plan".to_owned(), header.plan.clone()),
        ("seed".to_owned(), header.seed.to_string()),
        ("version".to_owned(), header.harness.clone()),
        ("exported_by".to_owned(), concat!("hil ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("records".to_owned(), survey.records.to_string()),
        ("record".to_owned(), survey.wholeness()),
    ]);
    if let Some(summary) = summary {
        facts.extend([
            ("outcome".to_owned(), summary.outcome.name().to_owned()),
            ("clock".to_owned(), summary.clock.clone()),
            ("bus".to_owned(), summary.bus.clone()),
            ("device_under_test".to_owned(), summary.device_under_test.clone()),
        ]);
    }
    facts
}
