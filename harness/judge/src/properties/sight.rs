//! What a bench shows of a run, and which properties that suffices for. In virtual time everything is visible. With
//! real devices the truth is unknown, and the harness cannot listen on a line between a real device and a controller
//! that runs as a separate process.

use super::{Always, Kind, Property, Sometimes};
use record::outcome::PropertySummary;
use std::collections::BTreeMap;

/// A signal that a property is judged by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum View {
    /// The true state of the base.
    Truth,
    /// What the controller receives from the gyro.
    GyroLine,
    /// What the controller receives from the base.
    BaseReplies,
    /// What the controller sends to the base, at the time it sends it.
    BaseRequests,
    /// The error states of the nodes of the base's bus.
    BusStates,
    /// Reports before they are written as text.
    PlainReports,
    /// Messages of the nodes of a rig.
    Messages,
}

/// The views that a bench lacks, with the reason.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Sight {
    hidden: BTreeMap<View, String>,
}

/// A property that a run cannot judge.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unjudged {
    /// Name, as in a plan.
    pub name: String,
    /// Kind of property.
    pub kind: Kind,
    /// Why: the view that it needs, and why the bench lacks it.
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
            never_asked: None,
            broken_s: None,
            what: None,
        }
    }
}

impl Sight {
    /// Everything is visible.
    pub fn whole() -> Self {
        Self::default()
    }

    /// Removes a view for this reason, a clause such as "the gyro is real".
    #[must_use]
    pub fn without(mut self, view: View, why: impl Into<String>) -> Self {
        self.hidden.entry(view).or_insert_with(|| why.into());
        self
    }

    /// Whether this view is available.
    pub fn has(&self, view: View) -> bool {
        !self.hidden.contains_key(&view)
    }

    /// Why this view is not available; `None` if it is.
    pub fn why_not(&self, view: View) -> Option<String> {
        self.hidden.get(&view).map(|why| format!("it is judged by {}: {why}", view.what()))
    }

    /// Divides `properties` into those that can be judged and the others, each in order.
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

    /// Why a property cannot be judged; `None` if it can.
    fn missing(&self, property: &Property) -> Option<String> {
        needs(property).iter().find_map(|view| self.why_not(*view))
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

/// The views that a property needs, besides missions and reports.
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
