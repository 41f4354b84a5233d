//! Progress of runs on the standard error: bars on a terminal, one line per plan elsewhere.

use super::tame::tamed;
use harness::stopwatch::Stopwatch;
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use record::Progress;
use record::figures;
use record::outcome::Summary;
use record::reading::Teller;
use record::run_folder::{RunFolder, RunFolderError};
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tracing_subscriber::fmt::MakeWriter;
use views::console::is_colour_wanted;

/// The message fills the rest of the line, and no more: a bar that wraps cannot be redrawn.
const PLAN_BAR: &str = "{prefix} {bar:20} {pos}/{len} steps, {wide_msg}";
const SHARE_BAR: &str = "{prefix} {bar:20} {percent} %, {eta} left, {wide_msg}";
/// Resolution of [`SHARE_BAR`].
const SHARES: u64 = 1_000;
const SEEDS_BAR: &str = "{prefix} {bar:20} {pos}/{len} seeds, {eta} left";

const RUNS_BAR: &str = "{prefix} {bar:20} {pos} of at most {len} runs, {eta} left";

const CASES_BAR: &str = "{prefix} {bar:20} {pos}/{len} cases, {eta} left";

const READING_BAR: &str = "{prefix} {bar:20} {percent} %, {eta} left";

/// Buffer for output while something else uses the terminal; more is lost.
const ASIDE_BYTES_MAX: usize = 64 * 1024;
/// Lines of that buffer that are shown meanwhile.
const ASIDE_LINES_SHOWN: usize = 3;

/// The standard error. Output through it does not collide with a bar.
#[derive(Debug, Clone)]
pub(super) struct Screen {
    bars: MultiProgress,
    quiet: bool,
    terminal: bool,
    /// The user is typing; redrawing a bar would tear the line.
    held: Arc<AtomicBool>,
    /// Output while something else uses the terminal; shown afterwards.
    aside: Arc<Mutex<Option<Vec<u8>>>>,
}

impl Screen {
    pub(super) fn new(quiet: bool) -> Self {
        let terminal = io::stderr().is_terminal();
        let shown = terminal && !quiet;
        let target =
            if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        Self {
            bars: MultiProgress::with_draw_target(target),
            quiet,
            terminal,
            held: Arc::default(),
            aside: Arc::default(),
        }
    }

    /// Whether only results and errors are wanted.
    pub(super) const fn is_quiet(&self) -> bool {
        self.quiet
    }

    pub(super) fn fancy(&self) -> bool {
        is_colour_wanted(self.terminal)
    }

    /// Prints a line that is always shown.
    pub(super) fn note(&self, text: &str) {
        // If the standard error is closed, the line is lost.
        let _ = writeln!(self.clone(), "{}", tamed(text.trim_end()));
    }

    pub(super) fn prompt(&self) {
        let _ = write!(self.clone(), "> ").and_then(|()| self.clone().flush());
    }

    /// Shows no progress until [`release`](Self::release).
    pub(super) fn hold(&self) {
        self.held.store(true, Ordering::Relaxed);
        // A bar that cannot be cleared for want of a terminal does no harm.
        let _ = self.bars.clear();
    }

    /// Shows progress again.
    pub(super) fn release(&self) {
        self.held.store(false, Ordering::Relaxed);
    }

    /// Prints a line that `--quiet` suppresses.
    pub(super) fn chat(&self, text: &str) {
        if !self.quiet {
            self.note(text);
        }
    }

    /// From now on buffers output: something else is drawn on the terminal.
    pub(super) fn set_aside(&self) {
        self.lock_aside().get_or_insert_default();
    }

    pub(super) fn aside(&self) -> Vec<String> {
        let aside = self.lock_aside();
        let text = String::from_utf8_lossy(aside.as_deref().unwrap_or_default()).into_owned();
        let lines: Vec<&str> = text.lines().collect();
        let first = lines.len().saturating_sub(ASIDE_LINES_SHOWN);
        lines[first..].iter().map(|line| line.escape_debug().to_string()).collect()
    }

    /// Writes the buffered output: the terminal is free again.
    pub(super) fn bring_back(&self) {
        if let Some(kept) = self.lock_aside().take() {
            let _ = io::stderr().write_all(&kept);
        }
    }

    fn lock_aside(&self) -> MutexGuard<'_, Option<Vec<u8>>> {
        self.aside.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn plan(&self, name: &str) -> PlanProgress {
        self.plan_with(self.bar(PLAN_BAR, name))
    }

    pub(super) fn plan_shown_elsewhere(&self) -> PlanProgress {
        self.plan_with(ProgressBar::hidden())
    }

    fn plan_with(&self, bar: ProgressBar) -> PlanProgress {
        PlanProgress { screen: self.clone(), bar, stopwatch: Stopwatch::start() }
    }

    pub(super) fn seeds(&self, name: &str, seeds: u64) -> ProgressBar {
        let bar = self.bar(SEEDS_BAR, name);
        bar.set_length(seeds);
        bar
    }

    pub(super) fn cases(&self, name: &str, cases: u64) -> ProgressBar {
        let bar = self.bar(CASES_BAR, name);
        bar.set_length(cases);
        bar
    }

    /// Starts the progress of at most `runs` runs.
    pub(super) fn runs_at_most(&self, name: &str, runs: u64) -> ProgressBar {
        let bar = self.bar(RUNS_BAR, name).with_finish(ProgressFinish::AndClear);
        bar.set_length(runs);
        bar
    }

    /// Starts the progress of a share from 0 to 1.
    pub(super) fn share(&self, name: &str) -> ShareProgress {
        let bar = self.bar(SHARE_BAR, name);
        bar.set_length(SHARES);
        ShareProgress { bar }
    }

    /// Shows how much of a file has been read, from 0 to 1, on each pass over it; until the last handle is dropped.
    pub(super) fn reading(&self, name: &str) -> Teller {
        let bar = self.bar(READING_BAR, name).with_finish(ProgressFinish::AndClear);
        bar.set_length(SHARES);
        Teller::new(move |share| {
            // The cast saturates.
            let position = (share * SHARES as f64) as u64;
            if position < bar.position() {
                bar.reset();
            }
            bar.set_position(position);
        })
    }

    /// Opens a run folder, and shows how much of its record has been read; also returns its name.
    pub(super) fn opened(&self, run: &Path) -> Result<(String, RunFolder), RunFolderError> {
        let name = run.display().to_string();
        let folder = RunFolder::open(run)?.telling(self.reading(&name));
        Ok((name, folder))
    }

    fn bar(&self, template: &str, name: &str) -> ProgressBar {
        let style = ProgressStyle::with_template(template);
        let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::new(0).with_style(style).with_prefix(name.to_owned());
        self.bars.add(bar)
    }
}

impl Write for Screen {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(kept) = &mut *self.lock_aside() {
            let room = ASIDE_BYTES_MAX.saturating_sub(kept.len());
            kept.extend_from_slice(&bytes[..bytes.len().min(room)]);
            return Ok(bytes.len());
        }
        self.bars.suspend(|| io::stderr().write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

impl<'a> MakeWriter<'a> for Screen {
    type Writer = io::LineWriter<Self>;

    fn make_writer(&'a self) -> Self::Writer {
        io::LineWriter::new(self.clone())
    }
}

#[derive(Debug)]
pub(super) struct ShareProgress {
    bar: ProgressBar,
}

impl ShareProgress {
    pub(super) fn show(&self, share: f64, doing: &str) {
        if self.bar.is_hidden() {
            return;
        }
        // The cast saturates.
        self.bar.set_position((share * SHARES as f64) as u64);
        self.bar.set_message(doing.to_owned());
    }

    pub(super) fn finish(self) {
        self.bar.finish_and_clear();
    }
}

#[derive(Debug)]
pub(super) struct PlanProgress {
    screen: Screen,
    bar: ProgressBar,
    stopwatch: Stopwatch,
}

impl PlanProgress {
    pub(super) fn show(&self, progress: Progress) {
        if self.bar.is_hidden() || self.screen.held.load(Ordering::Relaxed) {
            return;
        }
        let bench_s = progress.now.as_secs_f64();
        self.bar.update(|state| {
            state.set_len(progress.steps);
            state.set_pos(progress.steps_done);
        });
        let bench = figures::duration(bench_s);
        let factor = factor(bench_s, self.stopwatch.elapsed_s());
        let mut message = format!("bench {bench}, {factor}");
        if progress.steps_done > 0 {
            let left = figures::duration(self.bar.eta().as_secs_f64());
            message += &format!(", {left} left");
        }
        self.bar.set_message(message);
    }

    pub(super) fn finish(self, summary: &Summary) {
        self.bar.finish_and_clear();
        let Summary { plan, outcome, simulated_s, wall_s, .. } = summary;
        let (bench, wall) = (figures::duration(*simulated_s), figures::duration(*wall_s));
        let factor = factor(*simulated_s, *wall_s);
        self.screen.chat(&format!("{plan}: {}, bench {bench} in {wall}, {factor}", outcome.name()));
    }
}

/// Formats how much faster than real time the run was.
fn factor(bench_s: f64, wall_s: f64) -> String {
    let times = bench_s / wall_s;
    match times.is_finite() {
        true if times >= 10.0 => format!("{times:.0} times real time"),
        true => format!("{times:.1} times real time"),
        false => "no time yet".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::{CASES_BAR, PLAN_BAR, READING_BAR, RUNS_BAR, SEEDS_BAR, SHARE_BAR, factor};
    use indicatif::ProgressStyle;

    #[test]
    fn the_templates_are_templates() {
        assert!(ProgressStyle::with_template(PLAN_BAR).is_ok());
        assert!(ProgressStyle::with_template(SEEDS_BAR).is_ok());
        assert!(ProgressStyle::with_template(SHARE_BAR).is_ok());
        assert!(ProgressStyle::with_template(READING_BAR).is_ok());
        assert!(ProgressStyle::with_template(RUNS_BAR).is_ok());
        assert!(ProgressStyle::with_template(CASES_BAR).is_ok());
    }

    #[test]
    fn the_factor_has_digits_that_mean_something() {
        assert_eq!(factor(57_600.0, 2.0), "28800 times real time");
        assert_eq!(factor(60.0, 60.0), "1.0 times real time");
        assert_eq!(factor(0.0, 0.0), "no time yet");
    }
}
