//! Deliberate faults of a table.

use super::{STEPS_PER_ELECTRICAL_CYCLE, TableEmulator};
use wire::time::Timestamp;

impl TableEmulator {
    /// Stops the rotor until the field is `steps` ahead, rounded to whole electrical cycles; then it follows again. At
    /// rest this applies to the next move. A move that is too short loses correspondingly less.
    pub fn lose_steps(&mut self, now: Timestamp, steps: f64) {
        self.wake(now);
        let cycles = libm::round(steps / STEPS_PER_ELECTRICAL_CYCLE).max(0.0);
        self.mechanics.stand(&self.profile, now, cycles * STEPS_PER_ELECTRICAL_CYCLE);
    }
}

#[cfg(test)]
mod tests {
    use super::TableEmulator;
    use crate::table::TableParameters;
    use wire::table::Command;
    use wire::time::Timestamp;

    #[test]
    fn steps_are_lost_for_good_and_the_indexer_knows_nothing() {
        for (at_s, steps) in [(-1.0, 80.0), (5.0, 80.0), (5.0, 83.0)] {
            let mut table = TableEmulator::new(TableParameters::default());
            let begin = Timestamp::from_secs_f64(1.0);
            let at = Timestamp::from_secs_f64(1.0 + at_s);
            if at < begin {
                table.lose_steps(at, steps);
            }
            table.command(begin, Command::Distance(-28_800));
            table.command(begin, Command::Go);
            if at > begin {
                table.lose_steps(at, steps);
                assert_eq!(table.steps_lost_at(at), 0.0, "it only begins to stand");
            }
            let end = Timestamp::from_secs_f64(100.0);
            table.wake(end);
            assert_eq!(table.steps_lost_at(end), -80.0);
            let lost_deg = table.angle_at(end).deg() + 360.0;
            assert!((lost_deg - 1.0).abs() < 1e-9, "{lost_deg}");
        }
    }
}
