//! Two undeclared effects at once: both are among the first two, or among their rivals.

use super::{Cause, Story, TEMPERATURE, WARMING, means, unit};

#[track_caller]
fn both_are_named(parameters: &[(&str, f64)], causes: [Cause; 2]) -> Story {
    let story = Story::of(unit(parameters));
    let first: Vec<_> = story.finding().effects.iter().take(2).collect();
    for cause in causes {
        let named = first.iter().any(|effect| means(effect, cause));
        assert!(named, "{cause:?}\n{}", story.in_words());
    }
    story
}

/// The shipped unit.
#[test]
fn scale_over_rate_and_shupe() {
    let parameters =
        [("scale_ppm_at_30_deg_per_s", -2_000.0), ("bias_deg_per_h_per_kelvin_per_min", 20.0)];
    both_are_named(&parameters, [("scale", "table_rate"), ("bias", WARMING)]).is_corrected();
}

#[test]
fn hysteresis_and_asymmetry() {
    let parameters = [
        ("hysteresis_deg_per_h_per_kelvin", 10.0),
        ("hysteresis_half_width_kelvin", 3.0),
        ("scale_asymmetry_ppm", 2_000.0),
    ];
    let causes = [("scale", "direction"), ("bias", "branch_of(temperature)")];
    both_are_named(&parameters, causes).is_corrected();
}

#[test]
fn scale_over_temperature_and_ageing_of_the_bias() {
    let parameters = [("scale_ppm_per_kelvin", -300.0), ("bias_ageing_deg_per_h_per_h", 15.0)];
    let causes = [("scale", TEMPERATURE), ("bias", "trend(time)")];
    both_are_named(&parameters, causes).is_corrected();
}

#[test]
fn a_periodic_disturbance_and_ageing_of_the_scale() {
    let parameters = [("periodic_bias_deg_per_h", 20.0), ("scale_ageing_ppm_per_h", 1_500.0)];
    let causes = [("scale", "trend(time)"), ("bias", "periodic(time)")];
    both_are_named(&parameters, causes).is_corrected();
}

/// Named; whether they are corrected depends on what is added beside the two.
#[test]
fn bias_over_temperature_and_scale_over_rate() {
    let parameters = [("bias_deg_per_h_per_kelvin", 3.0), ("scale_ppm_at_30_deg_per_s", -2_000.0)];
    both_are_named(&parameters, [("scale", "table_rate"), ("bias", TEMPERATURE)]);
}
