//! The fixed evaluation of the identification: data with a known cause, generated from the published error models alone
//! and independent of the library of causes that the identification searches, and the score.
//!
//! `cargo run --release -p evaluation` generates and identifies every case, and writes the figures.

pub mod catalogue;
pub mod design;
pub mod figures;
pub mod laps;
pub mod measured;
pub mod noise;
pub mod odometry;
pub mod package;
pub mod poses;
pub mod programme;
pub mod quantity;
pub mod random;
pub mod run;
pub mod score;
pub mod series;
pub mod table;
pub mod truth;
pub mod turns;
pub mod world;
