//! Pages of all kinds, created by the binary.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A title that would do harm if it were interpreted; with TOML escapes.
const HOSTILE: &str =
    r#"</title></script><img src=x onerror=\"document.title='hacked'\"> \u202Egpj\u0007"#;

/// The same title as displayed.
pub const HOSTILE_SHOWN: &str =
    "</title></script><img src=x onerror=\"document.title='hacked'\"> \\u{202e}gpj\u{2407}";

/// A turn with faults and properties.
const STRUCK: &str = r#"
name = "struck"
title = "TITLE"
devices = "paper"
steps = [
    { use_calibration = "temperature" },
    { wait = { duration_s = 8 } },
    { bias_test = { duration_s = 5 } },
    { turn = { angle_deg = 90 } },
    { straight = { distance_m = 1, speed_m_per_s = 0.4 } },
]

[[measurement]]
name = "stop_error"
doc = "Turned minus commanded angle"
quantity = "turn.stop_error"
unit = "deg"
check = { all_within = [-5, 5] }
paper = "PAPER"

[[measurement]]
name = "too_narrow"
doc = "A band that nothing is in"
quantity = "straight.stop_error"
unit = "m"
check = { all_within = [0.5, 0.6] }

[[property]]
always = { recovers = {} }

[[property]]
sometimes = "gyro_silent"
"#;

/// Sixteen hours at rest, with one reading every two seconds.
const LOG: &str = r#"
name = "log"
title = "Sixteen hours at rest"
devices = "paper-table"
steps = [{ log = { duration_s = 57600, interval_s = 2 } }]

[[measurement]]
name = "rate"
doc = "Rate at rest"
quantity = "gyro.rate"
unit = "deg/s"
check = { all_within = [-1, 1] }
"#;

const FAULT: &str = r#"
[[fault]]
target = "gyro"
what = { disconnect = { for_s = 1 } }
when = { at_s = 2 }
"#;

/// Pages in a temporary folder.
pub struct Pages {
    runs: Vec<PathBuf>,
    pub hostile: PathBuf,
    pub campaign: PathBuf,
    _folder: TempDir,
}

impl Pages {
    /// Creates runs of the paper's figures and of faults, a truncated run, a campaign, an envelope and an
    /// identification.
    pub fn make() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let struck = STRUCK.replace("TITLE", HOSTILE).replace("PAPER", HOSTILE);
        fs::write(path("hostile.toml"), format!("{struck}{FAULT}")).unwrap();
        fs::write(path("struck.toml"), STRUCK).unwrap();
        // An envelope is of a plan that passes without any fault.
        let passes = STRUCK.replace("[0.5, 0.6]", "[-1, 1]");
        let passes = passes.replace("[[property]]\nsometimes = \"gyro_silent\"\n", "");
        fs::write(path("passes.toml"), passes).unwrap();
        let hil = |arguments: &[&str]| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
            let ran = command.args(arguments).current_dir(folder.path()).output().unwrap();
            assert!(ran.status.code() <= Some(1), "{arguments:?}: {ran:?}");
        };
        let paper = ["warm-up", "static-bias", "temperature-calibration", "verification"];
        let laps = ["laps-observed", "laps-corrected"];
        fs::write(path("log.toml"), LOG).unwrap();
        hil(&["run", "./log.toml", "--out", "log", "--quiet"]);
        let mut runs: Vec<&str> = paper.iter().chain(&laps).copied().collect();
        for plan in &runs {
            hil(&["run", plan, "--out", plan, "--quiet"]);
        }
        hil(&["run", "hostile.toml", "--out", "hostile", "--quiet"]);
        hil(&["run", "hostile.toml", "--out", "full", "--record", "full", "--quiet"]);
        hil(&["run", "struck.toml", "--out", "cut", "--quiet"]);
        let record = fs::read(path("cut/record.hilrec")).unwrap();
        fs::write(path("cut/record.hilrec"), &record[..record.len() / 2]).unwrap();
        fs::remove_file(path("cut/summary.json")).unwrap();
        hil(&["report", "cut"]);
        hil(&["campaign", "./struck.toml", "--cases", "60", "--out", "campaign", "--quiet"]);
        let drop = ["campaign", "./passes.toml", "--envelope", "drop", "--runs", "35", "--quiet"];
        hil(&[&drop[..], &["--out", "envelope"]].concat());
        hil(&["identify", "temperature-calibration", "--out", "identified"]);
        runs.extend(["log", "hostile", "full", "cut", "envelope", "identified"]);
        let page = |name: &str| canonical(&path(name).join("report.html"));
        Self {
            runs: runs.into_iter().map(page).collect(),
            hostile: page("hostile"),
            campaign: page("campaign"),
            _folder: folder,
        }
    }

    pub fn all(&self) -> impl Iterator<Item = &PathBuf> {
        self.runs.iter().chain([&self.campaign])
    }
}

fn canonical(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}
