//! The description of a unit (`modelDescription.xml`).

use crate::IDENTIFIER;
use crate::variables::{Role, Variable, variables};
use described::Description;
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Versions of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

/// The text as the value of an attribute.
fn text(value: &str) -> String {
    let mut safe = String::new();
    for c in value.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            // XML has no other control characters.
            c if c.is_control() => safe.push(' '),
            c => safe.push(c),
        }
    }
    safe
}

/// The description of a device as a unit with the identity `token`.
pub fn model_description(description: &Description, version: Version, token: &str) -> String {
    let all = variables(description);
    let (number, identity) = match version {
        Version::Two => ("2.0", "guid"),
        Version::Three => ("3.0", "instantiationToken"),
    };
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let mut line =
        |depth: usize, content: String| _ = writeln!(xml, "{:1$}{content}", "", 2 * depth);
    let (name, title) = (text(&description.name), text(&description.title));
    let tool = concat!("hil ", env!("CARGO_PKG_VERSION"));
    line(
        0,
        format!(
            "<fmiModelDescription fmiVersion=\"{number}\" modelName=\"{name}\" {identity}=\"{}\" description=\"{title}\" \
         generationTool=\"{tool}\" variableNamingConvention=\"structured\">",
            text(token)
        ),
    );
    let state = match version {
        Version::Two => "canGetAndSetFMUstate",
        Version::Three => "canGetAndSetFMUState",
    };
    line(
        1,
        format!(
            "<CoSimulation modelIdentifier=\"{IDENTIFIER}\" canHandleVariableCommunicationStepSize=\"true\" {state}=\"true\"/>"
        ),
    );
    let units: BTreeSet<&str> =
        all.iter().map(|one| &*one.unit).filter(|unit| !unit.is_empty()).collect();
    line(1, "<UnitDefinitions>".to_owned());
    for unit in units {
        line(2, format!("<Unit name=\"{}\"/>", text(unit)));
    }
    line(1, "</UnitDefinitions>".to_owned());
    line(1, "<DefaultExperiment startTime=\"0\" stopTime=\"10\" stepSize=\"0.01\"/>".to_owned());
    line(1, "<ModelVariables>".to_owned());
    for (place, variable) in all.iter().enumerate() {
        line(2, element(place, variable, version));
    }
    line(1, "</ModelVariables>".to_owned());
    line(1, "<ModelStructure>".to_owned());
    let outputs = all.iter().enumerate();
    let outputs: Vec<_> = outputs
        .filter(|(_, one)| matches!(one.role, Role::Output(..)))
        .map(|(place, _)| match version {
            // Counted from 1.
            Version::Two => format!("<Unknown index=\"{}\"/>", place + 1),
            Version::Three => format!("valueReference=\"{place}\""),
        })
        .collect();
    match version {
        Version::Two if outputs.is_empty() => {}
        Version::Two => {
            for tag in ["Outputs", "InitialUnknowns"] {
                line(2, format!("<{tag}>{}</{tag}>", outputs.concat()));
            }
        }
        Version::Three => {
            for tag in ["Output", "InitialUnknown"] {
                outputs.iter().for_each(|output| line(2, format!("<{tag} {output}/>")));
            }
        }
    }
    line(1, "</ModelStructure>".to_owned());
    line(0, "</fmiModelDescription>".to_owned());
    xml
}

fn element(place: usize, variable: &Variable, version: Version) -> String {
    let Variable { name, role, start, range, unit, doc } = variable;
    let (causality, variability) = match role {
        Role::Time => ("independent", "continuous"),
        Role::Seed => ("parameter", "fixed"),
        Role::Parameter => ("parameter", "tunable"),
        Role::Input(..) => ("input", "discrete"),
        Role::Output(..) => ("output", "discrete"),
    };
    let mut common = format!("name=\"{}\" valueReference=\"{place}\"", text(name));
    if !doc.is_empty() {
        _ = write!(common, " description=\"{}\"", text(doc));
    }
    _ = write!(common, " causality=\"{causality}\" variability=\"{variability}\"");
    let mut own = String::new();
    match role {
        Role::Time => {}
        Role::Output(..) => common.push_str(" initial=\"calculated\""),
        // In 2.0 an input has no `initial`, and in both its start is exact.
        Role::Input(..) => _ = write!(own, " start=\"{start}\""),
        Role::Seed | Role::Parameter => {
            common.push_str(" initial=\"exact\"");
            _ = write!(own, " start=\"{start}\"");
        }
    }
    for (key, limit) in [("min", range.0), ("max", range.1)] {
        if limit.is_finite() {
            _ = write!(own, " {key}=\"{limit}\"");
        }
    }
    if !unit.is_empty() {
        _ = write!(own, " unit=\"{}\"", text(unit));
    }
    match version {
        Version::Two => format!("<ScalarVariable {common}><Real{own}/></ScalarVariable>"),
        Version::Three => format!("<Float64 {common}{own}/>"),
    }
}
