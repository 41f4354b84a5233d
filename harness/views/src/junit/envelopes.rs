//! Envelopes as a suite: one case per fault, which fails if the plan tolerates less than it requires.

use super::{failure, of_suite};
use campaign::Measured;
use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};
use record::figures;

/// Returns the document for the envelopes of `plan`.
///
/// # Errors
/// When the XML cannot be written, which happens only if memory runs out.
pub fn envelopes(plan: &str, all: &[Measured]) -> Result<String, quick_junit::SerializeError> {
    let mut suite = TestSuite::new(format!("envelopes {plan}"));
    for measured in all {
        let envelope = &measured.envelope;
        let said = said(measured);
        let status = if measured.holds() {
            TestCaseStatus::success()
        } else {
            failure(NonSuccessKind::Failure, "envelope", &said, &said)
        };
        let mut case = TestCase::new(format!("{} of {}", envelope.kind, envelope.target), status);
        case.set_classname(format!("envelopes.{plan}")).set_system_out(said);
        suite.add_test_case(case);
    }
    of_suite(suite)
}

/// Describes the tolerated and the required severity in one line.
fn said(Measured { envelope, at_least, .. }: &Measured) -> String {
    const DIGITS: i32 = 3;
    let figure = |severity| format!("{} {}", figures::exact(severity, DIGITS), envelope.unit);
    let tolerated = envelope.tolerated.map_or("nothing that was tried".to_owned(), figure);
    let wanted = at_least.map_or(String::new(), |least| format!("; wanted: {}", figure(least)));
    format!("tolerates {tolerated}{wanted}")
}

#[cfg(test)]
mod tests {
    use super::envelopes;
    use campaign::Envelope;
    use campaign::Measured;

    #[test]
    fn less_than_wanted_fails() {
        let envelope = Envelope {
            kind: "drop".to_owned(),
            target: "gyro".to_owned(),
            unit: "%".to_owned(),
            share: 0.9,
            levels: Vec::new(),
            tolerated: Some(3.162),
            is_all: false,
        };
        let plan = || "live-side".to_owned();
        let of = |at_least| Measured { plan: plan(), envelope: envelope.clone(), at_least };
        let xml = envelopes("live-side", &[of(Some(2.0)), of(Some(4.0)), of(None)]).unwrap();
        assert!(xml.contains(r#"tests="3" skipped="0" errors="0" failures="1""#), "{xml}");
        assert!(xml.contains("tolerates 3.16 %; wanted: 4 %"), "{xml}");
    }
}
