//! Runs the fixed evaluation and writes its figures.

use clap::Parser;
use evaluation::catalogue::{Case, cases, nulls, timing_cases};
use evaluation::figures::Figures;
use evaluation::package;
use evaluation::run::{Identifier, Outcome, dataset, run};
use evaluation::score::Cost;
use identification::dataset::Dataset;
use identification::finding::{Finding, Prediction};
use identification::identify::{self, Identified, Options};
use std::io::{self, IsTerminal, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How well does the identification do?
#[derive(Parser)]
struct Arguments {
    /// A tenth of the cases, without those that are only timed. Writes nothing unless --out is given.
    #[arg(long)]
    quick: bool,
    /// Only cases whose name holds this. Writes nothing unless --out is given.
    #[arg(long, value_name = "SUBSTRING")]
    only: Option<String>,
    /// Writes the cases as data packages into this folder instead of identifying them.
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
    /// Where the figures go [default: docs].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Cases at a time.
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// Other cases than the frozen ones, to work on. Writes nothing unless --out is given.
    #[arg(long, value_name = "N", default_value_t = 0)]
    shift_seeds: u64,
    /// Leaves out the cases that are only timed.
    #[arg(long)]
    untimed: bool,
    /// Only noise, in that many times as many cases. Writes nothing unless --out is given.
    #[arg(long, value_name = "N")]
    nulls: Option<usize>,
    /// Prints what was found in each case.
    #[arg(long)]
    cases: bool,
    /// Lists the names of the cases.
    #[arg(long)]
    list: bool,
    /// Identifies the real sets in the folders below this one instead.
    #[arg(long, value_name = "DIR")]
    measured: Option<PathBuf>,
}

/// One case in this many is quick.
const QUICK: usize = 10;

/// The identification itself, with its defaults.
struct Real;

impl Identifier for Real {
    type Model = IdentifiedModel;

    fn identify(
        &self,
        dataset: &Dataset,
        max_effects: Option<usize>,
    ) -> Result<(Finding, Self::Model), String> {
        let mut options = Options::default();
        options.max_effects = max_effects.unwrap_or(options.max_effects);
        let identified = guarded(|| identify::identify(dataset, None, &options, &mut |_, _| {}))?;
        Ok((identified.finding.clone(), IdentifiedModel(identified)))
    }

    fn predict(&self, dataset: &Dataset, model: &Self::Model) -> Result<Prediction, String> {
        guarded(|| identify::predict(dataset, &model.0.model))
    }
}

/// The result, of which only the model is used.
struct IdentifiedModel(Identified);

/// Catches a panic, so that one case does not end all others.
fn guarded<T>(work: impl FnOnce() -> Result<T, identify::IdentifyError>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work))
        .map_err(|_| "panicked".to_owned())?
        .map_err(|error| error.to_string())
}

fn main() -> ExitCode {
    match evaluate(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn evaluate(arguments: &Arguments) -> io::Result<()> {
    evaluation::random::shift_seeds(arguments.shift_seeds);
    let every = arguments.nulls.map_or_else(cases, nulls);
    let out_of = every.len();
    let wanted = |case: &Case| {
        arguments.only.as_ref().is_none_or(|text| case.name().contains(text.as_str()))
    };
    let stride = if arguments.quick { QUICK } else { 1 };
    let chosen: Vec<Case> = every.into_iter().filter(wanted).step_by(stride).collect();
    if let Some(folder) = &arguments.measured {
        return measured(folder, arguments.only.as_deref());
    }
    if arguments.list {
        let mut out = io::stdout().lock();
        return chosen.iter().try_for_each(|case| writeln!(out, "{}", case.name()));
    }
    if let Some(folder) = &arguments.dump {
        return chosen.iter().try_for_each(|case| dump(case, folder));
    }
    let timing = timing_cases().into_iter().filter(|case| {
        !arguments.quick && !arguments.untimed && arguments.nulls.is_none() && wanted(case)
    });
    let costs = timing.map(|case| cost(&case)).collect();
    let outcomes = in_parallel(&chosen, arguments.threads);
    if arguments.cases {
        for outcome in &outcomes {
            println!(
                "{} {} rivals {:?} gain {:?} of {:.4?} covered {:?} {:.2} s {:?} {}",
                outcome.case,
                if outcome.false_alarm { "ALARM" } else { "" },
                outcome.rivals,
                outcome.gain_ratio,
                outcome.errors.iter().map(|[a, b, best]| [a / best, b / best]).collect::<Vec<_>>(),
                outcome.covered,
                outcome.seconds,
                outcome.found,
                match (outcome.detected, outcome.first, outcome.within) {
                    _ if outcome.failed.is_some() => outcome.failed.clone().unwrap_or_default(),
                    (false, ..) => "NOT DETECTED".to_owned(),
                    (_, false, true) => "NOT FIRST".to_owned(),
                    (_, _, false) => "NOT WITHIN".to_owned(),
                    _ => String::new(),
                }
            );
        }
    }
    let figures = Figures::new(outcomes, costs, out_of);
    let page = figures.markdown();
    let whole = !arguments.quick
        && arguments.only.is_none()
        && arguments.nulls.is_none()
        && arguments.shift_seeds == 0;
    let folder = arguments.out.clone().or_else(|| whole.then(|| PathBuf::from("docs")));
    if let Some(folder) = folder {
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join("identification-figures.md"), &page)?;
        let json = serde_json::to_string_pretty(&figures).map_err(io::Error::other)?;
        std::fs::write(folder.join("identification-figures.json"), json + "\n")?;
    }
    io::stdout().lock().write_all(page.as_bytes())
}

/// Runs the cases in order on that many threads, each with one case at a time.
fn in_parallel(cases: &[Case], threads: usize) -> Vec<Outcome> {
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(Vec::with_capacity(cases.len()));
    let shows = io::stderr().is_terminal();
    let work = || {
        while let Some((number, case)) = {
            let number = next.fetch_add(1, Ordering::Relaxed);
            cases.get(number).map(|case| (number, case))
        } {
            let outcome = run(case, &Real, &seconds);
            if shows {
                eprint!("\r{number:5} of {}", cases.len());
            }
            // A poisoned lock still holds complete outcomes.
            outcomes
                .lock()
                .unwrap_or_else(|poisoned| poisoned.into_inner())
                .push((number, outcome));
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(work);
        }
    });
    let mut outcomes = outcomes.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    outcomes.sort_by_key(|(number, _)| *number);
    outcomes.into_iter().map(|(_, outcome)| outcome).collect()
}

fn cost(case: &Case) -> Cost {
    // On Linux, writing 5 here resets the peak; elsewhere the peak is that of all cases so far.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    let outcome = run(case, &Real, &seconds);
    Cost {
        case: case.effect.clone(),
        rows: outcome.rows,
        seconds: outcome.seconds,
        peak_megabytes: peak_megabytes(),
        failed: outcome.failed,
    }
}

fn peak_megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024.0 / 1e6)
}

/// Time that this thread had a processor, in seconds: other work on the machine does not count. Where the system does
/// not tell, a monotonic clock.
fn seconds() -> f64 {
    let of_thread = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = of_thread.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(elapsed, |nanoseconds| 1e-9 * nanoseconds)
}

fn elapsed() -> f64 {
    use std::sync::LazyLock;
    use std::time::Instant;
    #[expect(
        clippy::disallowed_methods,
        reason = "the time that the identification takes is measured"
    )]
    fn now() -> Instant {
        Instant::now()
    }
    static START: LazyLock<Instant> = LazyLock::new(now);
    START.elapsed().as_secs_f64()
}

fn dump(case: &Case, folder: &Path) -> io::Result<()> {
    let Some(dataset) = dataset(case) else { return Ok(()) };
    let folder = folder.join(case.name());
    std::fs::create_dir_all(&folder)?;
    let descriptor =
        serde_json::to_string_pretty(&package::descriptor(&dataset)).map_err(io::Error::other)?;
    std::fs::write(folder.join("datapackage.json"), descriptor + "\n")?;
    std::fs::write(folder.join(package::CSV), package::csv(&dataset))
}

/// Prints the finding for each real set.
fn measured(folder: &Path, only: Option<&str>) -> io::Result<()> {
    let mut folders: Vec<PathBuf> = std::fs::read_dir(folder)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.join("datapackage.json").exists())
        .filter(|path| {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
            only.is_none_or(|only| {
                only.split(',').any(|only| name.as_deref().is_some_and(|name| name.contains(only)))
            })
        })
        .collect();
    folders.sort();
    for folder in folders {
        let start = seconds();
        let dataset = match evaluation::measured::read(&folder) {
            Ok(dataset) => dataset,
            Err(error) => {
                println!("{}: {error}", folder.display());
                continue;
            }
        };
        let read = seconds();
        match guarded(|| identify::identify(&dataset, None, &Options::default(), &mut |_, _| {})) {
            Err(error) => println!("== {}: {error}", dataset.name),
            Ok(found) => {
                println!(
                    "== {} read {:.1} s, identified {:.1} s",
                    dataset.name,
                    read - start,
                    seconds() - read
                );
                println!("{}", evaluation::measured::summary(&found.finding));
            }
        }
    }
    Ok(())
}
