//! Envelopes: the severity of one kind of fault that a plan must tolerate.
//!
//! ```toml
//! [[envelope]]
//! fault = "burst_loss"
//! target = "gyro"        # without, the first of the bench that the kind can strike
//! at_least = 0.02        # of the kind's first parameter, in its unit
//! share = 0.9            # of runs that have to pass, shown at 95 % confidence
//! runs = 100             # at each severity
//! ```
//!
//! A run does not judge envelopes. A campaign measures them with many runs (`campaign::envelope`).

use crate::confidence::{Z_95, trials_min};
use crate::faults::{Fault, FaultKind, Lines, Schedule, Target, kind_name_schema};
use described::hint::proposal;
use described::{Mistake, Place};
use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

/// A value of an envelope that is out of its range.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unsound {
    /// Its key in a plan.
    pub key: &'static str,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: String,
}

/// One `[[envelope]]` of a plan.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DeclaredEnvelope {
    /// The kind, its other parameters at their typical values.
    #[serde(rename = "fault", deserialize_with = "kind")]
    #[schemars(schema_with = "kind_name_schema")]
    pub kind: FaultKind,
    /// What it strikes.
    #[serde(default)]
    pub target: Option<Target>,
    /// The least severity that must be tolerated, in the unit of the kind's first parameter.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub at_least: f64,
    /// Share of runs that has to pass for a severity to be tolerated.
    #[serde(default = "share")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub share: f64,
    /// Runs at each severity.
    #[serde(default = "runs")]
    pub runs: u64,
}

/// Nine runs of ten.
const fn share() -> f64 {
    0.9
}

/// This number of runs distinguishes 90 % from 97 %.
const fn runs() -> u64 {
    100
}

fn kind<'de, D: Deserializer<'de>>(deserializer: D) -> Result<FaultKind, D::Error> {
    let name = String::deserialize(deserializer)?;
    FaultKind::named(&name)
        .map_err(|unknown| D::Error::custom(format!("{unknown}: {}", unknown.help)))
}

/// The first target of a bench that this kind of fault can act on, or `asked` if it can. `asked` may also be a message or
/// a signal, under every name that a `[[fault]]` takes.
pub fn struck_by(kind: FaultKind, asked: Option<Target>, lines: &Lines) -> Option<Target> {
    let fits = |target: &Target| {
        let schedule = Schedule { faults: vec![Fault::new(*target, kind)] };
        schedule.check_bench(lines).is_ok()
    };
    let mut all = lines.targets(kind.info().reach).into_iter();
    let Some(asked) = asked else { return all.find(fits) };
    let is_known = asked.part().is_some() || all.any(|target| target == asked);
    Some(asked).filter(fits).filter(|_| is_known)
}

impl DeclaredEnvelope {
    /// Checks it by itself.
    pub(super) fn check(&self, index: usize) -> Result<(), Mistake> {
        self.sound().map_err(|Unsound { key, message, help }| {
            Place::file().key("envelope").index(index).key(key).mistake(message).help(help)
        })
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    ///
    /// The first one out of it.
    pub fn sound(&self) -> Result<(), Unsound> {
        let mistake = |key, message: String, help: String| Unsound { key, message, help };
        if let Some(target) = self.target
            && !matches!(target, Target::Node(_))
            && !self.kind.info().reach.targets().contains(&target)
        {
            let message = format!("`{}` cannot strike the {}", self.kind.name(), target.name());
            let known: Vec<&str> =
                self.kind.info().reach.targets().iter().map(|target| target.name()).collect();
            return Err(mistake("target", message, format!("it strikes: {}", known.join(", "))));
        }
        if !self.kind.is_graded() {
            let message = format!("`{}` has no severity", self.kind.name());
            let help = "`signal_offset` has one, and `stuck_signal`".to_owned();
            return Err(mistake("fault", message, help));
        }
        let (least, most) = self.kind.severity_range();
        if !(self.at_least > least.max(0.0) && self.at_least <= most) {
            let message = format!("{}, expected above {least} and at most {most}", self.at_least);
            let help = self.kind.info().parameters.first().map_or_else(String::new, |first| {
                format!("it is the `{}` of `{}`, in {}", first.name, self.kind.name(), first.unit)
            });
            return Err(mistake("at_least", message, help));
        }
        if !(self.share > 0.0 && self.share < 1.0) {
            let message = format!("{}, expected above 0 and below 1", self.share);
            return Err(mistake("share", message, "such as 0.9".to_owned()));
        }
        let runs_min = trials_min(self.share, Z_95);
        if self.runs < runs_min {
            let message = format!("so few can never show a share of {}", self.share);
            let help = format!("{runs_min}, all of them passed, show it at 95 % confidence");
            return Err(mistake("runs", message, help));
        }
        Ok(())
    }

    /// Checks that the bench has the target.
    pub(super) fn check_bench(&self, index: usize, lines: &Lines) -> Result<(), Mistake> {
        if struck_by(self.kind, self.target, lines).is_some() {
            return Ok(());
        }
        let at = Place::file().key("envelope").index(index);
        let known = lines.targets(self.kind.info().reach);
        let known: Vec<&str> = known.iter().map(Target::name).collect();
        if let Some(target) = self.target {
            let message = format!("`{}` cannot strike `{}` here", self.kind.name(), target.name());
            return Err(at.key("target").mistake(message).help(proposal(target.name(), &known)));
        }
        let message = format!("`{}` can strike nothing on this bench", self.kind.name());
        Err(at.key("fault").mistake(message).help("`hil list faults` says what each strikes"))
    }
}

#[cfg(test)]
mod tests {
    use super::{DeclaredEnvelope, struck_by};
    use crate::faults::{FaultKind, LineKind, Lines, Said, Target};

    fn parsed(text: &str) -> Result<DeclaredEnvelope, String> {
        let envelope: DeclaredEnvelope =
            toml::from_str(text).map_err(|error| error.message().to_owned())?;
        envelope.check(0).map(|()| envelope).map_err(|mistake| mistake.message)
    }

    #[test]
    fn what_is_left_out_is_usual() {
        let envelope = parsed("fault = \"drop\"\nat_least = 0.5").unwrap();
        assert_eq!((envelope.target, envelope.share, envelope.runs), (None, 0.9, 100));
        assert_eq!(struck_by(envelope.kind, None, &Lines::CAN_BASE), Some(Target::Gyro));
        let slip = FaultKind::typical("wheel_slip").unwrap();
        assert_eq!(struck_by(slip, None, &Lines::TABLE), None);
    }

    /// As in a `[[fault]]`: a message also for a kind of a line, and a signal also without its message.
    #[test]
    fn messages_and_signals_are_struck_by_every_name() {
        let said = Said {
            node: "cells".to_owned(),
            message: "Status".to_owned(),
            line: LineKind::Can,
            signals: vec!["Voltage".to_owned()],
            ranges: vec![(0.0, 5.0)],
            counter: false,
            checksum: false,
            never_alone: None,
        };
        let nodes = vec![(Target::named("cells").unwrap(), LineKind::Can)];
        let lines = Lines { nodes, said: vec![said], ..Lines::default() };
        let struck = |kind: &str, target: &str| {
            let kind = FaultKind::typical(kind).unwrap();
            let struck = struck_by(kind, Target::named(target), &lines);
            struck.map(|target| target.name().to_owned())
        };
        for (kind, target) in [
            ("drop", "cells"),
            ("drop", "cells.Status"),
            ("stuck_signal", "cells.Voltage"),
            ("stuck_signal", "cells.Status.Voltage"),
        ] {
            assert_eq!(struck(kind, target).as_deref(), Some(target), "{kind}");
        }
        for (kind, target) in [
            ("drop", "cells.Alarm"),
            ("drop", "cells.Voltage"),
            ("stuck_signal", "cells.Status"),
            ("stuck_counter", "cells.Status"),
        ] {
            assert_eq!(struck(kind, target), None, "{kind}");
        }
    }

    #[test]
    fn what_is_wrong_is_said() {
        let wrong = [
            "fault = \"dorp\"\nat_least = 1",
            "fault = \"drop\"\nat_least = 101",
            "fault = \"drop\"\nat_least = 0",
            "fault = \"drop\"\ntarget = \"host\"\nat_least = 1",
            "fault = \"drop\"\nat_least = 1\nshare = 1",
            "fault = \"drop\"\nat_least = 1\nruns = 34",
        ];
        let messages: Vec<String> = wrong.iter().map(|text| parsed(text).unwrap_err()).collect();
        let most = toml::from_str::<DeclaredEnvelope>(wrong[1]).unwrap().sound().unwrap_err();
        assert_eq!(most.help, "it is the `loss_percent` of `drop`, in %");
        insta::assert_snapshot!(messages.join("\n"), @r"
        no fault is called `dorp`: did you mean `drop`?
        101, expected above 0 and at most 100
        0, expected above 0 and at most 100
        `drop` cannot strike the host
        1, expected above 0 and below 1
        so few can never show a share of 0.9
        ");
    }
}
