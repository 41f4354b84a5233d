//! Steps and periods in time.

use super::library::{OPEN, is_open};
use super::names::acts;
use super::{Candidate, Family};
use crate::model::{Acts, Driver, Form, Shape, Wrap};
use crate::problem::{Block, Channels};

/// Number of times at which a step is tried.
const MOMENTS: usize = 48;
/// A step must leave this share of the rows on each side.
const MARGIN: f64 = 0.02;

/// Steps in time.
pub fn steps(block: &Block, channels: &Channels) -> Vec<Candidate> {
    let mut times: Vec<f64> = block.rows.iter().map(|&row| channels.time[row]).collect();
    times.sort_by(f64::total_cmp);
    let n = times.len();
    let mut found = Vec::new();
    for i in 0..MOMENTS {
        let share = MARGIN + (1.0 - 2.0 * MARGIN) * i as f64 / (MOMENTS - 1) as f64;
        let at = times[((n - 1) as f64 * share) as usize];
        for on in OPEN.into_iter().filter(|on| is_open(block, *on)) {
            let driver = Driver::new(Wrap::Step, &channels.time_name);
            let shape = Shape::new(&format!("{}_step", acts(on)), on, driver, Form::Step);
            found.push(Candidate { shape: shape.with("at", at), family: Family::Step });
        }
    }
    found
}

/// A term with a period.
pub fn periodic(on: Acts, channels: &Channels, period: f64) -> Candidate {
    let driver = Driver::new(Wrap::Periodic, &channels.time_name);
    let shape = Shape::new(&format!("{}_periodic", acts(on)), on, driver, Form::Periodic);
    Candidate { shape: shape.with("period", period), family: Family::Periodic }
}
