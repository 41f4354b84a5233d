//! Replaces a wide shape by narrow ones if it then adds nothing.

use super::refine::refine;
use super::scene::Scene;
use crate::candidates::{Candidate, Family, narrow_on};
use crate::model::{Driver, Form, Shape};

/// Maximum number of narrow shapes in the place of a wide one.
const NARROW_MAX: usize = 2;
/// Maximum that a wide shape may still add beyond them, in nats.
const LEFT_MAX: f64 = 6.9;

/// Narrow shapes that explain all that `wide` explains in `scene`, if there are any.
pub fn simplify(scene: &Scene<'_>, wide: &Shape, named: &[Candidate]) -> Option<Vec<Candidate>> {
    if wide.drivers.is_empty() {
        return None;
    }
    let mut pool: Vec<Candidate> = named
        .iter()
        .filter(|candidate| {
            let shape = &candidate.shape;
            shape.acts == wide.acts
                && shape
                    .drivers
                    .iter()
                    .all(|mine| wide.drivers.iter().any(|its| its.field == mine.field))
        })
        .cloned()
        .collect();
    for driver in &wide.drivers {
        pool.extend(narrow_on(scene.data.channels, wide.acts, driver));
        pool.push(line(wide, driver));
    }
    let mut chosen = Vec::new();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for _ in 0..NARROW_MAX {
        let now = scene.with(&columns);
        let best = pool
            .iter()
            .map(|candidate| {
                let score = now.look(&candidate.shape);
                (candidate, score.surprise - candidate.family.toll(None))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        let mut candidate = best.0.clone();
        candidate.shape = refine(&now, &candidate.shape);
        columns.extend(scene.data.columns(&candidate.shape));
        chosen.push(candidate);
        let left = scene.with(&columns).score(wide);
        if left.surprise < LEFT_MAX {
            return Some(chosen);
        }
    }
    None
}

/// A straight line. Unnamed powers are not offered: they diverge beyond the data.
fn line(wide: &Shape, driver: &Driver) -> Candidate {
    let origin = wide.knots.get(wide.knots.len() / 2).copied().unwrap_or(0.0);
    let name = wide.name.replace("shape", "line").replace("surface", "line");
    let shape =
        Shape::new(&name, wide.acts, driver.clone(), Form::Linear).unnamed().with("origin", origin);
    Candidate { shape, family: Family::Smooth }
}
