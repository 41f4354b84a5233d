//! Golden records: byte-exact results of every shipped plan, the plans of a new project and three campaigns. A change
//! without intended effects must not change any of these lines; other changes must change only the intended lines.
//!
//! `HIL_GOLDEN=write cargo test -p tests --test scenarios golden` regenerates the tables in `tests/tests/golden`.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use campaign::{Campaign, Guided, Journal, Settings, Space, run};
use harness::executors::Simulated;
use harness::operator::Answers;
use harness::run::{Prepared, simulate};
use hil::project::Template;
use judge::checks::judge_all;
use plan::Name;
use plan::library::{Kind, names};
use plan::made::Made;
use record::sink::{FileSink, Level};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// CRC-64 of what is written, after the first `skip` bytes.
struct Digest<'a> {
    skip: usize,
    bytes: u64,
    digest: &'a mut crc::Digest<'static, u64>,
}

static CRC: crc::Crc<u64> = crc::Crc::<u64>::new(&crc::CRC_64_XZ);

impl Write for Digest<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let skipped = self.skip.min(bytes.len());
        self.skip -= skipped;
        self.bytes += (bytes.len() - skipped) as u64;
        self.digest.update(&bytes[skipped..]);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Formats the record of one run and its verdicts as lines. Uses the shipped calibrations, so the lines are
/// self-contained.
fn golden(name: &str, prepared: &Prepared) -> String {
    /// Magic, version, and length of the header's block, followed by a line feed and a checksum.
    const FRAME: usize = 8 + 2 + 4 + 1 + 4;
    let header = prepared.header(1);
    let json = serde_json::to_vec(&header).unwrap();
    let mut digest = CRC.digest();
    let mut out = Digest { skip: json.len() + FRAME, bytes: 0, digest: &mut digest };
    let mut sink = FileSink::new(&mut out, &header, Level::Full).unwrap();
    let run = simulate(prepared, 1, &Answers::default(), &mut sink, &mut |_| true);
    drop(sink);
    let bytes = out.bytes;
    let mut lines = format!(
        "{name}: header {:016x}, {bytes} bytes {:016x}, {}\n",
        CRC.checksum(&json),
        digest.finalize(),
        run.ending.outcome.name()
    );
    let (measurements, _) = judge_all(&prepared.plan.measurements, &run.observations);
    for measurement in &measurements {
        let verdict = measurement.verdict.name();
        writeln!(lines, "  {} {:?} {verdict}", measurement.name, measurement.value).unwrap();
    }
    lines
}

/// Creates a project as `hil new` does.
fn project(template: Template) -> TempDir {
    let files = template.files(&Name::new("oven").unwrap());
    tests::project::of(files.into_iter().map(|file| (file.path, file.bytes)))
}

fn plans(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut plans: Vec<_> =
        entries.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    plans.sort();
    plans
}

/// Runs a campaign; its durations are left out.
fn campaign(name: &str, prepared: Prepared, cases: u64) -> String {
    let is_of_device = prepared.plan.device.is_some();
    let executor = Simulated::new(prepared.clone(), Answers::default());
    let executor = if is_of_device { executor.that_must_pass() } else { executor };
    let (horizon, _) = campaign::Executor::without_faults(&executor, 1);
    let space = Space::new(&prepared.plan, prepared.rig.struck(), horizon, 4, &[]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cases.jsonl");
    let mut journal = Journal::open(&path, "golden").unwrap();
    let threads = NonZeroUsize::new(2).unwrap();
    let settings = Settings { cases, threads, shrink_max: 100 };
    let mut search = Guided::new(&space, 1);
    let came: Campaign =
        run(&executor, &mut search, &BTreeMap::new(), &settings, &mut journal, &mut |_| true)
            .unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    // Each build has another number, and the same cases.
    let (before, build) = text.split_once(" (build ").unwrap();
    let (_, after) = build.split_once(')').unwrap();
    let text = format!("{before}{after}");
    let mut kept: Vec<_> = text.lines().collect();
    kept.sort();
    let broken: Vec<_> = came.found.iter().map(|found| found.property.as_str()).collect();
    format!(
        "campaign {name}: {} cases {:016x}, found {broken:?}\n",
        came.tally.cases,
        CRC.checksum(kept.join("\n").as_bytes())
    )
}

/// Compares lines with the stored ones; reports those that differ.
fn assert_golden(file: &str, found: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(file);
    if std::env::var("HIL_GOLDEN").is_ok_and(|what| what == "write") {
        std::fs::write(&path, found).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    let differ: Vec<_> =
        found.lines().filter(|line| !kept.lines().any(|known| known == *line)).collect();
    assert!(
        kept == found,
        "{} differs in:\n{}\n\nall of it:\n{found}",
        path.display(),
        differ.join("\n")
    );
}

#[test]
fn the_records_of_the_shipped_plans() {
    let needs_another = |name: &String| name != "close-the-loop";
    let names: Vec<String> = names(Kind::Plan).into_iter().filter(needs_another).collect();
    let lines = std::thread::scope(|scope| {
        let (first, second) = names.split_at(names.len() / 2);
        let table = |names: &[String]| -> String {
            names
                .iter()
                .map(|name| golden(name, &Prepared::load(name, &Made::default()).unwrap()))
                .collect()
        };
        let second = scope.spawn(move || table(second));
        let first = table(first);
        first + &second.join().unwrap()
    });
    assert_golden("plans.txt", &lines);
}

#[test]
fn the_records_of_a_new_project() {
    let mut lines = String::new();
    for (title, template) in [("can", Template::Can), ("serial", Template::Serial)] {
        let folder = project(template);
        for plan in plans(folder.path()) {
            let prepared = Prepared::load(plan.to_str().unwrap(), &Made::default()).unwrap();
            lines += &golden(&format!("{title}/{}", prepared.plan.name.as_str()), &prepared);
        }
    }
    assert_golden("projects.txt", &lines);
}

#[test]
fn the_cases_of_three_campaigns() {
    let folder = project(Template::Can);
    let plan = folder.path().join("settles.toml");
    let load = |name: &str| Prepared::load(name, &Made::default()).unwrap();
    let lines = [
        campaign("live-side", load("live-side"), 64),
        campaign("laps-corrected-serial", load("laps-corrected-serial"), 2),
        campaign("settles", load(plan.to_str().unwrap()), 64),
    ];
    assert_golden("campaigns.txt", &lines.concat());
}
