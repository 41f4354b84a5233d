//! Speed of the simulated world relative to real time, per second of processor time.
//!
//! `cargo bench -p harness --bench worlds`. Each figure is the median of [`RUNS`] runs in this process, with best and
//! worst beside it, because a shared machine is noisy. The world runs on one core.

mod processor;

use harness::run::{Prepared, simulate};
use plan::made::Made;
use processor::{RUNS, processor_s};
use record::run_folder::RunFolder;
use record::sink::{Level, NullSink, RecordSink};
use rig::operator::Answers;

fn main() {
    // `cargo test --benches` only checks that it starts.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    println!("{:<46} {:>10} {:>10} {:>10}  unit", "", "median", "best", "worst");
    let observed = prepared("laps-observed");
    let long =
        |sink: &mut dyn FnMut() -> Box<dyn RecordSink>| times(|| seconds(&observed, &mut sink()));
    let mut null = || Box::new(NullSink) as Box<dyn RecordSink>;
    report("laps-observed, 17.6 h, no record", "x real time", long(&mut null));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let events = sink_in(&folder, "events", &observed, Level::Events);
    report("laps-observed, events recorded", "x real time", long(&mut { events }));
    let full = sink_in(&folder, "full", &observed, Level::Full);
    report("laps-observed, every byte recorded", "x real time", long(&mut { full }));
    for plan in ["laps-corrected", "laps-corrected-serial"] {
        let corrected = prepared(plan);
        // 40 laps with everything around them, including the two hours of warm-up.
        let laps = times(|| {
            let cpu = processor_s();
            simulate(&corrected, 1, &Answers::default(), &mut NullSink, &mut |_| true);
            40.0 / (processor_s() - cpu)
        });
        report(&format!("{plan}, 40 laps"), "laps/s", laps);
    }
    println!("peak memory of this process: {}", peak_memory());
}

fn prepared(plan: &str) -> Prepared {
    Prepared::load(plan, &Made::default()).expect("a shipped plan is right")
}

fn sink_in(
    folder: &tempfile::TempDir,
    name: &str,
    prepared: &Prepared,
    level: Level,
) -> impl FnMut() -> Box<dyn RecordSink> {
    let (path, header) = (folder.path().join(name), prepared.header(1));
    move || {
        let folder = RunFolder::create(&path).expect("a folder of ours");
        Box::new(folder.record_sink(&header, level).expect("a new record"))
    }
}

/// Bench time over processor time of one run.
fn seconds(prepared: &Prepared, sink: &mut Box<dyn RecordSink>) -> f64 {
    let cpu = processor_s();
    let run = simulate(prepared, 1, &Answers::default(), sink, &mut |_| true);
    run.end.as_secs_f64() / (processor_s() - cpu)
}

fn times(mut one: impl FnMut() -> f64) -> [f64; RUNS] {
    let mut figures = [0.0; RUNS];
    one();
    figures.fill_with(&mut one);
    figures.sort_by(f64::total_cmp);
    figures
}

fn report(what: &str, unit: &str, figures: [f64; RUNS]) {
    let [worst, .., best] = figures;
    println!("{what:<46} {:>10.0} {best:>10.0} {worst:>10.0}  {unit}", figures[RUNS / 2]);
}

fn peak_memory() -> String {
    std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("VmHWM:"))?;
            Some(line.trim_start_matches("VmHWM:").trim().to_owned())
        })
        .unwrap_or_else(|| "not told by this system".to_owned())
}
