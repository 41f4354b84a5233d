//! The paper's laps, with a calibration that corrects each turn by some degrees.

use super::scenario::caught;
use controller::Mutant;
use harness::operator::Answers;
use harness::run::{Prepared, simulate_watched};
use plan::made::Made;
use record::sink::NullSink;

#[test]
fn a_lap_goes_wrong_in_silence() {
    for property in ["no_silent_wrong", "done_is_done"] {
        caught(Mutant::CcwSign, property, |mutant| {
            let mut prepared =
                Prepared::load("laps-corrected", &Made::default()).expect("the plan ships");
            prepared.mutant = mutant;
            let answers = Answers::default();
            simulate_watched(&prepared, 1, &answers, &mut NullSink, &mut |_| true).properties
        });
    }
}
