//! One wheel of a robot with a wheel on each side.
use super::roughly::estimates;
use super::state::State;
use crate::candidates::constant;
use crate::fit::fit_terms;
use crate::model::{Acts, ONE_WHEEL, Shape, UNEQUAL_WHEELS, WHEEL_SIZE};
use crate::significance::surprise_chi2;

/// Surprise below which a wheel may well be as large as the package says, in nats: 1 %.
const AS_STATED: f64 = 4.6;

/// `state` with the error of one wheel in place of unequal wheels of another size, where the other wheel may well be as
/// large as the package says. The two say the same of both wheels: only the one whose error is zero is a simpler cause. In the place
/// of unequal wheels and another track, it must explain as much.
/// `clustered` takes errors that differ from run to run, for a residual that is not noise.
pub(super) fn one_wheel<'a>(state: &State<'a>, clustered: bool) -> Option<State<'a>> {
    let at = |name: &str| {
        let added = state.base..state.terms.len();
        added.into_iter().find(|&index| state.terms[index].name == name)
    };
    // Where little tells them apart, the size stands as the track.
    let track = at(WHEEL_SIZE).or_else(|| at(constant(Acts::Turn, false)));
    let places = [at(UNEQUAL_WHEELS)?, track?];
    // A robot that steers otherwise has the first name alone.
    state.data.block.pose.as_ref()?.half_track?;
    let mut apart = state.clone();
    for (place, name) in places.into_iter().zip(ONE_WHEEL) {
        apart.terms[place] = Shape::constant(name, Acts::Drive);
    }
    let surprises = if clustered {
        let terms = estimates(&apart).terms;
        places.map(|place| terms[place].strength)
    } else {
        let terms = fit_terms(state.data, &apart.terms, &state.noise);
        places.map(|place| {
            let (value, error) = terms[place].coefficients[0];
            surprise_chi2((value / error).powi(2), 1.0)
        })
    };
    let gone = usize::from(surprises[1] < surprises[0]);
    if !(surprises[gone] < AS_STATED) {
        return None;
    }
    // In the place of the first of the two: the later terms stay where they are.
    let (first, last) = (places[0].min(places[1]), places[0].max(places[1]));
    apart.terms[first] = Shape::constant(ONE_WHEEL[1 - gone], Acts::Drive);
    apart.terms.remove(last);
    apart.families.remove(last - state.base);
    let explains = || apart.likelihood() > state.likelihood() - AS_STATED;
    (state.terms[places[1]].name == WHEEL_SIZE || explains()).then_some(apart)
}
