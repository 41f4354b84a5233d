//! The quantities that a run can measure: the contract between the engine, which observes, and plans, which judge. To
//! add a quantity, add an entry to the table below.
//!
//! Every observation has the [`COMMON_TAGS`]. Within a step it also has `during.<step>` = 1 for each enclosing step,
//! and `during.<label>` if that step has a label; within a sweep, the swept parameter under its own name.

use std::collections::BTreeSet;

/// A quantity: its meaning, its unit, and the tags of its observations.
#[derive(Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Name in plans and records.
    pub name: &'static str,
    /// Unit of its values, `1` for a plain number.
    pub unit: &'static str,
    /// Tags beyond the [`COMMON_TAGS`].
    pub tags: &'static [&'static str],
    /// The step that yields it, or `always`.
    pub made_by: &'static str,
    /// Description.
    pub doc: &'static str,
}

/// A tag and its unit.
#[derive(Debug, PartialEq, Eq)]
pub struct Tag {
    /// Name.
    pub name: &'static str,
    /// Unit of its values, `1` for a plain number.
    pub unit: &'static str,
    /// Description.
    pub doc: &'static str,
}

/// Tags of every observation.
pub const COMMON_TAGS: &[&str] = &["run", "time"];

/// All tags of observations, except `during.*` and swept parameters.
pub const TAGS: &[Tag] = &[
    Tag {
        name: "run",
        unit: "1",
        doc: "which repetition of the innermost repeat, from 1; goes on counting when it is entered again",
    },
    Tag { name: "time", unit: "s", doc: "bench time of the observation" },
    Tag { name: "direction", unit: "1", doc: "+1 counter-clockwise, -1 clockwise" },
    Tag {
        name: "temperature",
        unit: "degC",
        doc: "temperature that the gyro told; of a turn or a lap the mean of before and after",
    },
    Tag { name: "duration", unit: "s", doc: "time between the states before and after" },
    Tag { name: "bias", unit: "deg/s", doc: "bias that was subtracted" },
    Tag { name: "angle", unit: "deg", doc: "angle that was ordered" },
    Tag { name: "table_rate", unit: "deg/s", doc: "rate that the table was told, without sign" },
    Tag { name: "acceleration", unit: "deg/s2", doc: "acceleration that the table was told" },
    Tag {
        name: "heading",
        unit: "deg",
        doc: "heading of the table before, from where the run began",
    },
    Tag { name: "age", unit: "s", doc: "time since the bias test whose bias is in force" },
];

/// Prefix of the tag for observations during a step; the step's name or label follows.
pub const DURING_PREFIX: &str = "during.";

/// Tag of a reaction that had no answer yet when the run ended, and of a gap since the last message: the value of the
/// observation is the time until then.
pub const OPEN_TAG: &str = "open";
/// Value of that tag for what was open when the run ended.
pub const OPEN_AT_END: f64 = 1.0;
/// Value of that tag for a gap that was open when a step ended: it counts for the measurements of that step alone.
pub const OPEN_AT_STEP: f64 = 2.0;

/// Prefix of the tag for the time before the first message; since when it counts follows: a step's name or label, or
/// [`SINCE_START`]. It counts for the measurements that say so.
pub const SINCE_PREFIX: &str = "since.";
/// The start of the run.
pub const SINCE_START: &str = "start";

/// Whether what is still `open`, a value of that tag, after `value` is no observation yet of a measurement that allows at
/// most `most`: it might end in time. What was open when a step ended says nothing of the whole run.
pub fn is_undecided(open: f64, value: f64, most: Option<f64>, is_of_step: bool) -> bool {
    (open == OPEN_AT_STEP && !is_of_step) || most.is_none_or(|most| value <= most)
}

/// Prefix of a signal, `Signal` or `Message.Signal`: its values, in the unit of the layout.
pub const SIGNAL: &str = "signal";
/// Prefix of a message of a device: the time between consecutive messages, s.
pub const PERIOD: &str = "period";
/// Prefix of a reaction: its duration, s.
pub const REACTION_PREFIX: &str = "reaction.";
/// Prefix of an object that an `sdo` step reads: its value, in its unit.
pub const SDO_PREFIX: &str = "sdo.";
/// Prefix of an answer: the quantity that an operator gives.
pub const OPERATOR_PREFIX: &str = "operator.";
/// Prefix of a number that a diagnostic request reads.
pub const UDS_PREFIX: &str = "uds.";
/// Prefix of a line: how much came on it, in the whole run, that is not a valid message of its nodes.
pub const UNEXPECTED_PREFIX: &str = "unexpected.";
/// Prefixes of the quantities whose names a plan or its rig chooses, and what such a quantity is.
pub(crate) const CHOSEN: [(&str, &str); 5] = [
    (
        UNEXPECTED_PREFIX,
        "How much came on this line, in the whole run, that is not a valid message of its nodes.",
    ),
    (REACTION_PREFIX, "How long this reaction took, s."),
    (OPERATOR_PREFIX, "What an operator answers."),
    (UDS_PREFIX, "A number that a step `uds` reads."),
    (SDO_PREFIX, "What an `sdo` step reads, in the unit of the object."),
];

/// What stands before the first dot in the names of quantities, without signals that begin with the name of a node: a node
/// cannot have such a name.
pub(crate) fn families() -> BTreeSet<&'static str> {
    let chosen = CHOSEN.iter().map(|(prefix, _)| *prefix);
    let names = NAMES.iter().copied().chain(chosen).chain([SIGNAL, PERIOD]);
    names.map(|name| name.split_once('.').map_or(name, |(family, _)| family)).collect()
}

/// The tag of observations made during `phase`, a step's name or label.
pub fn during_tag(phase: &str) -> String {
    format!("{DURING_PREFIX}{phase}")
}

/// The quantity with this name.
pub fn find(name: &str) -> Option<&'static Quantity> {
    QUANTITIES.iter().copied().find(|quantity| quantity.name == name)
}

/// The tag with this name.
pub fn find_tag(name: &str) -> Option<&'static Tag> {
    TAGS.iter().find(|tag| tag.name == name)
}

macro_rules! quantities {
    ($($(#[doc = $doc:literal])+ $id:ident: $name:literal, $unit:literal, [$($tag:literal),*], $by:literal;)*) => {
        $(
            $(#[doc = $doc])+
            pub static $id: Quantity = Quantity {
                name: $name,
                unit: $unit,
                tags: &[$($tag),*],
                made_by: $by,
                doc: concat!($($doc),+).trim_ascii(),
            };
        )*
        /// Every quantity.
        pub static QUANTITIES: &[&Quantity] = &[$(&$id),*];
        /// Their names.
        pub const NAMES: &[&str] = &[$($name),*];
    };
}

/// Quantities that the engine forms with the true pose of the base, which nobody knows of a real one.
pub static OF_TRUTH: [&Quantity; 6] = [
    &STRAIGHT_TRUE_STOP_ERROR,
    &STRAIGHT_TRUE_HEADING_ERROR,
    &TURN_TRUE_STOP_ERROR,
    &BASE_POSE_X_ERROR,
    &BASE_POSE_Y_ERROR,
    &BASE_POSE_HEADING_ERROR,
];

quantities! {
    /// Mean of the readings of a static bias test.
    BIAS_MEAN: "bias.mean", "deg/s", ["temperature"], "bias_test";
    /// Standard deviation of the readings of a static bias test.
    BIAS_SPREAD: "bias.spread", "deg/s", ["temperature"], "bias_test";
    /// Mean rate of a later window at rest, minus the last static bias test.
    BIAS_RESIDUAL_TEST: "bias.residual_test", "deg/s", ["temperature", "age"], "bias_residual";
    /// Mean rate of the same window, minus the bias that the temperature table gives.
    BIAS_RESIDUAL_TABLE: "bias.residual_table", "deg/s", ["temperature", "age"], "bias_residual";
    /// Mean rate of the same window, with no bias subtracted.
    BIAS_RESIDUAL_NONE: "bias.residual_none", "deg/s", ["temperature", "age"], "bias_residual";

    /// Mean raw rate over one interval of a log at rest (Fig. 2).
    GYRO_RATE: "gyro.rate", "deg/s", ["temperature"], "log";
    /// Temperature that the gyro told at the end of one interval of a log at rest (Fig. 2).
    GYRO_TEMPERATURE: "gyro.temperature", "degC", [], "log";

    /// Angle of one turn of the table by the gyro, without sign.
    TABLE_ANGLE: "table.angle", "deg", ["direction", "temperature", "angle", "table_rate", "acceleration", "heading", "duration", "bias"], "table_turn";
    /// Angle by the gyro minus angle of the table, both without sign (Eqs 1 and 2).
    TABLE_ERROR: "table.error", "deg", ["direction", "temperature", "angle", "table_rate", "acceleration", "heading", "duration", "bias"], "table_turn";

    /// Angle turned in a lap by the gyro minus by the absolute measurement, times the direction:
    /// positive when too much is read, as in Eq. 1.
    LAP_GYRO_ERROR: "lap.gyro_error", "deg", ["direction", "temperature", "duration", "bias"], "lap";
    /// Angle turned in a lap by the base's odometry minus by the absolute measurement, times the
    /// direction.
    LAP_ODOMETRY_ERROR: "lap.odometry_error", "deg", ["direction", "temperature", "duration", "bias"], "lap";
    /// Absolute position after a lap, along the heading at its start, from that start.
    LAP_RETURN_X: "lap.return_x", "m", ["direction", "temperature", "duration", "bias"], "lap";
    /// Absolute position after a lap, to the left of the heading at its start, from that start.
    LAP_RETURN_Y: "lap.return_y", "m", ["direction", "temperature", "duration", "bias"], "lap";
    /// Absolute heading after a lap minus the one at its start, to within half a turn.
    LAP_RETURN_HEADING: "lap.return_heading", "deg", ["direction", "temperature", "duration", "bias"], "lap";
    /// Distance from the start to the absolute position after a lap.
    LAP_POSITION_ERROR: "lap.position_error", "m", ["direction", "temperature", "duration", "bias"], "lap";

    /// Heading that the base's own odometry turned in a lap, read back, minus by the absolute measurement, to within half
    /// a turn (Fig. 7).
    LAP_BASE_HEADING_ERROR: "lap.base_heading_error", "deg", ["direction", "temperature", "duration", "bias"], "lap";
    /// Return position by the base's own odometry, read back, minus by the absolute measurement, along the heading at the
    /// lap's start (Fig. 8).
    LAP_BASE_X_ERROR: "lap.base_x_error", "m", ["direction", "temperature", "duration", "bias"], "lap";
    /// The same to the left of that heading.
    LAP_BASE_Y_ERROR: "lap.base_y_error", "m", ["direction", "temperature", "duration", "bias"], "lap";

    /// Absolute minus dead-reckoned position after a lap, along the heading at its start.
    UMBMARK_X: "umbmark.x", "m", ["direction", "temperature", "duration", "bias"], "lap";
    /// Absolute minus dead-reckoned position after a lap, to the left of the heading at its start.
    UMBMARK_Y: "umbmark.y", "m", ["direction", "temperature", "duration", "bias"], "lap";

    /// Travelled minus commanded distance, at rest (section 4.2.1).
    STRAIGHT_STOP_ERROR: "straight.stop_error", "m", [], "straight";
    /// The same in truth, along the heading at the start; of a real base nobody sees it.
    STRAIGHT_TRUE_STOP_ERROR: "straight.true_stop_error", "m", [], "straight";
    /// True heading minus that at the start, with every state on the way; of a real base nobody sees it.
    STRAIGHT_TRUE_HEADING_ERROR: "straight.true_heading_error", "deg", [], "straight";
    /// Heading minus reference, once a control period on the way (section 4.2.1).
    STRAIGHT_HEADING_ERROR: "straight.heading_error", "deg", [], "straight";
    /// Largest of those on one line, without sign.
    STRAIGHT_HEADING_ERROR_MAX: "straight.heading_error_max", "deg", [], "straight";
    /// Turned minus commanded angle by the heading source, at rest (section 4.2.2).
    TURN_STOP_ERROR: "turn.stop_error", "deg", ["direction"], "turn";
    /// The same in truth; of a real base nobody sees it.
    TURN_TRUE_STOP_ERROR: "turn.true_stop_error", "deg", ["direction", "angle"], "turn";
    /// Angle turned by the base's odometry minus by the gyro.
    TURN_ODOMETRY_ERROR: "turn.odometry_error", "deg", ["direction"], "turn";
    /// Pose by the base's own odometry, read back after a line or a turn, minus the true one: x on the floor.
    BASE_POSE_X_ERROR: "base_pose.x_error", "m", [], "straight";
    /// The same, y.
    BASE_POSE_Y_ERROR: "base_pose.y_error", "m", [], "straight";
    /// The same, heading, to within half a turn.
    BASE_POSE_HEADING_ERROR: "base_pose.heading_error", "deg", [], "straight";
    /// Pose downloads that had to be tried again after one straight line.
    POSE_WRITE_RETRIES: "pose_write.retries", "1", [], "straight";

    /// Absolute position, x.
    POSE_X: "pose.x", "m", [], "measure_pose";
    /// Absolute position, y.
    POSE_Y: "pose.y", "m", [], "measure_pose";
    /// Absolute heading.
    POSE_HEADING: "pose.heading", "deg", [], "measure_pose";

    /// Error of an angle, root mean square over runs that took no part in the fit, by the plain model.
    IDENTIFICATION_BEFORE: "identification.before", "deg", [], "identify";
    /// The same by the model that was identified.
    IDENTIFICATION_AFTER: "identification.after", "deg", [], "identify";
    /// Error of a rate, root mean square over runs that took no part in the fit, by the plain model.
    IDENTIFICATION_RATE_BEFORE: "identification.rate_before", "deg/s", [], "identify";
    /// The same by the model that was identified.
    IDENTIFICATION_RATE_AFTER: "identification.rate_after", "deg/s", [], "identify";
    /// Of a sensor: its error with what was found taken off over its error as it reads, root mean squares over runs that
    /// took no part in the fit.
    IDENTIFICATION_KEPT: "identification.error_kept", "1", [], "identify";
    /// Effects that were found beyond the plain model.
    IDENTIFICATION_EFFECTS: "identification.effects", "1", [], "identify";
    /// 1 where something remains that no effect explains, 0 where nothing does.
    IDENTIFICATION_LEFT: "identification.structure_left", "1", [], "identify";

    /// Changes of the controller's health to degraded or worse, in the whole run.
    HEALTH_DEGRADED: "health.degraded", "1", [], "always";
    /// Changes of the controller's health to fault, in the whole run.
    HEALTH_FAULT: "health.fault", "1", [], "always";
    /// Gyro samples per host second over nominal.
    CLOCK_RATIO: "clock.ratio", "1", ["temperature"], "always";
    /// Gyro samples used, in the whole run.
    SAMPLES_USED: "samples.used", "1", [], "always";
    /// Gyro samples known to be lost, in the whole run.
    SAMPLES_LOST: "samples.lost", "1", [], "always";
    /// What overflowed a bounded queue, in the whole run.
    QUEUE_OVERFLOWS: "queue.overflows", "1", [], "always";
    /// Bench time that a step took.
    STEP_DURATION: "step.duration", "s", [], "always";
    /// By how much a repetition outlasted its period; zero when it did not.
    REPEAT_OVERRUN: "repeat.overrun", "s", [], "repeat";
}

#[cfg(test)]
mod tests {
    use super::{COMMON_TAGS, QUANTITIES, families, find, find_tag};
    use crate::Action;
    use std::collections::BTreeSet;

    #[test]
    fn each_kind_of_name_is_a_family() {
        let families = families();
        for family in
            ["gyro", "operator", "period", "reaction", "sdo", "signal", "uds", "unexpected"]
        {
            assert!(families.contains(family), "{family}");
        }
        assert!(families.iter().all(|family| !family.is_empty() && !family.contains('.')));
    }

    #[test]
    fn the_table_is_consistent() {
        let names: BTreeSet<_> = QUANTITIES.iter().map(|quantity| quantity.name).collect();
        assert_eq!(names.len(), QUANTITIES.len(), "a name is used twice");
        for quantity in QUANTITIES {
            assert_eq!(find(quantity.name), Some(*quantity));
            assert!(quantity.doc.ends_with('.'), "{}", quantity.name);
            for tag in quantity.tags.iter().chain(COMMON_TAGS) {
                assert!(find_tag(tag).is_some(), "{}: {tag}", quantity.name);
            }
            let made_by = quantity.made_by;
            assert!(
                made_by == "always" || Action::NAMES.contains(&made_by),
                "{}: no step {made_by}",
                quantity.name
            );
        }
    }
}
