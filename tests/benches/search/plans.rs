//! The plans in which mutants are searched for.

use controller::Mutant;
use harness::run::Prepared;
use plan::Plan;
use plan::made::Made;
use std::sync::Arc;

/// Two small squares, one in each direction, with a bias test before each: two minutes.
const TWO_SQUARES: &str = r#"
name = "two-squares"
title = "A square of a metre each way"
devices = "paper-robot"
steps = [
    { use_calibration = "temperature" },
    { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
    { bias_test = { duration_s = 20 } },
    { lap = { direction = "cw", side_m = 1, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
    { bias_test = { duration_s = 20 } },
    { lap = { direction = "ccw", side_m = 1, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
]

[[measurement]]
name = "return_heading"
doc = "Heading after a lap"
quantity = "lap.return_heading"
unit = "deg"
check = { all_within = [-1.2, 1.2] }
"#;

/// More than sixty turns in the same direction: half an hour.
const SIXTY_TURNS: &str = r#"
name = "sixty-turns"
title = "Small squares, all the same way"
devices = "paper-robot"
steps = [
    { use_calibration = "temperature" },
    { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
    { repeat = { times = 31, steps = [
        { bias_test = { duration_s = 20 } },
        { lap = { direction = "ccw", side_m = 0.5, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
        { lap = { direction = "ccw", side_m = 0.5, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
    ] } },
]

[[measurement]]
name = "return_heading"
doc = "Heading after a lap"
quantity = "lap.return_heading"
unit = "deg"
check = { all_within = [-2, 2] }
"#;

/// Returns the plan for this mutant, the same for every search.
pub fn prepared(mutant: Mutant) -> Prepared {
    let (file, text) = match mutant {
        Mutant::OverflowAfterLongRuns => ("sixty-turns.toml", SIXTY_TURNS),
        _ => ("two-squares.toml", TWO_SQUARES),
    };
    let mut prepared = Prepared::load("laps-corrected", &Made::default()).expect("the plan ships");
    prepared.plan = Arc::new(Plan::parse(file, text).expect("a good plan"));
    prepared
}
