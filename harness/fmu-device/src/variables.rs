//! The variables of a device as those of a unit. Value references are places in this list.

use described::{Description, Sender};

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    pub name: String,
    pub role: Role,
    /// Value at the start, except for outputs.
    pub start: f64,
    /// Smallest and largest value that can be set; infinite without a limit.
    pub range: (f64, f64),
    pub unit: String,
    pub doc: String,
}

/// What a variable is.
#[derive(Debug, Clone, PartialEq)]
pub enum Role {
    Time,
    Seed,
    Parameter,
    /// A received signal, by message and place.
    Input(usize, usize),
    /// A sent signal, by message and place.
    Output(usize, usize),
}

/// The variables of a device: time, seed, parameters, inputs and outputs.
pub fn variables(description: &Description) -> Vec<Variable> {
    let plain = |name: &str, role, start, doc: &str| Variable {
        name: name.to_owned(),
        role,
        start,
        range: (f64::NEG_INFINITY, f64::INFINITY),
        unit: String::new(),
        doc: doc.to_owned(),
    };
    let mut all = vec![
        Variable { unit: "s".to_owned(), ..plain("hil.time", Role::Time, 0.0, "Time") },
        plain(crate::SEED, Role::Seed, 1.0, "Seed of the random numbers"),
    ];
    all.extend(description.parameters().map(|(name, value, unit)| Variable {
        unit: unit.to_owned(),
        range: description.range(name).unwrap_or((f64::NEG_INFINITY, f64::INFINITY)),
        ..plain(name, Role::Parameter, value, description.doc(name).unwrap_or_default())
    }));
    let messages = description.layout().messages();
    for sender in [Sender::Host, Sender::Device] {
        for (message, form) in messages.iter().enumerate().filter(|(_, one)| one.sender == sender) {
            for (place, signal) in form.signals.iter().enumerate() {
                let role = match sender {
                    // Whoever sends the message computes it.
                    Sender::Host if form.is_computed(place) => continue,
                    Sender::Host => Role::Input(message, place),
                    Sender::Device => Role::Output(message, place),
                };
                let name = format!("{}.{}", form.name, signal.name);
                let unit = signal.unit.clone();
                all.push(Variable { unit, ..plain(&name, role, signal.start, &signal.doc) });
            }
        }
    }
    all
}
