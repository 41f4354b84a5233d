//! The closed loop: a gyro has undeclared errors; the shipped plan finds them in turns of the table, corrects them, and
//! the same turns pass the band that they missed before.
//!
//! The emulator's effects and the identification's candidates were written independently and share no code. Sizes are
//! within the class (see the parameters of the emulated gyro) unless an assumption is stated.

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

/// The shipped plan.
const PLAN: &str = include_str!("../../../test-plans/close-the-loop.toml");
/// Its band, deg: Fig. 6.
const BAND: f64 = 0.25;
/// The default seed of `hil run`.
const SEED: u64 = 1;

/// Cause of an effect: a term and its driver.
type Cause = (&'static str, &'static str);

/// Drivers that a controller measures, or should.
const TEMPERATURE: &str = "temperature";
const WARMING: &str = "rate_of(temperature)";

/// Returns the shipped unit with these parameters in place of its own errors.
fn unit(parameters: &[(&str, f64)]) -> Devices {
    let mut devices = shipped("undeclared-table");
    let gyro = &mut devices.gyro.1;
    let healthy = [("scale_ppm_at_30_deg_per_s", 0.0), ("bias_deg_per_h_per_kelvin_per_min", 0.0)];
    for (name, value) in healthy.iter().chain(parameters) {
        gyro.set(name, *value).unwrap();
    }
    devices
}

/// A run of the shipped plan, and its findings.
struct Story {
    done: Run,
    verdicts: Vec<(String, Verdict)>,
}

impl Story {
    fn of(devices: Devices) -> Self {
        Self::by(PLAN, devices)
    }

    /// Runs another plan.
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

    /// Returns the largest error of a turn during `label`, deg.
    fn worst(&self, label: &str) -> f64 {
        worst(&self.done, &format!("during.{label}"))
    }

    /// Checks that every step was carried out.
    #[track_caller]
    fn is_carried_out(&self) -> &Self {
        let ending = &self.done.simulated.ending;
        assert_eq!(ending.outcome, Outcome::Passed, "{ending:?}\n{}", self.in_words());
        self
    }

    /// Checks that the first effect found has one of these causes, or cannot be distinguished from it by the data.
    #[track_caller]
    fn names(&self, causes: &[Cause]) -> &Self {
        let first = self.finding().effects.first();
        let named = first.is_some_and(|effect| causes.iter().any(|cause| means(effect, *cause)));
        assert!(named, "not {causes:?}\n{}", self.in_words());
        self
    }

    /// Checks that turns are out of the band before, and within it after.
    #[track_caller]
    fn is_corrected(&self) -> &Self {
        self.is_carried_out();
        assert!(self.worst("before") > BAND, "{}", self.in_words());
        let after = self.verdicts.iter().find(|(name, _)| name == "error_after");
        assert!(after.is_some_and(|(_, verdict)| verdict.is_acceptable()), "{}", self.in_words());
        self
    }

    /// Checks that the error of held-out runs falls at least by this factor.
    #[track_caller]
    fn falls_by(&self, factor: f64) -> &Self {
        let held_out = &self.finding().held_out;
        assert!(held_out.before > factor * held_out.after, "{}", self.in_words());
        self
    }

    /// Describes the run, to explain why a test failed.
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

/// Returns the largest error of a table turn with this tag, deg.
fn worst(run: &Run, tag: &str) -> f64 {
    let errors = run.simulated.observations.of("table.error").filter(|o| o.tag(tag).is_some());
    errors.fold(0.0, |worst, o| worst.max(o.value().abs()))
}

/// Whether the effect, or one of its rivals, has this cause.
fn means(effect: &Effect, (term, driver): Cause) -> bool {
    let is = |other: &str, drivers: &[String]| other == term && drivers.iter().any(|d| d == driver);
    is(&effect.term, &effect.drivers)
        || effect.rivals.iter().any(|rival| is(&rival.term, &rival.drivers))
}
