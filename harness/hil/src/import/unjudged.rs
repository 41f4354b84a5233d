//! Which measurements of a plan a log of a CAN bus can make.

use judge::properties::Unjudged;
use plan::Plan;
use plan::quantities::{self as q, OPERATOR_PREFIX, Quantity, SDO_PREFIX, UDS_PREFIX};
use record::outcome::PropertySummary;

pub static FORMED: [&Quantity; 2] = [&q::STRAIGHT_STOP_ERROR, &q::POSE_WRITE_RETRIES];

/// Quantities that are not on the CAN bus, by prefix of the name. The first match counts.
const ELSEWHERE: [(&str, &str); 22] = [
    ("straight.heading_error", "it rests on the heading that closes the loops in the controller"),
    ("turn.stop_error", "it rests on the heading that closes the loops in the controller"),
    ("straight.true_", "it needs the truth, which is on no bus"),
    ("turn.true_", "it needs the truth, which is on no bus"),
    ("base_pose.", "it needs the truth, which is on no bus"),
    ("turn.", "the gyro is not on the CAN bus"),
    ("bias.", "the gyro is not on the CAN bus"),
    ("gyro.", "the gyro is not on the CAN bus"),
    ("samples.", "the gyro is not on the CAN bus"),
    ("clock.", "the gyro is not on the CAN bus"),
    ("table.", "the rotary table is not on the CAN bus"),
    ("lap.", "it needs the absolute measurement"),
    ("umbmark.", "it needs the absolute measurement"),
    ("pose.", "it needs the absolute measurement"),
    ("identification.", "it needs more than the CAN bus"),
    ("health.", "only the controller knows"),
    ("queue.", "only the controller knows"),
    ("step.", "a log does not say when a step began"),
    ("repeat.", "a log does not say when a step began"),
    (OPERATOR_PREFIX, "nobody was asked"),
    (UDS_PREFIX, "a log does not say which request a response answers"),
    (SDO_PREFIX, "a log does not say which step asked"),
];

/// Returns why a log cannot make this quantity; `None` if it can.
pub fn why_not(quantity: &str) -> Option<&'static str> {
    if FORMED.iter().any(|formed| formed.name == quantity) {
        return None;
    }
    let known = ELSEWHERE.iter().find(|(begin, _)| quantity.starts_with(begin));
    Some(known.map_or("it is not on the CAN bus", |(_, why)| why))
}

/// Returns the measurements of `plan` that a log cannot make, and why not.
pub(super) fn of_plan(plan: &Plan) -> Vec<(String, &'static str)> {
    let measurements = plan.measurements.iter();
    measurements
        .filter_map(|declared| {
            let second =
                declared.check.kind().facts().second_quantity.map(|(_, name)| name.as_str());
            let why = why_not(declared.quantity.as_str()).or_else(|| why_not(second?))?;
            Some((declared.name.as_str().to_owned(), why))
        })
        .collect()
}

/// Returns the properties of `plan` as unjudged: the frames alone do not show what the controller reported.
pub(super) fn properties(plan: &Plan) -> Vec<PropertySummary> {
    let unjudged = plan.properties.iter().map(|property| Unjudged {
        name: property.name().to_owned(),
        kind: property.kind(),
        why: "a log holds frames alone: nobody watched the controller's reports and the gyro"
            .to_owned(),
    });
    unjudged.map(|one| PropertySummary::from(&one)).collect()
}

#[cfg(test)]
mod tests {
    use super::{ELSEWHERE, FORMED, why_not};
    use plan::quantities::QUANTITIES;

    #[test]
    fn every_quantity_is_formed_or_has_its_reason() {
        for quantity in QUANTITIES {
            let formed = FORMED.contains(quantity);
            let known = ELSEWHERE.iter().any(|(begin, _)| quantity.name.starts_with(begin));
            assert!(formed || known, "{}", quantity.name);
            assert_eq!(why_not(quantity.name).is_none(), formed, "{}", quantity.name);
        }
        assert!(why_not("operator.loose_wheels").is_some());
    }
}
