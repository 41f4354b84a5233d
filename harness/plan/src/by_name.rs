//! Results that plans make and use by name.

use crate::{Action, Name, Plan, Step};
use std::collections::{BTreeMap, BTreeSet};

/// A name in a step, if the step makes or uses a result of a kind.
pub(crate) type Named = fn(&Action) -> Option<&Name>;

/// The names in the steps of `plan`.
pub(crate) fn names(plan: &Plan, named: Named) -> BTreeSet<String> {
    let names = Step::walk(&plan.steps).filter_map(|step| named(&step.action));
    names.map(|name| name.as_str().to_owned()).collect()
}

/// Every result that `plan` uses and does not make itself: from `made`, or else read by name.
pub(crate) fn load<T: Clone, E>(
    plan: &Plan,
    (used, makes): (Named, Named),
    made: &BTreeMap<String, T>,
    read: impl Fn(&str) -> Result<T, E>,
) -> Result<BTreeMap<String, T>, E> {
    let own = names(plan, makes);
    let used = names(plan, used).into_iter();
    let needed = used.filter(|name| made.contains_key(name) || !own.contains(name));
    let load = |name: String| match made.get(&name) {
        Some(result) => Ok((name, result.clone())),
        None => read(&name).map(|result| (name, result)),
    };
    needed.map(load).collect()
}
