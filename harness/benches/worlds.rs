//! Speed of the simulated world relative to real time, per second of processor time.
//!
//! `cargo bench -p harness --bench worlds`. Each figure is the median of [`RUNS`] runs in this process, with best and
//! worst beside it, because a shared machine is noisy. The world runs on one core. The first row is the gyro's stream
//! alone: drawn, encoded, decoded and integrated. It is the limit, and tells how fast the machine is.
//!
//! With `--once`, each row runs once and is printed as its name, a tab and its processor time in seconds:
//! `benchmarks/paired` compares two builds by that. With `--machine`, the first row alone is printed: `benchmarks/all` sets
//! it beside each table.

mod processor;

use emulators::gyro::GyroEmulator;
use harness::run::{Prepared, simulate, simulate_watched};
use plan::made::Made;
use processor::{RUNS, grouped, processor_s};
use record::run_folder::RunFolder;
use record::sink::{Level, NullSink, RecordSink};
use rig::operator::Answers;
use std::hint::black_box;
use wire::gyro::{GyroDecoder, GyroOutput};
use wire::packet::Packet;
use wire::time::Timestamp;
use wire::units::Angle;

fn main() {
    // `cargo test --benches` only checks that it starts.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    if std::env::args().any(|argument| argument == "--once") {
        return once();
    }
    let alone = times(|| STREAM_S / stream_alone());
    if std::env::args().any(|argument| argument == "--machine") {
        return println!("{}", grouped(alone[RUNS / 2]));
    }
    println!("| what | figure (best, worst) | aim |\n|---|---|---|");
    report("the gyro's stream alone", REAL_TIME, alone, None);
    let observed = prepared("laps-observed");
    let long = |sink: &mut dyn FnMut() -> Box<dyn RecordSink>| {
        times(|| seconds(&observed, sink().as_mut()))
    };
    let mut null = || Box::new(NullSink) as Box<dyn RecordSink>;
    report(
        "`laps-observed` (40 runs, 17.6 h), no record",
        REAL_TIME,
        long(&mut null),
        Some(100_000.0),
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let events = sink_in(&folder, "events", &observed, Level::Events);
    report("the same, events recorded to a file", REAL_TIME, long(&mut { events }), None);
    let full = sink_in(&folder, "full", &observed, Level::Full);
    report(
        "the same, every byte and frame recorded",
        REAL_TIME,
        long(&mut { full }),
        Some(20_000.0),
    );
    for plan in ["laps-corrected", "laps-corrected-serial"] {
        let corrected = prepared(plan);
        // 40 laps with everything around them, including the two hours of warm-up.
        let laps = times(|| {
            let cpu = processor_s();
            simulate(&corrected, 1, &Answers::default(), &mut NullSink, &mut |_| true);
            40.0 / (processor_s() - cpu)
        });
        report(&format!("`{plan}`, 40 laps and a warm-up of 2 h"), "laps/s", laps, None);
    }
    println!("| peak memory | {} | 200 MB |", peak_memory());
}

const REAL_TIME: &str = "times real time";

/// Bench time of the stream alone.
const STREAM_S: f64 = 10.0 * 3_600.0;

/// Processor time of a gyro's stream without anything around it, s.
fn stream_alone() -> f64 {
    let prepared = prepared("laps-observed");
    let robot = prepared.rig.robot.as_ref().expect("the plan is of the robot");
    let (stream, parameters) = robot.gyro.clone();
    let mut gyro = GyroEmulator::new(parameters, stream, 1, "gyro");
    let mut decoder = GyroDecoder::new(stream);
    let (mut packet, mut heading) = (Packet::new(), 0.0);
    let period_s = stream.format.period().as_secs_f64();
    let cpu = processor_s();
    while gyro.next_wakeup() < Timestamp::from_secs_f64(STREAM_S) {
        if gyro.wake(gyro.next_wakeup(), Angle::ZERO, &mut packet) {
            decoder.feed(packet.as_slice(), |sample| {
                if let GyroOutput::Rate(rate) = sample.output {
                    heading += rate.rad_per_s() * period_s;
                }
            });
        }
    }
    black_box(heading);
    processor_s() - cpu
}

/// Each row once.
fn once() {
    println!("the gyro's stream alone\t{}", stream_alone());
    for plan in ["laps-observed", "laps-corrected", "laps-corrected-serial"] {
        let prepared = prepared(plan);
        let cpu = processor_s();
        simulate(&prepared, 1, &Answers::default(), &mut NullSink, &mut |_| true);
        println!("{plan}\t{}", processor_s() - cpu);
    }
    let prepared = prepared("laps-corrected");
    let cpu = processor_s();
    simulate_watched(&prepared, 1, &Answers::default(), &mut NullSink, &mut |_| true);
    println!("laps-corrected, properties judged\t{}", processor_s() - cpu);
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
fn seconds(prepared: &Prepared, sink: &mut dyn RecordSink) -> f64 {
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

fn report(what: &str, unit: &str, figures: [f64; RUNS], aim: Option<f64>) {
    let [worst, best] = [figures[0], figures[RUNS - 1]].map(grouped);
    let median = figures[RUNS / 2];
    let aim = aim.map_or(String::new(), |aim| {
        format!("{}, {}", grouped(aim), if median >= aim { "met" } else { "missed" })
    });
    println!("| {what} | {} ({best}, {worst}) {unit} | {aim} |", grouped(median));
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
