//! Marks on the time line at which verdicts were decided.

use super::collect::Collected;
use super::marks::is_outside;
use record::header::{Header, Quantity};
use record::outcome::{Measurement, Summary, Verdict};
use std::collections::BTreeMap;
use std::slice;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mark {
    pub at_s: f64,
    /// `pass`, `marginal` or `fail`.
    pub class: &'static str,
    pub text: String,
}

/// Marks where properties broke and measurements were decided, in order of time: at the first observation outside the
/// band if that decides it, else at the last observation that counts. Older records do not state which observations a
/// measurement uses; it then gets no mark.
pub(super) fn marks(summary: &Summary, header: &Header, collected: &Collected) -> Vec<Mark> {
    // Of two quantities that a measurement is judged by, the first counts.
    let judged = header.quantities.iter().rev();
    let judged = judged.flat_map(|one| one.judged_by.iter().map(move |name| (name.as_str(), one)));
    let quantities: BTreeMap<&str, &Quantity> = judged.collect();
    let measured = summary.measurements.iter().filter_map(|measurement| {
        let at_s = decided_s(measurement, quantities.get(measurement.name.as_str())?, collected)?;
        let class = measurement.verdict.name();
        Some(Mark { at_s, class, text: format!("{}: {class}", measurement.name) })
    });
    let broken = summary.properties.iter().filter(|property| property.is_broken());
    let broken = broken.filter_map(|property| {
        let at_s = property.broken_s.filter(|at_s| at_s.is_finite())?;
        Some(Mark { at_s, class: Verdict::Fail.name(), text: format!("{} broke", property.name) })
    });
    let mut marks: Vec<Mark> = measured.chain(broken).collect();
    marks.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    marks
}

fn decided_s(measurement: &Measurement, quantity: &Quantity, collected: &Collected) -> Option<f64> {
    let samples = collected.samples(&quantity.name);
    let band = quantity.bands.iter().find(|band| band.measurement == measurement.name);
    let outside = band.filter(|_| measurement.verdict == Verdict::Fail).and_then(|band| {
        samples.iter().find(|sample| is_outside(sample, slice::from_ref(band), &collected.phases))
    });
    outside.or(samples.last()).map(|sample| sample.at_s)
}

#[cfg(test)]
mod tests {
    use super::marks;
    use crate::report::collect::Collected;
    use record::Device;
    use record::header::{Band, Header, Quantity};
    use record::outcome::samples::{measurement, summary};
    use record::outcome::{Summary, Verdict};
    use record::samples::{observation, record};

    #[test]
    fn a_failure_is_decided_by_the_first_observation_outside_and_a_pass_by_the_last() {
        let records = [(1.0, 0.1), (2.0, 0.9), (3.0, 0.2)]
            .map(|(at_s, value)| Ok(record(at_s, Device::Plan, observation("q", value, &[]))));
        let collected = Collected::of(&Header::default(), records);
        let band =
            |name: &str| Band { measurement: name.into(), upper: Some(0.5), ..Band::default() };
        let quantity = Quantity {
            name: "q".into(),
            bands: vec![band("all"), band("most")],
            judged_by: vec!["all".into(), "most".into()],
            ..Quantity::default()
        };
        let header = Header { quantities: vec![quantity], ..Header::default() };
        let measurements = vec![
            measurement("most", 0.2, Verdict::Pass),
            measurement("all", 0.9, Verdict::Fail),
            measurement("unknown", 0.9, Verdict::Fail),
        ];
        let mut properties = summary().properties;
        properties.truncate(0);
        let summary = Summary { measurements, properties, ..summary() };
        let found: Vec<_> = marks(&summary, &header, &collected)
            .into_iter()
            .map(|mark| (mark.at_s, mark.class, mark.text))
            .collect();
        assert_eq!(found, [(2.0, "fail", "all: fail".into()), (3.0, "pass", "most: pass".into())]);
    }
}
