//! The steps of a run.

use record::header::StepNote;

pub(super) const STEPS_MAX: usize = 50_000;

/// Maximum nesting depth with a row of its own.
const DEPTH_MAX: usize = 8;

/// Steps narrower than this share of the line are omitted if they begin this close to the last one drawn.
const SHARE_MIN: f64 = 0.002;

#[derive(Debug)]
pub(super) struct Step {
    pub(super) path: String,
    pub(super) title: String,
    pub(super) depth: usize,
    pub(super) begin_s: f64,
    pub(super) end_s: Option<f64>,
    pub(super) label: Option<String>,
    pub(super) acts: bool,
}

impl Step {
    /// Its label, if it has one, else what it does.
    pub(super) fn name(&self) -> &str {
        self.label.as_deref().unwrap_or(&self.title)
    }
}

#[derive(Debug, Default)]
pub(super) struct Steps {
    pub(super) all: Vec<Step>,
    /// Indices of running steps, outermost first.
    open: Vec<usize>,
    pub(super) overflowed: u64,
}

impl Steps {
    pub(super) fn begin(&mut self, at_s: f64, path: &str, title: &str, note: Option<&StepNote>) {
        if self.all.len() >= STEPS_MAX {
            self.overflowed += 1;
            return;
        }
        self.open.push(self.all.len());
        self.all.push(Step {
            path: path.to_owned(),
            title: title.to_owned(),
            depth: (self.open.len() - 1).min(DEPTH_MAX - 1),
            begin_s: at_s,
            end_s: None,
            label: note.and_then(|note| note.label.clone()),
            acts: note.is_some_and(|note| note.acts),
        });
    }

    /// Ends the last running step of this path, and those within it.
    pub(super) fn end(&mut self, at_s: f64, path: &str) {
        let found = self.open.iter().rposition(|&index| self.all[index].path == path);
        if let Some(position) = found {
            for index in self.open.drain(position..) {
                self.all[index].end_s = Some(at_s);
            }
        }
    }

    /// The innermost step at this time; of two that meet there, the one that ends.
    pub(super) fn at(&self, at_s: f64) -> Option<&Step> {
        let is_under_way =
            |step: &&Step| step.begin_s < at_s && step.end_s.is_none_or(|end_s| at_s <= end_s);
        self.all.iter().filter(is_under_way).max_by_key(|step| step.depth)
    }

    pub(super) fn unfinished(&self) -> Option<&str> {
        self.open.last().map(|&index| self.all[index].name())
    }

    pub(super) fn shown(&self, end_s: f64) -> Vec<&Step> {
        let mut last_begin = [f64::NEG_INFINITY; DEPTH_MAX];
        let least = SHARE_MIN * end_s;
        let is_shown = |step: &&Step| {
            let wide = step.end_s.unwrap_or(end_s) - step.begin_s >= least;
            let apart = step.begin_s - last_begin[step.depth] >= least;
            if wide || apart {
                last_begin[step.depth] = step.begin_s;
            }
            wide || apart
        };
        self.all.iter().filter(is_shown).collect()
    }
}
