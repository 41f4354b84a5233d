//! An FMU that fails in a run ends the device, with its name, the time and the reason.

use crate::{DEVICE, at, device, folder};

/// Why the device fails when the oven goes wrong in this way at 0.1 s.
fn failure(version: usize, how: u8) -> String {
    let folder = folder(version);
    let wrong = format!("parameters = {{ fail_at = 0.1, fail_how = {how}, ambient");
    let mut device = device(&folder, &DEVICE.replace("parameters = { ambient", &wrong));
    for tick in 0..20 {
        let now = at(0.01 * f64::from(tick));
        device.wake(now);
        if let Some(why) = device.failure(now) {
            // It is reported once, and the device is off.
            assert_eq!(device.failure(now), None);
            while device.transmit().is_some() {}
            device.wake(at(1.0));
            assert!(device.transmit().is_none());
            return why;
        }
    }
    panic!("it does not fail");
}

#[test]
fn each_is_named() {
    for (version, how, expected) in [
        (2, 1, "`oven.fmu` at 0.12 s: fmi2DoStep returned Error: the door is open"),
        (2, 2, "`oven.fmu` at 0.12 s: fmi2DoStep returned Discard: too long a step"),
        (2, 3, "`oven.fmu` at 0.12 s: fmi2DoStep returned Fatal: on fire"),
        (2, 4, "`oven.fmu` at 0.12 s: its output `temperature` is NaN"),
        (2, 7, "`oven.fmu` at 0 s: fmi2EnterInitializationMode returned Error: nothing to heat"),
        (3, 1, "`oven.fmu` at 0.12 s: fmi3DoStep returned Error: the door is open"),
        (3, 2, "`oven.fmu` at 0.12 s: fmi3DoStep returned Discard: too long a step"),
        (3, 4, "`oven.fmu` at 0.12 s: its output `temperature` is NaN"),
        (3, 5, "`oven.fmu` at 0.12 s: its step ended early, at 0.11 s"),
        (3, 6, "`oven.fmu` at 0.12 s: it asks for the end of the simulation"),
    ] {
        assert_eq!(failure(version, how), expected);
    }
}

#[test]
fn a_variable_that_cannot_be_set_is_named() {
    let folder = folder(3);
    let text = DEVICE.replace("parameters = { ambient", "parameters = { fail_how = 300, ambient");
    let mut large = device(&folder, &text);
    assert_eq!(
        large.failure(at(0.0)).as_deref(),
        Some("`oven.fmu` at 0 s: `fail_how` cannot be 300")
    );
    fmu::samples::oven(&folder.path().join("oven.fmu"), 2, |text| {
        text.replace("valueReference=\"4\"", "valueReference=\"77\"")
    });
    let mut unknown = device(&folder, DEVICE);
    assert_eq!(
        unknown.failure(at(0.0)).as_deref(),
        Some("`oven.fmu` at 0 s: fmi2SetReal of `load.capacity` returned Error: it cannot be set")
    );
    fmu::samples::oven(&folder.path().join("oven.fmu"), 2, |text| text.replace("{oven}", "{pan}"));
    let mut other = device(&folder, DEVICE);
    assert_eq!(
        other.failure(at(0.0)).as_deref(),
        Some("`oven.fmu` at 0 s: it makes no instance of itself")
    );
}
