//! Each mutant of the controller violates a property; without a mutant all properties hold.

mod bias_test_while_moving;
mod ccw_sign;
mod missed_sequence_gap;
mod nowhere_else;
mod over_range_ignored;
mod overflow_after_long_runs;
mod pose_written_in_motion;
mod repeated_sample_counted;
mod rows;
mod scenario;
mod stale_heading;
mod unnoticed;
mod watchdog_off_by_ten;
mod wrap_at_360;
