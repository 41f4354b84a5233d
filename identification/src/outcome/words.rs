//! A finding as one would say it to a colleague.

use crate::finding::{Effect, Finding, HeldOut, Parameter, Verdict};

impl Finding {
    /// What was found, in a few sentences: the causes, what they bring on runs that took no part, and what else would.
    pub fn in_words(&self) -> Vec<String> {
        let mut said: Vec<String> = self.effects.iter().take(CAUSES_MAX).map(cause).collect();
        if self.effects.len() > CAUSES_MAX {
            said.push(format!("{} smaller effects are below.", self.effects.len() - CAUSES_MAX));
        }
        if self.effects.is_empty() {
            said.push(
                match self.verdict {
                    Verdict::NothingMissing => {
                        "The model given leaves nothing but noise: these data give no reason to add anything."
                    }
                    _ => "No cause that was tried lowers the error on runs that took no part in the fit.",
                }
                .to_owned(),
            );
        } else {
            let fell = |one: &&HeldOut| one.after < one.before;
            let falls: Vec<String> = std::iter::once(&self.held_out)
                .chain(&self.held_out_also)
                .filter(fell)
                .map(|one| {
                    let of = one
                        .quantity
                        .as_deref()
                        .map_or(String::new(), |of| format!(" of {}", plain(of)));
                    format!(
                        "error{of} falls from {} to {} {}",
                        short(one.before),
                        short(one.after),
                        one.unit
                    )
                })
                .collect();
            if !falls.is_empty() {
                said.push(format!(
                    "With that the {}, on runs that took no part in the fit.",
                    falls.join(", the ")
                ));
            }
            said.extend(self.beyond());
        }
        said
    }

    /// What the richest model of the path would still bring.
    fn beyond(&self) -> Option<String> {
        let chosen = self.path.iter().position(|model| model.chosen)?;
        let model = &self.path[chosen];
        let mut more: Vec<String> = Vec::new();
        for (name, error) in &model.held_out {
            let best = self.path[chosen..]
                .iter()
                .filter_map(|other| other.held_out.get(name))
                .fold(error.value, |best, other| best.min(other.value));
            if best < error.value {
                let gain = short(error.value - best);
                more.push(format!("{} by {gain} {}", plain(name), error.unit));
            }
        }
        if more.is_empty() {
            return Some("No further cause that was tried lowers it.".to_owned());
        }
        Some(format!(
            "What else was tried lowers the error of {}, which is within what is not known.",
            more.join(", of ")
        ))
    }
}

/// Causes that are said one by one.
const CAUSES_MAX: usize = 4;

fn plain(name: &str) -> String {
    name.replace('_', " ")
}

/// With three digits that count.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let places = (2.0 - value.abs().log10().floor()).max(0.0) as usize;
    format!("{value:.places$}")
}

/// A cause in a sentence.
fn cause(effect: &Effect) -> String {
    let first = effect.parameters.first();
    let value = first.map_or(f64::NAN, |one| one.value);
    let of = effect.axis.map_or(String::new(), |axis| format!(" of axis {axis:?}").to_lowercase());
    let percent = || short(100.0 * value.abs());
    let more_or_less =
        |more: &'static str, less: &'static str| if value > 0.0 { more } else { less };
    let is_constant = effect.form == "constant";
    match (effect.term.as_str(), effect.name.as_str()) {
        ("scale", "reversed_sign") => format!("What is measured{of} has the wrong sign."),
        ("scale", name) if name.ends_with("for_radians") || name.ends_with("for_degrees") => {
            format!("What is measured{of} is in another unit than its file says: {}.", plain(name))
        }
        ("turn", _) if is_constant && value > -1.0 => format!(
            "The robot turns as if its wheels stood {} times as far apart as the package says.",
            short(1.0 / (1.0 + value))
        ),
        ("drive", _) if is_constant => {
            format!(
                "It drives {} % {} than the wheels say.",
                percent(),
                more_or_less("farther", "less far")
            )
        }
        ("curvature", _) if is_constant => format!(
            "It drifts to the {} by {} {} while it drives straight: the wheels are unequal.",
            more_or_less("left", "right"),
            short(value.abs()),
            first.map_or("", |one| one.unit.as_str())
        ),
        ("delay", "delay") => format!(
            "What is measured{of} comes {} ms {} than the reference.",
            short(1e3 * value.abs()),
            more_or_less("later", "earlier")
        ),
        ("delay", "bandwidth") => {
            format!(
                "What is measured{of} follows with a time constant of {} ms.",
                short(1e3 * value)
            )
        }
        _ => format!(
            "{}{of}: {} by {}{}.",
            plain(&effect.name),
            plain(&effect.term),
            if effect.drivers.is_empty() {
                "itself".to_owned()
            } else {
                effect.drivers.join(" and ")
            },
            first.filter(|_| !effect.form.starts_with("s")).map_or(String::new(), number)
        ),
    }
}

fn number(parameter: &Parameter) -> String {
    let Parameter { name, value, unit, .. } = parameter;
    let unit = if unit == "1" { "" } else { unit.as_str() };
    format!(", {} {} {unit}", plain(name), short(*value)).trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::{cause, short};
    use crate::finding::{Effect, Parameter};

    fn effect(name: &str, term: &str, form: &str, value: f64, unit: &str) -> Effect {
        Effect {
            name: name.to_owned(),
            known: true,
            term: term.to_owned(),
            axis: None,
            drivers: Vec::new(),
            form: form.to_owned(),
            knots: Vec::new(),
            knots_2: Vec::new(),
            parameters: vec![Parameter {
                name: "value".to_owned(),
                value,
                standard_error: None,
                unit: unit.to_owned(),
                range: None,
            }],
            p_value: 0.0,
            held_out_before: 1.0,
            held_out_after: 0.5,
            rivals: Vec::new(),
        }
    }

    #[test]
    fn causes_are_said_as_an_engineer_says_them() {
        assert_eq!(
            cause(&effect("effective_track", "turn", "constant", -0.5, "1")),
            "The robot turns as if its wheels stood 2.00 times as far apart as the package says."
        );
        assert_eq!(
            cause(&effect("delay", "delay", "delay", 0.00425, "s")),
            "What is measured comes 4.25 ms later than the reference."
        );
        assert_eq!([short(104.87), short(0.00480), short(12.359)], ["105", "0.00480", "12.4"]);
    }
}
