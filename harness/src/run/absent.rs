//! What another plan judges and a recorded run did not measure: each measurement says why it has no figure.

use crate::outcome::{Measurement, Verdict};
use crate::plan::{Declared, Plan};
use crate::record::header::Header;

/// Says why measurements of `plan` have no figure from a run of the plan `of_run`. Returns whether it took a figure away that
/// is of something else than the plan means.
pub(super) fn name_absent(
    plan: &Plan,
    of_run: Option<&Plan>,
    recorded: &Header,
    measurements: &mut [Measurement],
) -> bool {
    let mut is_other = false;
    for (declared, found) in plan.measurements.iter().zip(measurements) {
        let why = not_recorded(declared, recorded)
            .or_else(|| of_run.and_then(|of_run| without_step(declared, of_run)));
        if let Some(why) = why.filter(|_| found.observations == 0) {
            found.statistic = why;
        } else if let Some(why) = of_run.and_then(|of_run| otherwise(plan, of_run, declared)) {
            found.verdict = Verdict::Unset;
            (found.value, found.uncertainty, found.statistic) = (None, 0.0, why);
            is_other = true;
        }
    }
    is_other
}

fn not_recorded(declared: &Declared, recorded: &Header) -> Option<String> {
    let quantity = declared.quantity.as_str();
    if recorded.quantities.iter().any(|one| one.name == quantity) {
        return None;
    }
    let is_of_bus = declared.quantity.of_message().is_some() || declared.quantity.line().is_some();
    let way = match is_of_bus {
        true => "; `hil export --bus` and `hil import` judge its frames by another plan",
        false => "",
    };
    Some(format!("the record has no {quantity}: the plan of the run did not measure it{way}"))
}

/// A sentence about a step in which the measurement judges, and which the plan of the run did not have.
fn without_step(declared: &Declared, of_run: &Plan) -> Option<String> {
    let phases = of_run.phases();
    let missing = declared.phases().find(|phase| !phases.contains_key(phase))?;
    Some(format!("the plan of the run had no step or label {missing}"))
}

/// A sentence about a measurement that the plan of the run made of something else under the same name.
fn otherwise(plan: &Plan, of_run: &Plan, declared: &Declared) -> Option<String> {
    let quantity = &declared.quantity;
    if let Some(name) = quantity.reaction() {
        let of = |plan: &Plan| plan.reactions.iter().find(|one| one.name.as_str() == name).cloned();
        let is_same = of(plan) == of(of_run);
        return (!is_same).then(|| format!("the run measured another reaction {name}"));
    }
    let since = declared.since.as_ref()?;
    let is_measured =
        |one: &Declared| one.quantity == *quantity && one.since.as_ref() == Some(since);
    (!of_run.measurements.iter().any(is_measured))
        .then(|| format!("the run did not measure how long {quantity} took to begin since {since}"))
}
