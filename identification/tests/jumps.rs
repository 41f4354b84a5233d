//! A bias that jumps is reported even where a delay leaves a residual that is no noise.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

#[test]
fn a_late_yaw_rate_whose_bias_jumps_has_both() {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(2);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let rate = |at: f64| 12.0 * (at / 3.1).sin() * (at / 37.0).cos() + 5.0 * (at / 1.3).sin();
    let (mut time, mut truth, mut reads) = (vec![], vec![], vec![]);
    for row in 0..12_000 {
        let at = f64::from(row) * 0.05;
        let jump = if at > 230.0 { -0.75 } else { 0.0 };
        time.push(at);
        truth.push(rate(at));
        reads.push(((0.97 * rate(at - 0.06) + jump + 0.15 * draw()) * 4.0).round() / 4.0);
    }
    let rate = Unit::DegreePerSecond;
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, time),
        Column::new("yaw", Role::GyroRate, rate, reads),
        Column::new("reference", Role::ReferenceRate, rate, truth),
    ];
    let data = Dataset::new("car", Kind::Series, columns, vec![0; 12_000]);
    let finding = identify(&data, None, &Options::default(), &mut |_, _| ()).unwrap().finding;
    let named = |name: &str| finding.effects.iter().find(|effect| effect.name == name);
    let delay = named("delay").unwrap().parameters[0].value;
    assert!((delay - 0.06).abs() < 0.003, "{delay}");
    let jump = named("bias_step").unwrap_or_else(|| panic!("{:?}", finding.effects));
    assert!((jump.parameters[0].value + 0.75).abs() < 0.05, "{jump:?}");
    assert!(finding.held_out.after < 0.19, "{:?}", finding.held_out);
}
