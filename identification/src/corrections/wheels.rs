//! What the wheels of a robot say.

use crate::dataset::{Dataset, Role};
use crate::problem::{Channels, TRACK, motion};

/// Motion of each row by the wheels, if a metre counts as half a radian of both: the distance, and half the difference.
pub(super) struct Wheels {
    pub distance: Vec<f64>,
    pub side: Vec<f64>,
    /// Metres of `side` for a turn of one radian, as the package says.
    pub metres_per_radian: f64,
}

impl Wheels {
    pub fn new(dataset: &Dataset) -> Option<Self> {
        let channels = Channels::new(dataset);
        let found = motion(dataset, &channels).ok()?;
        let track = TRACK.iter().find_map(|name| dataset.constants.get(*name));
        let is_pair = dataset.column(Role::WheelLeft).is_some();
        let metres_per_radian = match track {
            Some(track) if is_pair => track.si() / 2.0,
            _ => 1.0,
        };
        let side = found.turn.iter().map(|turn| turn * metres_per_radian).collect();
        Some(Self { distance: found.distance, side, metres_per_radian })
    }
}
