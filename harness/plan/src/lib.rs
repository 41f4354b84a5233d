//! Plans: the steps on a bench, and the criteria by which they are judged. Written in TOML 1.1.
//!
//! ```toml
//! name = "verification"
//! title = "Independent table runs after correction"
//! paper = "section 3, Fig. 6"
//! devices = "paper-table"
//! steps = [
//!   { use_calibration = "temperature" },
//!   { wait = { duration_s = 7200 } },
//!   { repeat = { times = 20, period_s = 120, steps = [
//!       { bias_test = { duration_s = 20 } },
//!       { table_turn = { angle_deg = -360 } },
//!       { table_turn = { angle_deg = 360 } },
//!   ] } },
//! ]
//!
//! [[measurement]]
//! name = "table_error_cw"
//! doc = "Error of one clockwise turn after correction"
//! quantity = "table.error"
//! where = { direction = -1 }
//! unit = "deg"
//! check = { all_within = [-0.25, 0.25] }
//! paper = "all within +-0.25 deg (Fig. 6)"
//! ```
//!
//! Faults to inject are in `[[fault]]` tables ([`crate::faults`]).
//!
//! A step is a table with one key, the [`Action`], and optionally `label` and `time_limit_s`. A key carries its unit;
//! the parsed plan is in SI units. Nothing is guessed: an unknown key, a value out of bounds or a dangling reference is
//! a [`FileError`] that shows its place in the file.
//!
//! Related modules: injected faults ([`faults`]), the ports of roles ([`bench_file`]), results that one plan makes and
//! a later one uses ([`calibrations`], [`models`], [`made`]). Only [`library`] reads files, from disk and from those
//! that ship.

mod band;
pub mod bench_file;
mod by_name;
pub mod calibrations;
pub mod check;
pub mod command;
pub mod confidence;
mod contradiction;
pub mod device_files;
#[cfg(test)]
mod documents;
mod envelope;
pub mod faults;
mod formula;
pub mod identifiers;
pub mod library;
pub mod made;
mod measurement;
pub mod models;
mod name;
pub(crate) mod number;
pub mod observation;
pub mod phases;
mod property;
mod property_entry;
pub mod quantities;
mod quantity;
mod reaction;
pub mod replayed;
pub mod rig;
pub mod rig_build;
mod seed;
pub(crate) mod speakers;
mod step;
mod subject;
mod survey;
pub mod time_limits;
pub(crate) mod timeline;
mod validate;

pub use band::Band;
pub use check::{Check, PAPER_SIDE};
pub use contradiction::RUN_ITSELF;
pub use envelope::{DeclaredEnvelope, Unsound, struck_by};
pub use formula::{Origin, Reads, formula, origins, speakers_of};
pub use measurement::{Declared, Proves};
pub use name::{Name, ParameterName};
pub use phases::PhaseEvent;
pub use property::{Always, Kind, Property, Sometimes, Stated};
pub use quantity::{Filter, QuantityName, TagMatch};
pub use reaction::Reaction;
pub use rig::Rig;
pub use seed::{SEED, Seed};
pub use speakers::{
    DEVICE, MessagePlace, OfMessage, Speaker, canopen_devices, resolve, signal, unit, unit_of,
};
pub use step::*;

use crate::faults::{Lines, Schedule};
use described::{FileError, Mistake};
use emulators::random::seed_of_run;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;
use wire::gyro::GyroStream;
use wire::time::Span;

/// Largest plan, rig, device or bench file, in bytes: one with each signal of a DBC of thousands of messages.
pub const FILE_LEN_MAX: usize = 16 << 20;
/// Most steps written in one plan.
pub const STEPS_MAX: usize = 1_000;
/// Most steps carried out by one plan, including all repetitions.
pub const STEPS_DONE_MAX: u64 = 1_000_000;
/// Maximum nesting of steps in repeats and sweeps.
pub const DEPTH_MAX: usize = 6;

/// A plan that can be run.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["devices"] }, { "required": ["device"] }, { "required": ["rig"] }]))]
pub struct Plan {
    /// Its name; the file's too.
    pub name: Name,
    /// What it is, in a line.
    pub title: String,
    /// Where the paper describes it.
    #[serde(default)]
    pub paper: Option<String>,
    /// The plan whose random numbers it has: its own name where it is absent. A case that a campaign keeps as a plan has
    /// those of the plan that was struck.
    #[serde(default)]
    pub random_numbers_of: Option<Name>,
    /// The seed of a run that is not given another; 1 where it is absent. A case that a campaign keeps as a plan has its
    /// own.
    #[serde(default)]
    pub seed: Option<Seed>,
    /// Folder of the files that it names, relative to its own, which it is where this is absent. A case that a campaign
    /// keeps as a plan has the folder of the plan that was struck.
    #[serde(default)]
    pub project: Option<String>,
    /// Name of the device file: a gyro on a robot or a table.
    #[serde(default)]
    pub devices: Option<Name>,
    /// Name of the description of a custom device.
    #[serde(default)]
    pub device: Option<Name>,
    /// Name of a rig: nodes on lines. A plan names one of the three.
    #[serde(default)]
    pub rig: Option<Name>,
    /// As it is written; see [`Plan::time_limit`] for what holds where it is not.
    #[serde(rename = "time_limit_s", default, with = "number::Duration")]
    #[schemars(
        description = "It must not take longer, s; where it is absent, as long as its steps may."
    )]
    pub explicit_time_limit: Option<Span>,
    /// What is done, in order.
    #[serde(deserialize_with = "step::some_steps")]
    #[schemars(length(min = 1, max = STEPS_MAX))]
    pub steps: Vec<Step>,
    /// Messages that are sent to the device at the end, however it came about.
    #[serde(default)]
    pub finally: Vec<Send>,
    /// What is judged.
    #[serde(rename = "measurement", default)]
    pub measurements: Vec<Declared>,
    /// What goes wrong on purpose.
    #[serde(rename = "fault", default)]
    pub faults: Schedule,
    /// What must hold throughout; empty where the plan leaves it to who asks.
    #[serde(rename = "property", default)]
    pub properties: Vec<Property>,
    /// Times from one condition to another that are measured.
    #[serde(rename = "reaction", default)]
    pub reactions: Vec<Reaction>,
    /// How much of faults it has to stand; measured by campaigns.
    #[serde(rename = "envelope", default)]
    pub envelopes: Vec<DeclaredEnvelope>,
}

/// Reads a plan without its [checks](Plan::check).
impl FromStr for Plan {
    type Err = toml::de::Error;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        toml::from_str(text)
    }
}

/// Refuses a rig or the description of a device that stands where a plan is expected; `None` if it may be a plan.
fn other_kind(file: &str, text: &str) -> Option<FileError> {
    let table: toml::Table = text.parse().ok()?;
    let has = |keys: &[&str]| keys.iter().any(|key| table.contains_key(*key));
    let (kind, help) = if has(&["steps"]) {
        return None;
    } else if has(&["node", "line"]) {
        ("a rig", "a plan names it: rig = \"NAME\"")
    } else if has(&["message", "state", "parameter", "dbc", "eds", "serial", "table"]) {
        (
            "the description of a device",
            "a plan names it: device = \"NAME\"; a rig file: emulate = \"NAME\"",
        )
    } else {
        return None;
    };
    let message = format!("this is {kind}, no plan: it has no steps");
    Some(FileError::new(file, text, 0..text.len().min(1), message).with_help(Some(help.to_owned())))
}

impl Plan {
    /// Reads a plan; `file` names it in errors.
    ///
    /// # Errors
    /// The first mistake, with its place.
    pub fn parse(file: &str, text: &str) -> Result<Self, FileError> {
        if text.len() > FILE_LEN_MAX {
            let message = format!("{} bytes, expected at most {FILE_LEN_MAX}", text.len());
            return Err(FileError::new(file, "", 0..0, message));
        }
        let plan: Self = text.parse().map_err(|error| {
            other_kind(file, text).unwrap_or_else(|| FileError::from_toml(file, text, &error))
        })?;
        plan.check(file, text)?;
        Ok(plan)
    }

    /// The seed of a run: the one that is asked for, else that of the plan.
    pub fn seed(&self, asked: Option<u64>) -> u64 {
        asked.or(self.seed.map(|seed| seed.0)).unwrap_or(SEED)
    }

    /// The seed of all random numbers in a run of the plan.
    pub fn seed_of_run(&self, seed: u64) -> u64 {
        seed_of_run(seed, self.random_numbers_of.as_ref().unwrap_or(&self.name).as_str())
    }

    /// Checks the plan by itself, like [`Plan::parse`]. `file` and `text` are its source, or empty if it was built in
    /// code.
    ///
    /// # Errors
    /// The first mistake, with its place.
    pub fn check(&self, file: &str, text: &str) -> Result<(), FileError> {
        validate::validate(self, None).map_err(|mistake| mistake.located(file, text))
    }

    /// The limit in the plan, or the sum of its steps' limits.
    pub fn time_limit(&self) -> Span {
        self.explicit_time_limit.unwrap_or_else(|| Step::sum_of_limits(&self.steps))
    }

    /// The properties that a campaign judges on `rig`: the declared ones, and on the paper's robot all others of a robot
    /// with their usual limits. If there are none, the plan has to pass.
    pub fn judged(&self, rig: &Rig) -> Vec<Property> {
        if rig.robot.is_none() {
            return self.properties.clone();
        }
        let (of_robot, others): (Vec<_>, Vec<_>) = (self.properties.iter().cloned())
            .partition(|declared| !matches!(declared, Property::Stated(_)));
        let mut judged = Property::all();
        for usual in &mut judged {
            let declared = of_robot.iter().find(|declared| declared.name() == usual.name());
            if let Some(declared) = declared {
                usual.clone_from(declared);
            }
        }
        judged.extend(others);
        judged
    }

    /// What of `judged` should occur in some run of a campaign and is not in `reached` yet, and whether the plan itself
    /// demands it.
    pub fn unreached(
        &self,
        judged: &[Property],
        reached: &BTreeSet<String>,
    ) -> BTreeMap<String, bool> {
        let states = judged.iter().filter(|property| property.kind() == property::Kind::Sometimes);
        let states = states.filter(|state| !reached.contains(state.name()));
        let demanded = self.demanded();
        states.map(|state| (state.name().to_owned(), demanded.contains(state.name()))).collect()
    }

    /// The states that the plan itself demands: a run fails that reaches not all of them, a campaign if no case does.
    pub fn demanded(&self) -> BTreeSet<String> {
        let is_state = |declared: &&Property| declared.kind() == property::Kind::Sometimes;
        let states = self.properties.iter().filter(is_state);
        states.map(|state| state.name().to_owned()).collect()
    }

    /// Checks that `rig` has every node, message, signal and parameter that the plan names, with the right units, and
    /// the targets of its faults. `file` and `text` are the source of the plan.
    ///
    /// # Errors
    /// The first that is missing, with its place.
    pub fn check_rig(&self, file: &str, text: &str, rig: &Rig) -> Result<(), FileError> {
        validate::validate(self, Some(rig)).map_err(|mistake| mistake.located(file, text))?;
        let gyro = rig.robot.as_ref().map(|devices| devices.gyro.0);
        self.check_lines(file, text, &rig.struck(), gyro)
    }

    /// Checks that a rig with these `lines` and this gyro has the targets of faults and the devices that properties
    /// refer to.
    fn check_lines(
        &self,
        file: &str,
        text: &str,
        lines: &Lines,
        gyro: Option<GyroStream>,
    ) -> Result<(), FileError> {
        let faults = self.faults.check_bench(lines);
        let mut envelopes = self.envelopes.iter().enumerate();
        let envelopes = |()| envelopes.try_for_each(|(index, one)| one.check_bench(index, lines));
        let properties = |()| match gyro {
            Some(gyro) => contradiction::of_bench(&self.properties, lines, gyro),
            None => Ok(()),
        };
        faults
            .and_then(envelopes)
            .and_then(properties)
            .map_err(|mistake| mistake.located(file, text))
    }
}

/// The result of a check: the first mistake.
pub type Checked = Result<(), Mistake>;

#[cfg(test)]
mod tests;
