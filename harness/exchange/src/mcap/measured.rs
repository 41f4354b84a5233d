//! Poses from the absolute measurement, which come as one observation per coordinate.

use super::foxglove::{BENCH, LAP_START};
use plan::observation::Observation;
use plan::quantities::{
    LAP_RETURN_HEADING, LAP_RETURN_X, LAP_RETURN_Y, POSE_HEADING, POSE_X, POSE_Y, Quantity,
};
use wire::time::Timestamp;
use wire::units::{Angle, Length, Pose};

/// A kind of measured pose: its quantities, topic and frame.
#[derive(Debug)]
pub(super) struct Kind {
    pub(super) topic: &'static str,
    pub(super) frame: &'static str,
    /// x in m, y in m, heading in deg.
    quantities: [&'static Quantity; 3],
}

static KINDS: [Kind; 2] = [
    Kind { topic: "/absolute/pose", frame: BENCH, quantities: [&POSE_X, &POSE_Y, &POSE_HEADING] },
    Kind {
        topic: "/absolute/lap_return",
        frame: LAP_START,
        quantities: [&LAP_RETURN_X, &LAP_RETURN_Y, &LAP_RETURN_HEADING],
    },
];

/// Coordinates observed at one instant.
#[derive(Debug, Default)]
pub(super) struct Measured {
    at: Option<Timestamp>,
    found: [[Option<f64>; 3]; 2],
}

impl Measured {
    /// Takes an observation; returns the pose that it completes.
    pub(super) fn take(
        &mut self,
        at: Timestamp,
        observation: &Observation,
    ) -> Option<(&'static Kind, Pose)> {
        if self.at != Some(at) {
            *self = Self { at: Some(at), ..Self::default() };
        }
        for (kind, found) in KINDS.iter().zip(&mut self.found) {
            let is_it = |one: &&Quantity| one.name == observation.quantity;
            let Some(place) = kind.quantities.iter().position(is_it) else { continue };
            found[place] = Some(observation.value).filter(|value| value.is_finite());
            let [Some(x), Some(y), Some(heading)] = *found else { return None };
            *found = [None; 3];
            let (x, y) = (Length::from_m(x), Length::from_m(y));
            return Some((kind, Pose { x, y, heading: Angle::from_deg(heading) }));
        }
        None
    }
}
