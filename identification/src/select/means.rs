//! Means of consecutive rows of a long record: a slow shape loses nothing in them and costs little.
use crate::fit::Data;
use crate::model::Shape;
use crate::noise::Layout;
use crate::problem::{Block, Channel, Channels, Exposure};
use crate::signal::Smooth;
use std::cell::OnceCell;
use std::ops::Range;

/// Number of stretches of the record on which a shape is tried both ways, and their total rows.
const PROBES: usize = 60;
const PROBE_ROWS: usize = 24_000;
/// Minimum number of means in a stretch.
const PROBE_MEANS_MIN: usize = 4;
/// Share of variance lost in means from which a shape is too fast for them.
const LOST_MAX: f64 = 0.01;

/// Equations of the means of groups of observations.
pub struct Means {
    equations: Equations,
    layout: Layout,
    groups: Vec<Range<usize>>,
    probe: Probe,
}

/// Equations from which columns of shapes are computed.
struct Equations {
    block: Block,
    channels: Channels,
}

/// Some stretches of the record, row by row and in means.
struct Probe {
    whole: Equations,
    means: Equations,
    /// Number of rows in each mean.
    sizes: Vec<usize>,
}

impl Means {
    /// Means of every `size` observations of `data`, each of a single row.
    pub fn new(data: Data<'_>, size: usize) -> Self {
        let (layout, groups) = data.layout.thinned(size);
        let segments = data.channels.segment_of_rows();
        let begins = |group: usize| {
            let segment = |group: usize| segments[data.block.rows[groups[group].start]];
            group == 0 || segment(group) != segment(group - 1)
        };
        let equations = Equations::new(data, &groups, begins);
        Self { probe: Probe::new(data, &groups, size, begins), equations, layout, groups }
    }

    /// The means as data, without the raw measurements.
    pub fn data(&self) -> Data<'_> {
        let Equations { block, channels } = &self.equations;
        Data::new(block, channels, &self.layout)
    }

    /// Weighted means of `values`, one per observation.
    pub fn of(&self, values: &[f64], weights: &[f64]) -> Vec<f64> {
        let mean = |group: &Range<usize>| {
            let (mut sum, mut weight) = (0.0, 0.0);
            for (value, own) in values[group.clone()].iter().zip(&weights[group.clone()]) {
                sum += own * value;
                weight += own;
            }
            if weight > 0.0 { sum / weight } else { 0.0 }
        };
        self.groups.iter().map(mean).collect()
    }

    /// Times of the means; the white noise of each is that of its observations together.
    pub fn layout(&self, weights: &[f64]) -> Layout {
        let spread = |group: &Range<usize>| weights[group.clone()].iter().sum::<f64>().powf(-0.5);
        self.layout.with_spread(self.groups.iter().map(spread).collect())
    }

    /// Whether `shape` is so slow that the means show all of it.
    pub fn show(&self, shape: &Shape) -> bool {
        let (whole, means) = (self.probe.whole.columns(shape), self.probe.means.columns(shape));
        // All columns together: one column of a wide shape may cover only a few rows.
        let (lost, total) = whole
            .iter()
            .zip(&means)
            .map(|(whole, means)| self.probe.lost(whole, means))
            .fold((0.0, 0.0), |sum, column| (sum.0 + column.0, sum.1 + column.1));
        whole.len() == means.len() && total > 0.0 && lost <= LOST_MAX * total
    }
}

impl Equations {
    /// Equations of the means of `groups` of observations. A stretch of time starts at each group for which `begins` is
    /// true.
    fn new(data: Data<'_>, groups: &[Range<usize>], begins: impl Fn(usize) -> bool) -> Self {
        let Data { block, channels, .. } = data;
        let mean = |values: &[f64]| -> Vec<f64> {
            let of = |group: &Range<usize>| {
                let rows = &block.rows[group.clone()];
                rows.iter().map(|&row| values[row]).sum::<f64>() / rows.len() as f64
            };
            if values.is_empty() { Vec::new() } else { groups.iter().map(of).collect() }
        };
        let mut starts: Vec<usize> = (0..groups.len()).filter(|&group| begins(group)).collect();
        starts.push(groups.len());
        let means = Channels {
            time: mean(&channels.time),
            time_unit: channels.time_unit,
            time_name: channels.time_name.clone(),
            run: groups.iter().map(|group| channels.run[block.rows[group.start]]).collect(),
            segments: starts.windows(2).map(|pair| pair[0]..pair[1]).collect(),
            channels: channels
                .channels
                .iter()
                .map(|channel| Channel {
                    name: channel.name.clone(),
                    role: channel.role,
                    unit: channel.unit,
                    values: mean(&channel.values),
                    smooth: Smooth {
                        level: mean(&channel.smooth.level),
                        slope: mean(&channel.smooth.slope),
                    },
                    range: channel.range,
                })
                .collect(),
            rotation: mean(&channels.rotation),
            rotation_name: channels.rotation_name.clone(),
            rotation_unit: channels.rotation_unit,
            direction_name: channels.direction_name.clone(),
            turning: None,
            sampled: channels.sampled,
            rotation_noise: channels.rotation_noise,
            of_sensor: channels.of_sensor,
            gain: channels.gain,
            interval: OnceCell::new(),
            bends: OnceCell::new(),
        };
        let exposures = block
            .exposures
            .iter()
            .map(|exposure| Exposure {
                acts: exposure.acts,
                per_row: mean(&exposure.per_row),
                unit: exposure.unit.clone(),
            })
            .collect();
        let block = Block {
            axis: block.axis,
            apart: block.apart.clone(),
            rows: (0..groups.len()).collect(),
            exposures,
            constants: block.constants.clone(),
            ..Block::new(&block.label, block.unit.clone())
        };
        Self { block, channels: means }
    }

    fn columns(&self, shape: &Shape) -> Vec<Vec<f64>> {
        shape.observed(&self.block, &self.channels).unwrap_or_default()
    }
}

impl Probe {
    fn new(
        data: Data<'_>,
        groups: &[Range<usize>],
        size: usize,
        begins: impl Fn(usize) -> bool,
    ) -> Self {
        let length = (PROBE_ROWS / PROBES / size).max(PROBE_MEANS_MIN).min(groups.len());
        let (mut chosen, mut first_of_chosen) = (Vec::new(), Vec::new());
        let mut end = 0;
        for probe in 0..PROBES {
            let start = (probe * (groups.len() - length) / (PROBES - 1)).max(end);
            end = (start + length).min(groups.len());
            for group in start..end {
                chosen.push(groups[group].clone());
                first_of_chosen.push(group == start || begins(group));
            }
        }
        let (mut rows, mut first_of_rows) = (Vec::new(), Vec::new());
        for (group, first) in chosen.iter().zip(&first_of_chosen) {
            for row in group.clone() {
                rows.push(row..row + 1);
                first_of_rows.push(*first && row == group.start);
            }
        }
        Self {
            whole: Equations::new(data, &rows, |row| first_of_rows[row]),
            means: Equations::new(data, &chosen, |group| first_of_chosen[group]),
            sizes: chosen.iter().map(ExactSizeIterator::len).collect(),
        }
    }

    /// Sum of squares that a column loses if the mean replaces each of its rows, and its sum of squares about its own
    /// mean.
    fn lost(&self, whole: &[f64], means: &[f64]) -> (f64, f64) {
        let middle = whole.iter().sum::<f64>() / whole.len().max(1) as f64;
        let (mut lost, mut total) = (0.0, 0.0);
        let mut rows = whole.iter();
        for (mean, size) in means.iter().zip(&self.sizes) {
            for value in rows.by_ref().take(*size) {
                lost += (value - mean) * (value - mean);
                total += (value - middle) * (value - middle);
            }
        }
        (lost, total)
    }
}
