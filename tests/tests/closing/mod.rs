//! The loop closed: a gyro has errors that nobody declared; the shipped plan finds them in turns of the
//! table, corrects by what it found, and the same turns pass the band that they missed before.
//!
//! The emulator's effects and what identification looks for are written apart and share no line. Sizes
//! are within the class (see the parameters of the emulated gyro) where no assumption is named.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod beyond;
mod effects;
mod nulls;
mod pairs;

use emulators::device_file::Devices;
use emulators::parameters::Parameters as _;
use identification::finding::{Effect, Finding};
use judge::checks::judge_all;
use record::outcome::{Outcome, Verdict};
use tests::devices::shipped;
use tests::plans::{Run, prepared, run};

/// The plan that ships.
const PLAN: &str = include_str!("../../../test-plans/close-the-loop.toml");
/// Its band, deg: Fig. 6.
const BAND: f64 = 0.25;
/// The seed that `hil run` takes where none is given.
const SEED: u64 = 1;

/// What causes an effect: a term and its driver.
type Cause = (&'static str, &'static str);

/// What a controller sees, or should have.
const TEMPERATURE: &str = "temperature";
const WARMING: &str = "rate_of(temperature)";

/// The shipped unit with these parameters in the place of what ails it.
fn unit(parameters: &[(&str, f64)]) -> Devices {
    let mut devices = shipped("undeclared-table");
    let gyro = &mut devices.gyro.1;
    let healthy = [("scale_ppm_at_30_deg_per_s", 0.0), ("bias_deg_per_h_per_kelvin_per_min", 0.0)];
    for (name, value) in healthy.iter().chain(parameters) {
        gyro.set(name, *value).unwrap();
    }
    devices
}

/// The shipped plan carried out, and what it found.
struct Story {
    done: Run,
    verdicts: Vec<(String, Verdict)>,
}

impl Story {
    fn of(devices: Devices) -> Self {
        Self::by(PLAN, devices)
    }

    /// By another plan.
    fn by(text: &str, devices: Devices) -> Self {
        let prepared = prepared(text, devices);
        let done = run(&prepared, SEED);
        let (measured, _) = judge_all(&prepared.plan.measurements, &done.simulated.observations);
        let verdicts = measured.into_iter().map(|one| (one.name, one.verdict)).collect();
        Self { done, verdicts }
    }

    fn finding(&self) -> &Finding {
        &self.done.simulated.made.findings["loop"]
    }

    /// Largest error of a turn during `label`, deg.
    fn worst(&self, label: &str) -> f64 {
        worst(&self.done, &format!("during.{label}"))
    }

    /// Every step was carried out.
    #[track_caller]
    fn is_carried_out(&self) -> &Self {
        let ending = &self.done.simulated.ending;
        assert_eq!(ending.outcome, Outcome::Passed, "{ending:?}\n{}", self.in_words());
        self
    }

    /// One of these causes, or something that the data cannot tell from it, was found first.
    #[track_caller]
    fn names(&self, causes: &[Cause]) -> &Self {
        let first = self.finding().effects.first();
        let named = first.is_some_and(|effect| causes.iter().any(|cause| means(effect, *cause)));
        assert!(named, "not {causes:?}\n{}", self.in_words());
        self
    }

    /// Out of the band before, within it after.
    #[track_caller]
    fn is_corrected(&self) -> &Self {
        self.is_carried_out();
        assert!(self.worst("before") > BAND, "{}", self.in_words());
        let after = self.verdicts.iter().find(|(name, _)| name == "error_after");
        assert!(after.is_some_and(|(_, verdict)| verdict.is_acceptable()), "{}", self.in_words());
        self
    }

    /// The error of runs that took no part in the fit falls by this factor at least.
    #[track_caller]
    fn falls_by(&self, factor: f64) -> &Self {
        let held_out = &self.finding().held_out;
        assert!(held_out.before > factor * held_out.after, "{}", self.in_words());
        self
    }

    /// For a person who wonders why a test failed.
    fn in_words(&self) -> String {
        let (before, after) = (self.worst("before"), self.worst("after"));
        let mut words = format!("worst turn {before:.3} deg before, {after:.3} deg after\n");
        if let Some(finding) = self.done.simulated.made.findings.get("loop") {
            let held_out = &finding.held_out;
            words += &format!("held out {:.4} -> {:.4} deg\n", held_out.before, held_out.after);
            for effect in &finding.effects {
                words += &format!("{} ({} by {:?})\n", effect.name, effect.term, effect.drivers);
                for rival in &effect.rivals {
                    words +=
                        &format!("    or {} ({} by {:?})\n", rival.name, rival.term, rival.drivers);
                }
            }
        }
        words
    }
}

/// Largest error of a turn of the table that has this tag, deg.
fn worst(run: &Run, tag: &str) -> f64 {
    let errors = run.simulated.observations.of("table.error").filter(|o| o.tag(tag).is_some());
    errors.fold(0.0, |worst, o| worst.max(o.value().abs()))
}

/// Is the effect, or a rival that it could be, of that cause?
fn means(effect: &Effect, (term, driver): Cause) -> bool {
    let is = |other: &str, drivers: &[String]| other == term && drivers.iter().any(|d| d == driver);
    is(&effect.term, &effect.drivers)
        || effect.rivals.iter().any(|rival| is(&rival.term, &rival.drivers))
}
