//! One observed quantity: as it is searched, and with its results.

use crate::clipping::Clipped;
use crate::compensation::compensation;
use crate::dataset::Dataset;
use crate::finding::{Compensation, Effect, LeftOut, Parameter};
use crate::fit::{Data, Found, Memory, fit_terms};
use crate::judge::{Holding, Judge, Metric, margin};
use crate::model::{Acts, Shape};
use crate::noise::{self, Layout, NoiseModel};
use crate::outcome::{self, OffsetOfRuns};
use crate::problem::{Aggregate, Block, Channels, Problem};
use crate::rounding::without_rounding;
use crate::select::{Asked, BlockFit, Waypoint, identify_block};

/// An observed quantity as it is searched.
pub(crate) struct Quantity<'a> {
    /// As it was read.
    pub read: &'a Block,
    /// Without its rounding, where that is coarser than its noise; the step of it, SI.
    block: Block,
    step: Option<f64>,
    /// The terms of the given model.
    base: Vec<Shape>,
    layout: Layout,
    memory: Memory,
}

impl<'a> Quantity<'a> {
    /// That of `read`, whose given model has the terms `base`.
    pub fn new(read: &'a Block, channels: &Channels, base: Vec<Shape>) -> Self {
        let (block, step) = match without_rounding(read, channels, &base) {
            Some((corrected, step)) => (corrected, Some(step)),
            None => (read.clone(), None),
        };
        let layout = layout(&block, channels, &base);
        Self { read, block, step, base, layout, memory: Memory::default() }
    }

    /// The note on its rounding.
    pub fn notice(&self) -> Option<String> {
        let Block { label, unit, .. } = self.read;
        self.step.map(|step| {
            format!(
                "`{label}` is rounded to steps of {:.3e} {}, coarser than its noise; the mean rounding error is taken out",
                step / unit.si,
                unit.text
            )
        })
    }
}

/// Times of a block's observations, and how noise accumulates in them.
fn layout(block: &Block, channels: &Channels, base: &[Shape]) -> Layout {
    let plain = Layout::new(block, channels);
    let Some(bias) = block.exposure(Acts::Bias) else {
        return plain;
    };
    let durations: Vec<f64> = block.rows.iter().map(|&row| bias.per_row[row]).collect();
    let columns = Data::new(block, channels, &plain).all_columns(base);
    noise::likeliest_layout(plain, &durations, &block.residual, &columns)
}

/// An observed quantity with its results.
pub(crate) struct Done<'a> {
    pub data: Data<'a>,
    /// The terms of the given model, and these fitted by themselves.
    base: &'a [Shape],
    pub plain: Vec<Found>,
    pub asked: Asked<'a>,
    pub fit: BlockFit,
    pub judge: Judge<'a>,
    /// Times what is right that the readings of a sensor are.
    pub factor: f64,
    /// Clipping, with the held-out errors of a model that ignores it.
    pub clipped: Option<(&'a Clipped, Vec<Metric>)>,
    /// Rounding step, if it is coarser than the noise.
    pub step: Option<f64>,
}

impl<'a> Done<'a> {
    /// Searches what `quantity` of `problem` lacks. Its readings are `factor` times what is right.
    pub fn new(
        quantity: &'a Quantity<'a>,
        problem: &'a Problem,
        asked: Asked<'a>,
        factor: f64,
        report: &mut dyn FnMut(f64),
    ) -> Self {
        let Quantity { read, block, step, base, layout, memory } = quantity;
        let channels = problem.channels_of(block);
        let data = Data { block, channels, layout, memory: Some(memory) };
        // Errors are those of the readings before any correction.
        let read = Data { block: read, ..data };
        let judge = Judge { data: read, path: problem.path.as_ref(), holding: Holding::Spread };
        let fit = identify_block(data, &judge, base.clone(), asked, report);
        let plain = fit_terms(data, base, &fit.noise);
        Self { data, base, plain, asked, fit, judge, factor, clipped: None, step: *step }
    }

    /// Searches again, and `asked` for other things.
    pub fn search(&mut self, asked: Asked<'_>) {
        self.fit = identify_block(self.data, &self.judge, self.base.to_vec(), asked, &mut |_| {});
    }

    /// Fits the given model anew under the noise that was found last.
    pub fn fit_plain(&mut self) {
        self.plain = fit_terms(self.data, self.base, &self.fit.noise);
    }

    /// Puts the model without clipping first on the path.
    pub fn put_before(&mut self, clipped: &'a Clipped) {
        let layout = Layout::new(&clipped.before, self.data.channels);
        let data = Data { block: &clipped.before, layout: &layout, ..self.data };
        let judge = Judge { data, ..self.judge };
        let white = NoiseModel::white(layout.runs());
        let base: Vec<Shape> = self.fit.base.iter().map(|found| found.shape.clone()).collect();
        let metrics = judge.judge(&base, &white);
        self.put_first(metrics, std::slice::from_ref(&clipped.shape.name));
        self.clipped = Some((clipped, judge.judge(&self.fit.shapes(), &white)));
    }

    /// Puts a plainer model with these errors first on the path; all others have `names` that it lacks.
    pub fn put_first(&mut self, metrics: Vec<Metric>, names: &[String]) {
        let of = metrics.iter().zip(&self.fit.path[self.fit.chosen].metrics);
        let margins = of.map(|(plain, chosen)| margin(plain, chosen)).collect();
        for model in &mut self.fit.path {
            model.effects.splice(0..0, names.iter().cloned());
        }
        self.fit.path.insert(0, Waypoint { effects: Vec::new(), causes: 0, metrics, margins });
        self.fit.chosen += 1;
    }

    /// Clipping as a found term, and its effect.
    pub fn clipping(&self) -> Option<(Found, Effect)> {
        let (clipped, without) = self.clipped.as_ref()?;
        let found = Found {
            shape: clipped.shape.clone(),
            coefficients: vec![(clipped.gain, f64::NAN)],
            numbers: clipped.errors.clone(),
            strength: clipped.strength,
            rivals: Vec::new(),
        };
        let after = &self.fit.path[self.fit.chosen].metrics[0];
        let mut effect = outcome::effect(self.data, &found, without[0].value(), after.value());
        // The model needs both ends; where no reading stands at one, nothing is known of it.
        let is_known =
            |one: &Parameter| !one.name.ends_with("limit") || one.standard_error.is_some();
        effect.parameters.retain(is_known);
        Some((found, effect))
    }

    /// Held-out errors of the given model and of the model found; the latter by the nested choice.
    pub fn errors(&self) -> (&[Metric], &[Metric]) {
        (&self.fit.path[0].metrics, &self.fit.nested)
    }

    /// The rounding effect, if rounding is coarser than the noise.
    pub fn rounding(&self) -> Option<Effect> {
        self.step.map(|step| outcome::rounding(self.data, &self.fit, step))
    }

    /// Held-out error over the innovation noise of a reading together with the errors of readings that have a name: rounding, which is spread evenly over
    /// its step, and an `offset` of each run.
    pub fn error_over_known(&self, offset: Option<&OffsetOfRuns>) -> Option<f64> {
        let rounded = self.step.map_or(0.0, |step| step.powi(2) / 12.0);
        let offset = offset.map_or(0.0, |found| found.deviation);
        self.error_over(rounded + offset.powi(2))
    }

    /// Held-out error over the innovation noise of a reading and a `known` variance, for blocks whose observations are single
    /// rows.
    pub fn error_over(&self, known: f64) -> Option<f64> {
        let is_row = self.data.block.aggregate == Aggregate::Row;
        let error = self.errors().1.first()?.errors.rmse();
        (is_row && self.fit.floor > 0.0).then(|| error / (self.fit.floor.powi(2) + known).sqrt())
    }

    /// How firmware removes the errors that were found, or why it cannot.
    pub fn compensation(
        &self,
        dataset: &Dataset,
        seed: u64,
    ) -> Result<Option<Compensation>, String> {
        if self.data.block.is_blind {
            let label = &self.data.block.label;
            return Err(format!(
                "`{label}` has no compensation: it shows nothing of what its reference does"
            ));
        }
        let asked = (self.factor, &*self.fit.all());
        let mut found = compensation(dataset, self.data, asked, &self.fit.noise, seed)?;
        let clipped = self.clipped.iter().map(|(clipped, _)| LeftOut {
            term: clipped.shape.name.clone(),
            why: "what lies beyond a limit is lost".to_owned(),
        });
        found.iter_mut().for_each(|found| found.left_out.extend(clipped.clone()));
        Ok(found)
    }

    /// Held-out errors without an effect, and without the other powers of the same polynomial.
    pub fn without(&self, effect: usize) -> Vec<Metric> {
        let effects = self.fit.effects.iter().map(|found| &found.shape);
        let gone = &self.fit.effects[effect].shape;
        let others = effects
            .enumerate()
            .filter(|(index, shape)| *index != effect && !shape.shares_polynomial(gone));
        let base = self.fit.base.iter().map(|found| &found.shape);
        let shapes: Vec<Shape> = base.chain(others.map(|(_, shape)| shape)).cloned().collect();
        self.judge.judge(&shapes, &self.fit.noise)
    }
}
