//! A finding in plain words.

use super::phrases::plain;
use super::sentence::causes;
use crate::dataset::{Dimension, Kind, Unit};
use crate::finding::{Finding, HeldOut, Parameter, SetAside, Verdict, in_unit};
use crate::units::short;

impl Finding {
    /// The verdict in a few words.
    pub fn verdict_in_words(&self) -> &'static str {
        let is_mended = self.effects.iter().any(|effect| effect.term != "quantisation");
        match self.verdict {
            Verdict::Explained => "explained",
            // A wrong sign is no more than a scale, and no error falls with it.
            Verdict::NothingMissing if is_mended => "nothing else is missing",
            Verdict::NothingMissing => "nothing is missing",
            Verdict::StructureLeft => "structure is left",
        }
    }

    /// The finding in a few sentences: the causes, their gain on held-out runs, and what else would help.
    pub fn in_words(&self) -> Vec<String> {
        let mut said: Vec<String> = self.set_aside.iter().map(SetAside::in_words).collect();
        said.extend(causes(&self.effects, self.drive));
        let most = CAUSES_MAX + self.set_aside.len();
        if said.len() > most {
            let more = said.len() - most;
            said.truncate(most);
            let are = if more == 1 { "is" } else { "are" };
            said.push(format!("{more} more {are} below."));
        }
        if self.effects.iter().all(|effect| effect.term == "quantisation") {
            said.push(
                match self.verdict {
                    Verdict::NothingMissing if !self.effects.is_empty() => {
                        "Beside that, the model given leaves nothing but noise."
                    }
                    Verdict::NothingMissing => {
                        "The model given leaves nothing but noise: these data give no reason to add anything."
                    }
                    _ => "No cause that was tried lowers the error on runs that took no part in the fit.",
                }
                .to_owned(),
            );
            said.extend(self.above_noise());
        } else {
            let fell =
                |one: &&HeldOut| one.after < one.before && short(one.after) != short(one.before);
            let falls: Vec<String> = std::iter::once(&self.held_out)
                .chain(&self.held_out_also)
                .filter(fell)
                .map(|one| {
                    let of = one
                        .quantity
                        .as_deref()
                        .map_or(String::new(), |of| format!(" of {}", plain(of)));
                    let unit = in_unit(&one.unit);
                    format!(
                        "error{of} falls from {} to {}{unit}",
                        short(one.before),
                        short(one.after)
                    )
                })
                .collect();
            said.push(if falls.is_empty() {
                "That does not lower the error on runs that took no part in the fit.".to_owned()
            } else {
                let falls = falls.join(", the ");
                format!("With that the {falls}, on runs that took no part in the fit.")
            });
            said.extend(self.beyond());
        }
        said.extend(self.calibration());
        said
    }

    /// The bias and the scale error that the plain model has already: what any calibration sets, however large.
    fn calibration(&self) -> Option<String> {
        let is_gain = matches!(self.kind, Kind::Turns | Kind::Series | Kind::Sensor);
        let shows = |one: &&Parameter| {
            one.standard_error.is_some_and(|error| one.value.abs() > SHOWS_FROM * error)
        };
        let part = |one: &Parameter| {
            let axis = ["x", "y", "z"].into_iter().find_map(|axis| {
                Some((one.name.strip_suffix(axis)?.strip_suffix('_')?, format!(" of axis {axis}")))
            });
            let (name, of) = axis.unwrap_or((&one.name, String::new()));
            match name {
                "scale_factor" => format!("a scale error{of} of {} %", short(100.0 * one.value)),
                name => {
                    format!("a {}{of} of {}{}", plain(name), short(one.value), in_unit(&one.unit))
                }
            }
        };
        let parts: Vec<String> = self.base.iter().filter(shows).map(part).collect();
        (is_gain && !parts.is_empty())
            .then(|| format!("The plain model itself takes up {}.", parts.join(" and ")))
    }

    /// How far the error of readings is above the noise.
    fn above_noise(&self) -> Option<String> {
        // Of single rows: the error of a heading adds up since the one before.
        let is_rate = || {
            let unit = Unit::parse(&self.held_out.unit);
            unit.is_some_and(|unit| unit.dimension() == Dimension::AngularRate)
        };
        let is_alone = self.kind == Kind::Sensor || self.kind == Kind::Series && is_rate();
        // Beside steps that are coarser than the noise, the noise is not what errors are measured by.
        let is_rounded = self.effects.iter().any(|effect| effect.term == "quantisation");
        let is_alone = is_alone && !is_rounded;
        let ratio = self.held_out.after / self.noise_floor.value;
        (is_alone && self.held_out.unit == self.noise_floor.unit && ratio.is_finite()).then(|| {
            format!("The error is {} times the noise that is new in a reading.", short(ratio))
        })
    }

    /// Further gain of the richest model of the path.
    fn beyond(&self) -> Option<String> {
        let chosen = self.path.iter().position(|model| model.chosen)?;
        let model = &self.path[chosen];
        let mut more: Vec<String> = Vec::new();
        for (name, error) in &model.held_out {
            let best = self.path[chosen..]
                .iter()
                .filter_map(|other| other.held_out.get(name))
                .fold(error.value, |best, other| best.min(other.value));
            if best < error.value {
                let gain = short(error.value - best);
                let unit = in_unit(&error.unit);
                more.push(format!("{} by more than {gain}{unit}", plain(name)));
            }
        }
        if more.is_empty() {
            return Some("No further cause that was tried lowers it.".to_owned());
        }
        let more = more.join(", or of ");
        Some(format!("Nothing else that was tried lowers the error of {more}."))
    }
}

impl SetAside {
    /// What took no part, in a sentence.
    pub fn in_words(&self) -> String {
        let Self { quantity, rows, of, limit, largest, unit, .. } = self;
        let (are, they) =
            if *rows == 1 { ("is an outlier", "it") } else { ("are outliers", "they") };
        format!(
            "{rows} of {of} rows of {} {are}, {} {unit} or more from the rows around (at most {}): {they} took no part.",
            plain(quantity),
            short(*limit),
            short(*largest)
        )
    }
}

/// Standard errors from which a constant of the plain model is told.
const SHOWS_FROM: f64 = 4.0;
/// Maximum number of causes listed one by one.
const CAUSES_MAX: usize = 4;
