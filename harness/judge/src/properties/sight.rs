//! What a bench shows of a run, and which properties can be judged by it. In virtual time everything is seen; of
//! real devices nobody knows the truth, and a line between a real device and a controller that is a process of its
//! own is heard by nobody else.

use super::{Always, Kind, Property, Sometimes};
use record::outcome::PropertySummary;
use std::collections::BTreeMap;

/// Something that a property is judged by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum View {
    /// What is true of the base.
    Truth,
    /// What the controller hears from the gyro.
    GyroLine,
    /// What the controller hears from the base.
    BaseReplies,
    /// What the controller sends to the base, when it sends it.
    BaseRequests,
    /// The states of error of the nodes of the base's bus.
    BusStates,
    /// Reports as they are, before they become lines of text.
    PlainReports,
    /// What the nodes of a rig send.
    Messages,
}

/// What is not seen on a bench, and why.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Sight {
    hidden: BTreeMap<View, String>,
}

/// A property that a run cannot judge.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unjudged {
    /// As a plan writes it.
    pub name: String,
    /// Which kind.
    pub kind: Kind,
    /// Why: what it is judged by, and why that is not seen.
    pub why: String,
}

impl From<&Unjudged> for PropertySummary {
    fn from(unjudged: &Unjudged) -> Self {
        Self {
            name: unjudged.name.clone(),
            always: unjudged.kind == Kind::Always,
            held: None,
            not_judged: Some(unjudged.why.clone()),
            margin: None,
            broken_s: None,
            what: None,
        }
    }
}

impl Sight {
    /// Of everything.
    pub fn whole() -> Self {
        Self::default()
    }

    /// Without this, for this reason: a clause such as "the gyro is real".
    #[must_use]
    pub fn without(mut self, view: View, why: impl Into<String>) -> Self {
        self.hidden.entry(view).or_insert_with(|| why.into());
        self
    }

    /// Is this seen?
    pub fn has(&self, view: View) -> bool {
        !self.hidden.contains_key(&view)
    }

    /// Those of `properties` that can be judged, and the others, each in their order.
    pub fn divide(&self, properties: &[Property]) -> (Vec<Property>, Vec<Unjudged>) {
        let (mut judged, mut unjudged) = (Vec::new(), Vec::new());
        for property in properties {
            match self.missing(property) {
                None => judged.push(property.clone()),
                Some(why) => {
                    let (name, kind) = (property.name().to_owned(), property.kind());
                    unjudged.push(Unjudged { name, kind, why });
                }
            }
        }
        (judged, unjudged)
    }

    /// Why a property cannot be judged; `None` where it can.
    fn missing(&self, property: &Property) -> Option<String> {
        needs(property).iter().find_map(|view| {
            self.hidden.get(view).map(|why| format!("it is judged by {}: {why}", view.what()))
        })
    }
}

impl View {
    const fn what(self) -> &'static str {
        match self {
            Self::Truth => "what is true of the base",
            Self::GyroLine => "what the controller hears from the gyro",
            Self::BaseReplies => "what the controller hears from the base",
            Self::BaseRequests => "what the controller sends to the base",
            Self::BusStates => "the error states of the base's bus",
            Self::PlainReports => "every number of a report",
            Self::Messages => "the messages of the nodes",
        }
    }
}

/// What a property is judged by, beyond missions and reports.
pub const fn needs(property: &Property) -> &'static [View] {
    use View::{BaseReplies, BaseRequests, BusStates, GyroLine, Messages, PlainReports, Truth};
    match property {
        Property::Always(always) => match always {
            Always::FreshHeading { .. } => &[GyroLine, BaseRequests],
            Always::StopsOnLoss { .. } => &[Truth, GyroLine, BaseReplies],
            Always::WithinLimits { .. } | Always::PoseWrittenAtRest {} => &[Truth, BaseRequests],
            Always::FiniteOutputs {} => &[PlainReports],
            Always::Recovers { .. } => &[GyroLine, BaseReplies],
            Always::DoneIsDone { .. } | Always::NoSilentWrong { .. } => &[Truth],
        },
        Property::Sometimes(Sometimes::Resynchronised) => &[GyroLine],
        Property::Sometimes(Sometimes::BusOff) => &[BusStates],
        Property::Sometimes(_) => &[],
        Property::Stated(_) => &[Messages],
    }
}

#[cfg(test)]
mod tests {
    use super::{Sight, View};
    use crate::properties::{Kind, Property};

    #[test]
    fn all_is_judged_where_all_is_seen() {
        let (judged, unjudged) = Sight::whole().divide(&Property::all());
        assert_eq!((judged, unjudged), (Property::all(), Vec::new()));
    }

    #[test]
    fn what_is_not_seen_is_said_by_name_and_reason() {
        let sight = Sight::whole()
            .without(View::Truth, "the base is real (can:can0)")
            .without(View::GyroLine, "the gyro is real (/dev/ttyUSB0)");
        let (judged, unjudged) = sight.divide(&Property::all());
        assert_eq!(judged.len() + unjudged.len(), Property::all().len());
        assert!(unjudged.iter().filter(|one| one.kind == Kind::Sometimes).count() == 1);
        let lines: Vec<String> =
            unjudged.iter().map(|one| format!("{}: {}", one.name, one.why)).collect();
        insta::assert_snapshot!(lines.join("\n"));
    }
}
