//! From the chosen terms to their values, errors and rivals.

use super::choose::{Contender, contenders};
use super::data::combine;
use super::found::{BlockFit, Found};
use super::rivals::rivals;
use super::scene::robust_fit;
use super::state::State;
use crate::candidates::Candidate;
use crate::noise::Whitener;

/// Standard errors within which all of what is measured is late by the same.
const ALL_LATE: f64 = 3.0;

/// Values, errors and rivals of the terms of `state`.
pub(super) fn finish(state: &State<'_>, left: Vec<Contender>) -> BlockFit {
    let data = state.data;
    let whitener = Whitener::new(data.layout, &state.noise, &state.left_out);
    let target = whitener.apply(&data.block.residual);
    let columns = data.all_columns(&state.terms);
    let mut white = whitener.apply_all(&columns);
    let linear = white.len();
    let first = robust_fit(&white, &target);
    let mut derivatives = data.derivatives(&state.terms, &first.coefficients);
    derivatives.extend(data.by_delays(&state.terms, &first.coefficients));
    // The numbers are at their best, so the residual has no component along the derivatives: they only widen the errors
    // of the rest.
    let fitted = combine(&white, &first.coefficients);
    let residual: Vec<f64> = if fitted.is_empty() {
        target.clone()
    } else {
        target.iter().zip(&fitted).map(|(t, f)| t - f).collect()
    };
    white.extend(derivatives.iter().map(|derivative| whitener.apply(&derivative.column)));
    if let Some(closing) = &data.block.closing {
        // The lever comes from the same ends of laps: its fit carries little information on the size of their error.
        let fitted = combine(&columns, &first.coefficients);
        let by_lever = |(fitted, component): (&f64, &usize)| match component {
            0 => 0.0,
            _ => *fitted,
        };
        let by_lever: Vec<f64> = fitted.iter().zip(&closing.component).map(by_lever).collect();
        // Without a term, the lever has nothing to act on.
        if !by_lever.is_empty() {
            white.push(whitener.apply(&by_lever));
        }
    }
    let errors = robust_fit(&white, &residual).errors;
    let mut at = 0;
    let mut found = Vec::new();
    for (index, shape) in state.terms.iter().enumerate() {
        let width = data.width(shape);
        let mut coefficients =
            (at..at + width).map(|i| (first.coefficients[i], errors[i])).collect::<Vec<_>>();
        at += width;
        // How late it is, where all of it is late: more exact than how much is.
        let by_delay = derivatives.iter().position(|one| one.term == index && one.name == "delay");
        if let Some((error, late)) = by_delay.map(|i| errors[linear + i]).zip(shape.number("delay"))
            && let [(value, its)] = &mut coefficients[..]
            && (*value - late).abs() < ALL_LATE * *its
        {
            (*value, *its) = (late, error);
        }
        let numbers = derivatives
            .iter()
            .enumerate()
            .filter(|(_, derivative)| derivative.term == index)
            .map(|(i, derivative)| (derivative.name.to_owned(), errors[linear + i]))
            .collect();
        found.push(Found {
            shape: shape.clone(),
            coefficients,
            numbers,
            strength: 0.0,
            rivals: Vec::new(),
        });
    }
    for index in state.base..state.terms.len() {
        let mut others = state.terms.clone();
        let effect = others.remove(index);
        let scene = state.scene(&others);
        let family = state.families[index - state.base];
        let score = scene.score(&effect);
        let strength = score.surprise - family.toll(None);
        let mine =
            Contender::new(Candidate { shape: effect, family }, score, strength, scene.free());
        found[index].strength = strength;
        found[index].rivals = rivals(&scene, &mine, &contenders(&scene));
    }
    let scene = state.scene(&state.terms);
    let effects = found.split_off(state.base);
    BlockFit {
        base: found,
        effects,
        applied: Vec::new(),
        noise: state.noise.clone(),
        floor: scene.floor(&state.noise),
        scale: scene.scale,
        left,
        left_out: state.left_out.clone(),
        path: Vec::new(),
        chosen: 0,
        nested: Vec::new(),
        goes: None,
    }
}
