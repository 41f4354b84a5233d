//! The steps of a run.

/// Maximum number of steps.
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
}

/// The steps of a run, in order of their begin.
#[derive(Debug, Default)]
pub(super) struct Steps {
    pub(super) all: Vec<Step>,
    /// Indices of running steps, outermost first.
    open: Vec<usize>,
    pub(super) overflowed: u64,
}

impl Steps {
    pub(super) fn begin(&mut self, at_s: f64, path: &str, title: &str) {
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

    /// Title of the innermost step that did not end.
    pub(super) fn unfinished(&self) -> Option<&str> {
        self.open.last().map(|&index| self.all[index].title.as_str())
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
