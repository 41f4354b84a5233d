//! The description of an FMU (`modelDescription.xml`).

use described::{FmuRole, FmuVariable};
use roxmltree::{Document, Node};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Versions of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    Two,
    Three,
}

/// The part of a description that a co-simulation needs.
#[derive(Debug)]
pub struct Model {
    pub version: Version,
    /// The name of its library.
    pub identifier: String,
    /// GUID or instantiation token.
    pub token: String,
    pub step_s: Option<f64>,
    pub once_per_process: bool,
    pub variables: Vec<Variable>,
}

/// A variable.
#[derive(Debug)]
pub struct Variable {
    pub public: FmuVariable,
    pub reference: u32,
    pub kind: Kind,
}

/// How the library is asked for a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Float32,
    Float64,
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Boolean,
    Other,
}

impl Model {
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = |error| format!("its modelDescription.xml is no XML: {error}");
        let document = Document::parse(text).map_err(wrong)?;
        let root = document.root_element();
        let said = root.attribute("fmiVersion").unwrap_or("no version");
        let version = match said.split('.').next() {
            Some("2") => Version::Two,
            Some("3") => Version::Three,
            _ => return Err(format!("it is of FMI {said}, expected 2.0 or 3.0")),
        };
        let Some(coupling) = child(root, "CoSimulation") else {
            let others = [
                ("ModelExchange", "model exchange"),
                ("ScheduledExecution", "scheduled execution"),
            ];
            let others = others.into_iter().filter(|(tag, _)| child(root, tag).is_some());
            let others: Vec<_> = others.map(|(_, name)| name).collect();
            let for_what =
                if others.is_empty() { "nothing".to_owned() } else { others.join(" and ") };
            return Err(format!("it is for {for_what}, expected co-simulation"));
        };
        let is_true = |name: &str| matches!(coupling.attribute(name), Some("true" | "1"));
        let token = match version {
            Version::Two => "guid",
            Version::Three => "instantiationToken",
        };
        let seconds = |node: Option<Node<'_, '_>>, name: &str| -> Option<f64> {
            node?.attribute(name)?.parse().ok().filter(|step: &f64| *step > 0.0 && step.is_finite())
        };
        let step_s = seconds(Some(coupling), "fixedInternalStepSize")
            .or_else(|| seconds(child(root, "DefaultExperiment"), "stepSize"));
        let identifier = required(coupling, "modelIdentifier")?;
        // It is a part of a path.
        if identifier.contains(['/', '\0']) || identifier.starts_with('.') {
            return Err(format!("`{identifier}` is no modelIdentifier"));
        }
        let variables = child(root, "ModelVariables").ok_or("it has no ModelVariables")?;
        let variables = variables.children().filter(Node::is_element);
        let types = types(root);
        let variables = variables.map(|node| Variable::read(&types, node, version));
        Ok(Self {
            version,
            identifier,
            token: required(root, token)?,
            step_s,
            once_per_process: is_true("canBeInstantiatedOnlyOncePerProcess"),
            variables: variables.collect::<Result<_, _>>()?,
        })
    }

    pub fn variables(&self) -> Vec<FmuVariable> {
        self.variables.iter().map(|variable| variable.public.clone()).collect()
    }
}

impl Variable {
    fn read(types: &Types<'_>, node: Node<'_, '_>, version: Version) -> Result<Self, String> {
        let name = required(node, "name")?;
        // In FMI 2.0 the type is an element of its own.
        let typed = match version {
            Version::Two => node.children().find(Node::is_element),
            Version::Three => Some(node),
        };
        let typed = typed.ok_or_else(|| format!("its variable `{name}` has no type"))?;
        let tag = typed.tag_name().name();
        let kind = match tag {
            "Real" | "Float64" => Kind::Float64,
            "Float32" => Kind::Float32,
            "Integer" | "Int32" => Kind::Int32,
            "Enumeration" if version == Version::Two => Kind::Int32,
            "Enumeration" | "Int64" => Kind::Int64,
            "Int8" => Kind::Int8,
            "UInt8" => Kind::UInt8,
            "Int16" => Kind::Int16,
            "UInt16" => Kind::UInt16,
            "UInt32" => Kind::UInt32,
            "UInt64" => Kind::UInt64,
            "Boolean" => Kind::Boolean,
            _ => Kind::Other,
        };
        let no_number = match kind {
            Kind::Other => Some(format!("a {tag}")),
            _ if child(typed, "Dimension").is_some() => Some("an array".to_owned()),
            _ => None,
        };
        let reference = required(node, "valueReference")?;
        let public = FmuVariable {
            role: match node.attribute("causality") {
                Some("input") => FmuRole::Input,
                Some("output") => FmuRole::Output,
                Some("parameter" | "structuralParameter") => FmuRole::Parameter,
                _ => FmuRole::Local,
            },
            tunable: node.attribute("variability") == Some("tunable"),
            no_number,
            unit: unit(types, typed).to_owned(),
            doc: node.attribute("description").unwrap_or_default().to_owned(),
            name,
        };
        let reference = reference.parse().map_err(|_| {
            format!("`{reference}` is no valueReference, at its variable `{}`", public.name)
        })?;
        Ok(Self { public, reference, kind })
    }

    pub const fn place(&self) -> (u32, Kind) {
        (self.reference, self.kind)
    }
}

impl Kind {
    /// Whole numbers that it holds.
    pub fn range(self) -> Option<RangeInclusive<f64>> {
        Some(match self {
            Self::Int8 => f64::from(i8::MIN)..=f64::from(i8::MAX),
            Self::UInt8 => 0.0..=f64::from(u8::MAX),
            Self::Int16 => f64::from(i16::MIN)..=f64::from(i16::MAX),
            Self::UInt16 => 0.0..=f64::from(u16::MAX),
            Self::Int32 => f64::from(i32::MIN)..=f64::from(i32::MAX),
            Self::UInt32 => 0.0..=f64::from(u32::MAX),
            Self::Int64 => i64::MIN as f64..=i64::MAX as f64,
            Self::UInt64 => 0.0..=u64::MAX as f64,
            Self::Float32 | Self::Float64 | Self::Boolean | Self::Other => return None,
        })
    }
}

type Types<'a> = BTreeMap<&'a str, &'a str>;

fn types<'a>(root: Node<'a, '_>) -> Types<'a> {
    let all = child(root, "TypeDefinitions");
    let unit = |declared: Node<'a, '_>| {
        let inner = || declared.children().find_map(|node| node.attribute("unit"));
        Some((declared.attribute("name")?, declared.attribute("unit").or_else(inner)?))
    };
    all.iter().flat_map(Node::children).filter_map(unit).collect()
}

/// The unit of a variable or of its declared type.
fn unit<'a>(types: &Types<'a>, typed: Node<'a, '_>) -> &'a str {
    let of_type = || types.get(typed.attribute("declaredType")?).copied();
    typed.attribute("unit").or_else(of_type).unwrap_or_default()
}

fn child<'a, 'b>(node: Node<'a, 'b>, tag: &str) -> Option<Node<'a, 'b>> {
    node.children().find(|child| child.has_tag_name(tag))
}

fn required(node: Node<'_, '_>, name: &str) -> Result<String, String> {
    let value = node.attribute(name).map(str::to_owned);
    value.ok_or_else(|| format!("a {} of it has no {name}", node.tag_name().name()))
}
