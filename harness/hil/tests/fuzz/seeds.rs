//! Valid input to begin with: shipped files, examples, and output of commands.

use crate::room::Files;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// Files of projects, by project name.
#[derive(Debug)]
pub struct Seeds(BTreeMap<&'static str, Files>);

/// Maximum length, so that most mutations hit something relevant.
const BYTES_MAX: usize = 60_000;

impl Seeds {
    pub fn project(&self, name: &str) -> &Files {
        self.0.get(name).unwrap_or_else(|| panic!("no project {name}"))
    }

    /// Returns all files.
    pub fn files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.0.values().flatten().map(|(path, file)| (path.as_str(), file.as_slice()))
    }

    /// Creates the seeds, which takes some seconds.
    pub fn make() -> Self {
        let shop = Shop(tempfile::tempdir().unwrap());
        let mut seeds = BTreeMap::new();
        shop.hil(".", "new oven --quiet");
        shop.hil(".", "new serial/oven --serial --quiet");
        shop.write("oven/short.toml", include_str!("seeds/short.toml"));
        let oven = shop.files("oven");
        seeds.insert("serial", shop.files("serial/oven"));
        seeds.insert("heater", shipped("examples/rust-tests/plans"));
        seeds.insert("pack", shipped("examples/battery-pack"));
        seeds.insert(
            "sensor",
            of(&[
                ("turns.toml", include_str!("seeds/sensor/turns.toml")),
                ("devices/yaw-sensor.toml", include_str!("seeds/sensor/yaw-sensor.toml")),
                ("devices/gyro.model.toml", include_str!("seeds/sensor/gyro.model.toml")),
            ]),
        );
        let robot = robot();
        shop.put("robot", &robot);

        shop.hil("oven", "run short.toml --record full --quiet --out run");
        let run = |project: &str| under("run/", shop.files(&format!("{project}/run")));
        seeds.insert("record", joined([oven.clone(), run("oven")]));
        shop.hil("robot", "run turn.toml --record full --quiet --out run");
        seeds.insert("robot-record", run("robot"));
        let old = fs::read(root().join("harness/record/src/tests/format-2.hilrec")).unwrap();
        seeds.insert("old-record", [("run/record.hilrec".to_owned(), old)].into());

        fs::create_dir(shop.0.path().join("oven/rigs")).unwrap();
        shop.hil("oven", "export run --bus rigs/bus.log");
        let log = fs::read_to_string(shop.0.path().join("oven/rigs/bus.log")).unwrap();
        let log: String = log.split_inclusive('\n').take(200).collect();
        shop.write("oven/bus.log", &log);
        shop.write("oven/rigs/bus.log", &log);
        for format in ["asc", "pcapng", "blf", "trc", "mf4"] {
            shop.hil("oven", &format!("log convert bus.log bus.{format}"));
        }
        shop.write("oven/rigs/replayed.toml", include_str!("seeds/replayed-rig.toml"));
        shop.write("oven/replayed.toml", include_str!("seeds/replayed.toml"));
        fs::copy(
            shop.0.path().join("oven/devices/oven.dbc"),
            shop.0.path().join("oven/rigs/oven.dbc"),
        )
        .unwrap();
        let mut logs = shop.files("oven");
        logs.retain(|path, _| !path.starts_with("run/"));
        // By python-can, uncompressed: BLFWriter and MF4Writer with compression_level=0.
        for name in ["plain.blf", "plain.mf4"] {
            let path = format!("harness/hil/tests/fuzz/seeds/logs/{name}");
            logs.insert(name.to_owned(), fs::read(root().join(path)).unwrap());
        }
        seeds.insert("logs", logs);

        shop.hil(
            "oven",
            "campaign short.toml --cases 2 --shrink-max 2 --threads 1 --quiet --out found",
        );
        seeds.insert("campaign", joined([oven.clone(), under("found/", shop.files("oven/found"))]));
        shop.hil("oven", "campaign short.toml --envelopes --threads 1 --quiet --out wide");
        seeds.insert("envelopes", under("found/", shop.files("oven/wide")));
        seeds.insert("oven", oven);

        for (project, package) in [("data", "--gzip --out packed"), ("data", "--out set")] {
            shop.put(
                project,
                &[("table.toml".to_owned(), include_bytes!("seeds/table.toml").to_vec())].into(),
            );
            shop.hil(project, "run table.toml --quiet --out run");
            shop.hil(project, &format!("export run {package}"));
        }
        shop.hil("data", "export run --kind series --out noise");
        shop.hil("data", "identify set --out found");
        let model = fs::read(shop.0.path().join("data/found/model.toml")).unwrap();
        let mut data = shop.files("data");
        data.retain(|path, _| path.starts_with("set/") || path.starts_with("noise/"));
        data.insert("model.toml".to_owned(), model.clone());
        let mut packed = under("set/", shop.files("data/packed"));
        packed.insert("model.toml".to_owned(), model);
        seeds.insert("packed", packed);
        seeds.insert("data", data);

        let read = |path: &str| fs::read(root().join(path)).unwrap();
        seeds.insert(
            "dbc",
            [
                ("oven.dbc".to_owned(), read("described/tests/data/oven.dbc")),
                ("pack.dbc".to_owned(), read("examples/battery-pack/devices/pack.dbc")),
                ("cantools.dbc".to_owned(), read("described/tests/data/cantools.dbc")),
            ]
            .into(),
        );
        seeds.insert("table", shipped("examples/rotary-table"));
        let bags = "harness/hil/tests/fuzz/seeds/bags";
        // By tests/interop/write_rosbags.py, and by write_measured.py (its `columns`), with 30 rows.
        let files = ["data.bag", "data.mcap", "data.db3", "data.mf4"];
        let packages = ["bag.json", "mcap.json", "db3.json", "mf4.json"];
        let read = |name: &&str| (in_package(name), read(&format!("{bags}/{name}")));
        seeds.insert("bags", files.iter().chain(&packages).map(read).collect());
        let described = include_str!("../../../../docs/fmu.md").split("```toml\n");
        let blocks: Vec<_> = described.filter_map(|text| text.split("```").next()).collect();
        shop.put("fmu", &of(&[("devices/oven.toml", blocks[1]), ("heats.toml", blocks[2])]));
        let unit = shop.0.path().join("fmu/devices/oven.fmu");
        fmu::samples::oven(&unit, 3, str::to_owned);
        seeds.insert("fmu", shop.files("fmu"));
        let requests = include_bytes!("seeds/requests.jsonl").to_vec();
        let hearing = [("requests.jsonl".to_owned(), requests)].into();
        seeds.insert("requests", joined([robot.clone(), hearing]));
        seeds.insert("robot", robot);
        Self(seeds)
    }
}

/// Each bag in a package of its own.
fn in_package(name: &str) -> String {
    match name.split_once('.') {
        Some(("data", end)) => format!("{end}/{name}"),
        Some((end, _)) => format!("{end}/datapackage.json"),
        None => name.to_owned(),
    }
}

/// A temporary folder for creating seeds.
struct Shop(TempDir);

impl Shop {
    fn hil(&self, folder: &str, line: &str) {
        let folder = self.0.path().join(folder);
        let mut command = Command::new(crate::program());
        command.args(line.split_whitespace()).current_dir(folder).stdin(Stdio::null());
        let output = command.output().unwrap();
        // A campaign may find a failure, and a plan may fail.
        assert!(matches!(output.status.code(), Some(0 | 1)), "{line}: {output:?}");
    }

    fn write(&self, path: &str, text: &str) {
        fs::write(self.0.path().join(path), text).unwrap();
    }

    fn put(&self, folder: &str, files: &Files) {
        for (path, content) in files {
            let path = self.0.path().join(folder).join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, content).unwrap();
        }
    }

    fn files(&self, folder: &str) -> Files {
        let mut found = Files::new();
        gather(&self.0.path().join(folder), "", &mut found);
        found
    }
}

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn shipped(folder: &str) -> Files {
    let mut found = Files::new();
    gather(&root().join(folder), "", &mut found);
    found
}

/// Collects the files that a command may read, without those only for people.
fn gather(folder: &Path, prefix: &str, found: &mut Files) {
    const READ: [&str; 19] = [
        "toml", "dbc", "hilrec", "json", "jsonl", "log", "asc", "pcapng", "blf", "trc", "mf4",
        "csv", "gz", "py", "xml", "html", "svg", "eds", "fmu",
    ];
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && !matches!(name.as_str(), "src" | "tests" | "schemas" | "target") {
            gather(&path, &format!("{prefix}{name}/"), found);
        } else if READ.iter().any(|end| path.extension().is_some_and(|of| of == *end))
            && !matches!(name.as_str(), "Cargo.toml" | "report.html" | "junit.xml")
        {
            let content = fs::read(&path).unwrap();
            assert!(content.len() < 10 * BYTES_MAX, "{} is too long", path.display());
            found.insert(format!("{prefix}{name}"), content);
        }
    }
}

fn robot() -> Files {
    let read = |path: &str| fs::read(root().join(path)).unwrap();
    let mut files = of(&[
        ("turn.toml", include_str!("seeds/robot/turn.toml")),
        ("gap.toml", include_str!("seeds/robot/gap.toml")),
        ("answers.toml", include_str!("seeds/robot/answers.toml")),
        ("bench.toml", include_str!("seeds/robot/bench.toml")),
        ("devices/mine.toml", include_str!("seeds/robot/mine.toml")),
    ]);
    for (path, shipped) in [
        ("closing.toml", "test-plans/close-the-loop.toml"),
        ("calibration.toml", "test-plans/temperature-calibration.toml"),
        ("laps.toml", "test-plans/laps-corrected.toml"),
        ("usb.toml", "test-plans/benches/usb.toml"),
        ("devices/gyros/gyro.toml", "test-plans/devices/gyros/navigator.toml"),
        ("devices/bases/base.toml", "test-plans/devices/bases/k2a.toml"),
    ] {
        files.insert(path.to_owned(), read(shipped));
    }
    files
}

fn of(files: &[(&str, &str)]) -> Files {
    files.iter().map(|(path, text)| ((*path).to_owned(), text.as_bytes().to_vec())).collect()
}

fn under(folder: &str, files: Files) -> Files {
    files.into_iter().map(|(path, file)| (format!("{folder}{path}"), file)).collect()
}

fn joined<const N: usize>(all: [Files; N]) -> Files {
    all.into_iter().flatten().collect()
}
