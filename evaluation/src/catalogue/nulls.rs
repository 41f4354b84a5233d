//! Null cases: only the base and noise, of every class.

use super::{Case, DRIVES, Purpose, Source, path_layout, series_layout, turns_layout};
use crate::noise::Noise;
use crate::series::Layout;
use crate::turns::Path;
use identification::dataset::Kind;

/// Null cases of a kind for each variant of noise.
const SERIES_NULLS: usize = 13;
const TURNS_NULLS: usize = 6;
const LAPS_NULLS: usize = 4;
const ODOMETRY_NULLS: usize = 4;
const SLIPPING_NULLS: usize = 8;

/// The noises of the null cases; a class with several variants is drawn with each.
fn null_noises(per_variant: usize) -> impl Iterator<Item = Noise> {
    let variants = [
        // The false-alarm rate is stated for white noise, so there are more cases of it.
        vec![Noise::White; 3],
        vec![Noise::Autoregressive(3.0), Noise::Autoregressive(30.0), Noise::Autoregressive(300.0)],
        vec![Noise::RandomWalk],
        vec![Noise::Flicker],
        vec![Noise::Student],
        vec![Noise::Outliers],
        [0.2, 0.5, 1.0, 2.0, 5.0].map(Noise::Quantised)[..].to_vec(),
        vec![Noise::PerRun],
    ];
    variants.into_iter().flat_map(move |class| {
        let count = if class.len() > 3 { per_variant.div_ceil(3) } else { per_variant };
        class.into_iter().flat_map(move |noise| std::iter::repeat_n(noise, count))
    })
}

/// Every null case, `times` as many as the figures by default rest on.
pub fn of_nulls(cases: &mut Vec<Case>, times: usize) {
    let mut push = |group, kind, repeat, noise: Noise, source| {
        let purpose = Purpose::Null(noise);
        cases.push(Case {
            group,
            kind,
            effect: noise.name().into(),
            family: "null",
            purpose,
            repeat,
            source,
        });
    };
    for (repeat, noise) in null_noises(times * SERIES_NULLS).enumerate() {
        // Mostly short layouts, so that there can be many cases.
        let layout = Layout { noise, ..series_layout([0, 1, 0, 1, 4, 0, 1, 2][repeat % 8]) };
        push("series", Kind::Series, repeat, noise, Source::Series(layout, vec![]));
    }
    for (repeat, noise) in null_noises(times * TURNS_NULLS).enumerate() {
        let source = Source::Turns(turns_layout(Path::Table, repeat, noise), vec![]);
        push("turns", Kind::Turns, repeat, noise, source);
    }
    for (repeat, noise) in null_noises(times * LAPS_NULLS).enumerate() {
        let source = Source::Turns(turns_layout(Path::Laps, repeat, noise), vec![]);
        push("laps", Kind::Laps, repeat, noise, source);
    }
    // Motion capture has no slow noise of its own here: the independent classes only.
    let independent = |noise: &Noise| {
        !matches!(noise, Noise::Autoregressive(_) | Noise::RandomWalk | Noise::Flicker)
    };
    for (repeat, noise) in null_noises(times * ODOMETRY_NULLS).filter(independent).enumerate() {
        let (drive, group) = DRIVES[repeat % 2];
        let source = Source::Odometry(path_layout(drive, repeat / 2 % 2, noise), vec![]);
        push(group, Kind::Odometry, repeat, noise, source);
    }
    let (drive, group) = DRIVES[0];
    for repeat in 0..times * SLIPPING_NULLS {
        let source = Source::Odometry(path_layout(drive, repeat % 2, Noise::Slip), vec![]);
        push(group, Kind::Odometry, repeat, Noise::Slip, source);
    }
}
