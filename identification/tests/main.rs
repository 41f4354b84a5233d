//! Findings on data whose causes are known, one subject a file.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod bands;
mod beyond;
mod clipping;
mod comes_and_goes;
mod dense_heading;
mod driven;
mod ends_of_laps;
mod few_causes;
mod first_light;
mod heat;
mod intervals;
mod jumps;
mod known_noise;
mod late;
mod late_car;
mod long_records;
mod marginality;
mod memory;
mod next_experiment;
mod order;
mod outliers;
mod random_walk;
mod recorded;
mod rough_reference;
mod rounding;
mod sensor;
mod set_right;
mod settling;
mod several_axes;
mod simplest;
mod standing;
mod stated;
mod timing;
mod turns;
mod two_wheels;
mod units;
mod zero;
