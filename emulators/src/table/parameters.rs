//! The imperfections of a rotary table, each a named number.

use crate::parameters::parameters;

parameters! {
    /// Limits and imperfections of a stepper-driven rotary table. The default is an ideal one.
    pub struct TableParameters {
        /// Angle of a step: 0.0125 for half steps of a 1.8 deg motor behind a 72:1 gear (assumption).
        step_deg: POSITIVE = 0.9 / 72.0,
        /// Fastest step rate that the indexer accepts.
        rate_max_steps_per_s: LIMIT = f64::INFINITY,
        /// Hardest ramp that motor and load follow; beyond it steps are lost.
        acceleration_limit_steps_per_s2: LIMIT = f64::INFINITY,
        /// Play of the gear: what a reversal turns before the table follows. This class: 0.01 to 0.1.
        backlash_deg: NOT_NEGATIVE = 0.0,
        /// Eccentricity, once a turn: amplitude of true less ideal angle. This class: 0.01 to 0.05.
        eccentricity_1x_deg: FINITE = 0.0,
        /// Where the table stands in that cycle at power-up.
        eccentricity_1x_phase_deg: FINITE = 0.0,
        /// The same, twice a turn (an oval wheel).
        eccentricity_2x_deg: FINITE = 0.0,
        /// Where the table stands in that cycle at power-up.
        eccentricity_2x_phase_deg: FINITE = 0.0,
    }
}
