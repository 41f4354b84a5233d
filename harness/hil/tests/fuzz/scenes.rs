//! Every command that reads a file, with such files.

use crate::room::Files;
use crate::seeds::Seeds;
use std::time::Duration;

/// How a command ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Soon, whatever it read.
    ByItself,
    /// It may run for long, and ends at once when asked to.
    Asked,
    /// In real time: it is asked to end after this time.
    After(Duration),
}

/// A command and its files.
#[derive(Debug, Clone)]
pub struct Scene {
    pub arguments: Vec<String>,
    pub files: Files,
    /// Files that get mutated.
    pub inputs: Vec<String>,
    /// File for the standard input.
    pub stdin: Option<String>,
    pub end: End,
    /// Relative frequency.
    pub weight: usize,
}

impl Scene {
    /// Returns the command, or `emulate device` and the like, whose help names the exit statuses.
    pub fn command(&self) -> &str {
        &self.arguments[0]
    }

    fn new(line: &str, files: &Files, inputs: &str, end: End, weight: usize) -> Self {
        let inputs = inputs.split_whitespace().map(str::to_owned).collect();
        let arguments: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        Self { arguments, files: files.clone(), inputs, stdin: None, end, weight }
    }

    fn hearing(mut self, name: &str) -> Self {
        self.stdin = Some(name.to_owned());
        self.inputs.push(name.to_owned());
        self
    }
}

/// Returns all scenes.
pub fn all(seeds: &Seeds) -> Vec<Scene> {
    use End::{After, Asked, ByItself};
    let soon = After(Duration::from_millis(300));
    let mut scenes = Vec::new();
    let mut add = |of: &str, line: &str, inputs: &str, end, weight| {
        let files = seeds.project(of);
        for input in inputs.split_whitespace() {
            assert!(files.contains_key(input), "no {input} in {of}: {:?}", files.keys());
        }
        scenes.push(Scene::new(line, files, inputs, end, weight));
    };

    let oven = "short.toml short.toml devices/oven.toml devices/oven.toml devices/oven.dbc";
    add("oven", "run short.toml --quiet", oven, Asked, 10);
    add("oven", "run short.toml --record full --json", oven, Asked, 4);
    add("oven", "run short.toml --watch", oven, Asked, 2);
    add("oven", "run noisy-bus.toml", "noisy-bus.toml devices/oven.toml", Asked, 3);
    add("oven", "run short.toml --seeds 2", "short.toml devices/oven.toml", Asked, 1);
    add("oven", "run short.toml --verify-determinism", "short.toml", Asked, 1);
    add(
        "oven",
        "list",
        "short.toml devices/oven.toml devices/oven.dbc benches/real.toml",
        ByItself,
        4,
    );
    add("oven", "list --json", "short.toml devices/oven.toml benches/emulated.toml", ByItself, 2);
    add("oven", "draw short.toml", oven, ByItself, 6);
    add("oven", "draw short.toml --bench benches/real.toml", "benches/real.toml", ByItself, 2);
    add(
        "oven",
        "doctor short.toml --bench benches/real.toml",
        "benches/real.toml short.toml",
        ByItself,
        4,
    );
    add(
        "oven",
        "emulate device devices/oven.toml --port slcan-pty",
        "devices/oven.toml devices/oven.dbc",
        soon,
        1,
    );
    add("oven", "campaign short.toml --cases 2 --shrink-max 2 --threads 1", oven, Asked, 2);
    add(
        "serial",
        "run settles.toml --quiet",
        "settles.toml devices/oven.toml devices/oven.toml",
        Asked,
        6,
    );
    add(
        "serial",
        "run noisy-line.toml --record full",
        "noisy-line.toml devices/oven.toml",
        Asked,
        2,
    );
    add("heater", "run warms.toml", "warms.toml devices/heater.toml", Asked, 4);
    add(
        "sensor",
        "run turns.toml",
        "turns.toml devices/yaw-sensor.toml devices/gyro.model.toml",
        Asked,
        6,
    );
    add(
        "pack",
        "draw charge.toml",
        "charge.toml rigs/pack.toml devices/cells.toml devices/charger.toml devices/pack.dbc",
        ByItself,
        10,
    );
    add(
        "pack",
        "doctor charge.toml deadlines.toml",
        "deadlines.toml deadlines.toml rigs/pack.toml",
        ByItself,
        8,
    );
    add("pack", "run silence.toml", "silence.toml rigs/pack.toml devices/pack.dbc", Asked, 1);
    add(
        "pack",
        "emulate rig rigs/pack.toml --line can0=slcan-pty",
        "rigs/pack.toml devices/cells.toml",
        soon,
        1,
    );
    add(
        "robot",
        "run turn.toml --record full",
        "turn.toml turn.toml devices/mine.toml devices/gyros/gyro.toml devices/bases/base.toml",
        Asked,
        8,
    );
    add(
        "robot",
        "run gap.toml --answers answers.toml",
        "gap.toml answers.toml answers.toml",
        Asked,
        3,
    );
    for plan in ["closing.toml", "calibration.toml", "laps.toml"] {
        add("robot", &format!("doctor {plan} --json"), plan, ByItself, 4);
        add("robot", &format!("run {plan} --quiet"), plan, Asked, 1);
    }
    add(
        "robot",
        "campaign turn.toml --cases 2 --shrink-max 2 --threads 1",
        "turn.toml devices/mine.toml",
        Asked,
        2,
    );
    add(
        "robot",
        "campaign turn.toml --envelopes --runs 35 --threads 1",
        "turn.toml devices/mine.toml",
        Asked,
        1,
    );
    add("robot", "doctor turn.toml --bench bench.toml", "bench.toml usb.toml", ByItself, 4);
    add(
        "robot",
        "run turn.toml --clock real --controller in-process --bench bench.toml",
        "bench.toml",
        soon,
        1,
    );

    add("record", "show run --limit 2000", "run/record.hilrec", ByItself, 6);
    add(
        "record",
        "check run --quiet",
        "run/record.hilrec run/record.hilrec run/summary.json",
        ByItself,
        6,
    );
    add("record", "check run --json", "run/record.hilrec run/summary.json", ByItself, 3);
    add("record", "check run --plan short.toml", "short.toml run/record.hilrec", ByItself, 3);
    add(
        "record",
        "report run",
        "run/record.hilrec run/record.hilrec run/summary.json",
        ByItself,
        8,
    );
    for export in [
        "--out set",
        "--out set --kind series --gzip",
        "--tables tables",
        "--tables tables --format csv",
        "--mcap x.mcap",
        "--mf4 x.mf4",
        "--bus x.log",
        "--bus x.asc",
        "--bus x.pcapng",
    ] {
        // A package is made from a gyro's data.
        for of in ["record", "robot-record"].into_iter().skip(usize::from(export.contains("set"))) {
            add(
                of,
                &format!("export run {export}"),
                "run/record.hilrec run/record.hilrec run/summary.json",
                ByItself,
                2,
            );
        }
    }
    add("robot-record", "show run --limit 2000", "run/record.hilrec", ByItself, 4);
    add(
        "robot-record",
        "check run",
        "run/record.hilrec run/record.hilrec run/summary.json",
        ByItself,
        6,
    );
    add(
        "robot-record",
        "report run",
        "run/record.hilrec run/record.hilrec run/summary.json",
        ByItself,
        8,
    );
    add("robot-record", "identify run --out found", "run/record.hilrec", ByItself, 2);
    add("old-record", "show run", "run/record.hilrec", ByItself, 4);
    add("old-record", "check run", "run/record.hilrec", ByItself, 4);
    add("old-record", "report run", "run/record.hilrec", ByItself, 4);

    for (name, other) in [
        ("bus.log", "x.asc"),
        ("bus.asc", "x.pcapng"),
        ("bus.pcapng", "x.log"),
        ("bus.blf", "x.mf4"),
        ("bus.trc", "x.blf"),
        ("bus.mf4", "x.trc"),
        ("plain.blf", "x.log"),
        ("plain.mf4", "x.log"),
    ] {
        add("logs", &format!("log convert {name} {other}"), name, ByItself, 8);
        add("logs", &format!("log replay {name} --count-only --json"), name, ByItself, 4);
        add("logs", &format!("import {name} --plan short.toml --out again"), name, ByItself, 5);
    }
    add("logs", "log replay bus.log --port slcan-pty", "bus.log", soon, 1);
    add("logs", "run replayed.toml", "rigs/bus.log rigs/replayed.toml replayed.toml", Asked, 3);

    let package = "set/datapackage.json set/data.csv set/data.csv";
    add("data", "identify set --out found", package, ByItself, 6);
    add(
        "data",
        "identify set --out found --model model.toml --json",
        "set/datapackage.json set/data.csv model.toml model.toml",
        ByItself,
        3,
    );
    add(
        "data",
        "identify set --out found --noise-from noise",
        "noise/datapackage.json noise/data.csv",
        ByItself,
        3,
    );
    add(
        "data",
        "predict set --out found --model model.toml",
        "set/datapackage.json set/data.csv model.toml model.toml",
        ByItself,
        8,
    );
    add("data", "predict set --out found --model model.toml --json", "model.toml", ByItself, 2);
    add(
        "packed",
        "predict set --out found --model model.toml",
        "set/data.csv.gz set/datapackage.json",
        ByItself,
        3,
    );

    add("campaign", "report found", "found/campaign.json found/cases.jsonl", ByItself, 6);
    add(
        "campaign",
        "campaign short.toml --cases 3 --shrink-max 2 --threads 1 --out found",
        "found/campaign.json found/cases.jsonl",
        Asked,
        3,
    );
    add("envelopes", "report found", "found/envelopes.json", ByItself, 6);

    add("dbc", "new car --dbc oven.dbc --node Oven", "oven.dbc", ByItself, 6);
    add("dbc", "new car --dbc pack.dbc --node Cells", "pack.dbc", ByItself, 6);
    add("dbc", "new car --dbc pack.dbc --except Manager", "pack.dbc", ByItself, 6);
    add("dbc", "new car --dbc cantools.dbc --node A", "cantools.dbc", ByItself, 4);

    let table = "devices/drive.eds devices/drive.eds devices/drive.toml turns.toml";
    add("table", "run turns.toml --quiet", table, Asked, 6);
    add("table", "list", "devices/drive.eds turns.toml", ByItself, 3);
    add("table", "new drive --eds devices/drive.eds", "devices/drive.eds", ByItself, 6);

    let unit = "devices/oven.fmu devices/oven.fmu devices/oven.toml heats.toml";
    add("fmu", "run heats.toml --quiet", unit, Asked, 4);
    add("fmu", "run heats.toml --record full", unit, Asked, 2);
    add("fmu", "draw heats.toml", "devices/oven.fmu devices/oven.toml", ByItself, 6);
    add(
        "fmu",
        "emulate device devices/oven.toml --port slcan-pty",
        "devices/oven.fmu devices/oven.toml",
        soon,
        1,
    );
    let device = "devices/oven.toml devices/oven.toml devices/oven.dbc";
    add("oven", "export devices/oven.toml --fmu x.fmu", device, ByItself, 4);

    for set in ["bag", "mcap", "db3", "mf4"] {
        let inputs = format!("{set}/data.{set} {set}/data.{set} {set}/datapackage.json");
        add("bags", &format!("identify {set} --out found"), &inputs, ByItself, 6);
    }

    for line in [
        "emulate gyro --devices devices/mine.toml --pty",
        "emulate base --pty",
        "emulate bench --devices devices/mine.toml --gyro pty --base slcan-pty",
    ] {
        let files = seeds.project("requests");
        let inputs = if line.contains("mine") { "devices/mine.toml" } else { "" };
        scenes.push(Scene::new(line, files, inputs, soon, 1).hearing("requests.jsonl"));
    }
    scenes
}
