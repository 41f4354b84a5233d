//! Powers of one driver as one effect: a polynomial.

use crate::finding::Effect;

/// Forms of powers, and what their coefficients are called in a polynomial.
const POWERS: [(&str, &str); 3] =
    [("linear", "slope"), ("quadratic", "quadratic"), ("cubic", "cubic")];

fn power(effect: &Effect) -> Option<usize> {
    POWERS.iter().position(|(form, _)| *form == effect.form)
}

/// Whether `effect` is a polynomial of more than one power.
pub(super) fn is_polynomial(effect: &Effect) -> bool {
    let is_power = |name: &str| POWERS.iter().any(|(_, coefficient)| name == *coefficient);
    effect.parameters.iter().filter(|parameter| is_power(&parameter.name)).count() > 1
}

/// Joins powers of the same driver, axis and kind. The result stands where the strongest of them stood and has the name
/// of the lowest and the form of the highest.
pub(crate) fn join_powers(effects: &mut Vec<Effect>) {
    let mut at = 0;
    while at < effects.len() {
        let is_part = |other: &Effect| {
            let one = &effects[at];
            let powers = (power(one), power(other));
            // The same power twice differs in another number, such as the width of a hysteresis.
            let (Some(mine), Some(its)) = powers else { return false };
            (std::ptr::eq(one, other) || mine != its)
                && (&one.term, one.axis, &one.drivers) == (&other.term, other.axis, &other.drivers)
        };
        let parts: Vec<usize> = (at..effects.len()).filter(|&i| is_part(&effects[i])).collect();
        if parts.len() > 1 {
            let mut members: Vec<Effect> =
                parts.iter().rev().map(|&part| effects.remove(part)).collect();
            members.sort_by_key(power);
            effects.splice(at..at, members.into_iter().reduce(join));
        }
        at += 1;
    }
}

/// `lower` and the next higher power as one; what may stand in its place comes from the more significant of the two.
fn join(lower: Effect, higher: Effect) -> Effect {
    let [mut joined, mut higher] = [lower, higher].map(named_by_power);
    let coefficients =
        joined.parameters.iter().filter(|one| POWERS.iter().any(|p| p.1 == one.name));
    let at = coefficients.count();
    joined.parameters.splice(at..at, higher.parameters.drain(..1));
    joined.form = higher.form;
    joined.held_out_before = joined.held_out_before.max(higher.held_out_before);
    if higher.p_value < joined.p_value {
        (joined.p_value, joined.rivals) = (higher.p_value, higher.rivals);
    }
    joined
}

/// The effect with its coefficient named after its power.
fn named_by_power(mut effect: Effect) -> Effect {
    let is_joined = is_polynomial(&effect);
    if let (Some(power), false) = (power(&effect), is_joined)
        && let Some(first) = effect.parameters.first_mut()
    {
        POWERS[power].1.clone_into(&mut first.name);
    }
    effect
}

#[cfg(test)]
mod tests {
    use super::{is_polynomial, join_powers};
    use crate::finding::{Effect, Parameter};

    fn effect(form: &str, driver: &str, p_value: f64) -> Effect {
        let coefficient = if form == "linear" { "slope" } else { "coefficient" };
        let parameters = [coefficient, "origin", "seen_from"].map(|name| Parameter {
            name: name.to_owned(),
            value: 1.0,
            standard_error: None,
            unit: "1".to_owned(),
            range: None,
        });
        Effect {
            name: format!("{driver}_{form}"),
            known: true,
            term: "bias".to_owned(),
            axis: None,
            drivers: vec![driver.to_owned()],
            form: form.to_owned(),
            knots: Vec::new(),
            knots_2: Vec::new(),
            parameters: parameters.to_vec(),
            p_value,
            held_out_before: p_value,
            held_out_after: 0.0,
            rivals: Vec::new(),
        }
    }

    #[test]
    fn powers_of_one_driver_are_one_effect() {
        let mut effects = vec![
            effect("quadratic", "temperature", 1e-9),
            effect("linear", "supply", 1e-8),
            effect("cubic", "temperature", 1e-5),
            effect("linear", "temperature", 1e-3),
        ];
        join_powers(&mut effects);
        let [joined, alone] = effects.as_slice() else { panic!("{effects:?}") };
        assert_eq!((joined.name.as_str(), joined.form.as_str()), ("temperature_linear", "cubic"));
        let names: Vec<&str> = joined.parameters.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names, ["slope", "quadratic", "cubic", "origin", "seen_from"]);
        assert_eq!((joined.p_value, joined.held_out_before), (1e-9, 1e-3));
        assert!(is_polynomial(joined) && !is_polynomial(alone));
        let mut two =
            ["branch_of(temperature)"; 2].map(|driver| effect("linear", driver, 1e-4)).to_vec();
        join_powers(&mut two);
        assert!(two.len() == 2 && !is_polynomial(&two[0]));
        assert_eq!(alone.parameters[0].name, "slope");
    }
}
