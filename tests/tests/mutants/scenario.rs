//! Shared by the scenarios.

use controller::Mutant;
use emulators::base::Transport;
use emulators::device_file::Devices;
use judge::properties::{Kind, PropertyVerdict};
use tests::devices::ideal;
use tests::rig::Rig;

/// Returns a rig whose controller has this mutant.
pub fn rig(devices: &Devices, mutant: Option<Mutant>) -> Rig {
    Rig::with_config(devices, 1, |config| config.mutant = mutant).ready()
}

/// An ideal gyro on an ideal base on CAN.
pub fn on_can(mutant: Option<Mutant>) -> Rig {
    rig(&ideal(Transport::Can), mutant)
}

/// Checks that the scenario violates `property` with the mutant, and no property without it.
///
/// # Panics
///
/// When it does not.
pub fn caught(
    mutant: Mutant,
    property: &str,
    scenario: impl Fn(Option<Mutant>) -> Vec<PropertyVerdict>,
) {
    let with = scenario(Some(mutant));
    let verdict = with.iter().find(|verdict| verdict.name == property).expect("it is judged");
    assert!(!verdict.held, "{}: {with:#?}", mutant.name());
    assert!(verdict.margin.is_some_and(|margin| margin < 0.0), "{verdict:?}");
    assert!(verdict.first_violation.is_some(), "{verdict:?}");
    let without = scenario(None);
    let broken: Vec<_> =
        without.iter().filter(|verdict| verdict.kind == Kind::Always && !verdict.held).collect();
    assert!(broken.is_empty(), "without {}: {broken:#?}", mutant.name());
    let positive = without.iter().all(|v| v.margin.is_none_or(|margin| margin >= 0.0));
    assert!(positive, "{without:#?}");
}
