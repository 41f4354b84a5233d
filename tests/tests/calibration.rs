//! The shipped calibration is the one that its plan produces.

use harness::operator::Answers;
use harness::run::{Prepared, verdicts};
use plan::calibrations::to_toml;
use plan::library::{Kind, Library};
use plan::made::Made;

#[test]
fn the_shipped_temperature_calibration_is_that_of_seed_1() {
    let prepared = Prepared::load("temperature-calibration", &Made::default()).unwrap();
    let run = verdicts(&prepared, 1, &Answers::default(), &mut |_| true);
    let made = to_toml(
        &run.made.calibrations["temperature"],
        "made by plan temperature-calibration, seed 1",
    );
    let shipped = Library::shipped().open(Kind::Calibration, "temperature").unwrap();
    assert_eq!(shipped.text, made);
}
