//! `hil list`: files that ship, files of the project in the working directory, and the names that a plan can use.

use super::failure::Failure;
use super::listed::{has_steps, lines, listed, table};
use super::parameters::parameters;
use super::{say, say_json};
use crate::choices::word;
use clap::{Args, ValueEnum};
use comfy_table::{Row, Table};
use plan::bench_file::{BenchFile, Role};
use plan::faults::{FaultKind, table as vocabulary};
use plan::library::Kind;
use plan::quantities::QUANTITIES;
use plan::rig::RigFile;
use plan::{Action, Check, Name};
use record::outcome::Outcome;
use serde_json::{Map, Value};
use std::path::Path;
use views::console::Style;

/// What can be listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Topic {
    /// Plans.
    Plans,
    /// Steps of a plan.
    Steps,
    /// Checks of a measurement.
    Checks,
    /// Device files, the gyros, bases and tables that they name, and descriptions of custom
    /// devices.
    Devices,
    /// Rigs: nodes on lines.
    Rigs,
    /// Bench files.
    Benches,
    /// Identified models and calibrations.
    Models,
    /// What a plan can measure.
    Quantities,
    /// What device files and plans can set: device.parameter. In a plan the name of the node stands for that of the file.
    Parameters,
    /// Kinds of faults.
    Faults,
}

/// Lists the files of the project in this folder, those that ship, and the names that plans can use.
#[derive(Debug, Args)]
pub(super) struct ListArguments {
    /// What to list. [default: all files; with --json everything]
    #[arg(value_enum)]
    topic: Option<Topic>,
    /// Print one JSON document: a list of objects for each topic.
    #[arg(long)]
    pub(super) json: bool,
}

impl Topic {
    const OF_FILES: [Self; 5] =
        [Self::Plans, Self::Devices, Self::Rigs, Self::Benches, Self::Models];

    /// Includes the files of the project in this folder.
    fn table(self, project: &Path) -> Table {
        match self {
            Self::Plans => plans(project),
            Self::Steps => steps(),
            Self::Checks => checks(),
            Self::Devices => devices(project),
            Self::Rigs => rigs(project),
            Self::Benches => benches(project),
            Self::Models => models(project),
            Self::Quantities => quantities(),
            Self::Parameters => parameters(project),
            Self::Faults => faults(),
        }
    }
}

impl ListArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        let topics = match &self.topic {
            Some(topic) => std::slice::from_ref(topic),
            None if self.json => Topic::value_variants(),
            None => &Topic::OF_FILES,
        };
        let tables = topics.iter().map(|topic| (topic, topic.table(Path::new("."))));
        if self.json {
            let all: Map<String, Value> =
                tables.map(|(topic, table)| (word(topic), rows(&table))).collect();
            say_json(&all)?;
        } else {
            let style = Style::of_stdout();
            let mut texts: Vec<String> = tables.map(|(_, table)| lines(table, style)).collect();
            if self.topic.is_none() {
                let rest =
                    Topic::value_variants().iter().filter(|topic| !Topic::OF_FILES.contains(topic));
                let rest: Vec<String> = rest.map(word).collect();
                texts.push(format!("What plans can name: hil list {}\n", rest.join("|")));
            }
            say(&texts.join("\n"))?;
        }
        Ok(Outcome::Passed)
    }
}

/// Converts each row to an object: the value of each column under its name, with underscores for spaces.
fn rows(table: &Table) -> Value {
    let header: Vec<String> = table.header().map_or_else(Vec::new, |header| {
        header.cell_iter().map(|cell| cell.content().replace(' ', "_")).collect()
    });
    let object = |row: &Row| -> Value {
        let cells = row.cell_iter().map(|cell| Value::from(cell.content()));
        header.iter().cloned().zip(cells).collect()
    };
    table.row_iter().map(object).collect()
}

fn plans(project: &Path) -> Table {
    let mut table = table(["plan", "from", "title", "paper"]);
    for file in listed(project, Kind::Plan) {
        // The folder of plans also holds other files.
        if has_steps(&file.source.text) {
            table.add_row([
                &file.path(project),
                file.from,
                &file.text("title"),
                &file.text("paper"),
            ]);
        }
    }
    table
}

fn steps() -> Table {
    let mut table = table(["step", "what is done", "example"]);
    for word in Action::words() {
        table.add_row([word.name, word.doc.trim(), word.example]);
    }
    table
}

fn checks() -> Table {
    let mut table = table(["check", "figure that is judged", "must lie in"]);
    for word in Check::WORDS {
        table.add_row([word.written, word.figure, word.lies_in]);
    }
    table
}

fn models(project: &Path) -> Table {
    let mut table = table(["name", "from", "kind", "terms or origin"]);
    for file in listed(project, Kind::Model) {
        let (kind, terms) = match plan::models::read(&file.library, &file.name) {
            Ok((_, model)) => {
                let terms: Vec<&str> = model.terms.iter().map(|term| term.name.as_str()).collect();
                (format!("model of {}", model.kind.name()), terms.join(", "))
            }
            // One invalid file does not fail the list.
            Err(error) => (Kind::Model.to_string(), error.to_string()),
        };
        table.add_row([file.name, file.from.to_owned(), kind, terms]);
    }
    for file in listed(project, Kind::Calibration) {
        // The first line states the origin.
        let origin = file.source.text.lines().next().and_then(|line| line.strip_prefix("# "));
        let origin = origin.unwrap_or_default();
        table.add_row([&file.name, file.from, &file.kind.to_string(), origin]);
    }
    table
}

fn devices(project: &Path) -> Table {
    let mut table = table(["name", "from", "kind", "title"]);
    for kind in [Kind::Devices, Kind::GyroModel, Kind::BaseModel, Kind::TableModel] {
        for file in listed(project, kind) {
            // The folder of device files also holds descriptions, which state no mount.
            let is_described = kind == Kind::Devices && file.text("mount").is_empty();
            let kind = if is_described { Kind::Description } else { kind };
            table.add_row([&file.name, file.from, &kind.to_string(), &file.text("title")]);
        }
    }
    table
}

fn rigs(project: &Path) -> Table {
    let mut table = table(["rig", "from", "lines", "nodes", "title"]);
    for file in listed(project, Kind::Rig) {
        let (lines, nodes, title) = match file.source.parse::<RigFile>() {
            Ok(rig) => {
                let robot = rig.devices.map(|name| format!("devices {name}"));
                let lines: Vec<&str> = rig.lines.iter().map(|line| line.name.as_str()).collect();
                let nodes = rig.nodes.iter().map(|node| node.name.to_string());
                let nodes: Vec<String> = robot.into_iter().chain(nodes).collect();
                (lines.join(", "), nodes.join(", "), rig.title)
            }
            Err(error) => (String::new(), String::new(), error.to_string()),
        };
        table.add_row([file.name, file.from.to_owned(), lines, nodes, title]);
    }
    table
}

fn benches(project: &Path) -> Table {
    let mut table = table(["bench", "from", "ports", "commands", "title"]);
    for file in listed(project, Kind::Bench) {
        let (ports, commands, title) = match file.source.parse::<BenchFile>() {
            Ok(bench) => {
                let commands: Vec<&str> = bench.commands.keys().map(Name::as_str).collect();
                (ports(&bench), commands.join(", "), bench.title)
            }
            Err(error) => (String::new(), String::new(), error.to_string()),
        };
        table.add_row([file.path(project), file.from.to_owned(), ports, commands, title]);
    }
    table
}

/// The devices and lines that a bench names, each with its port.
fn ports(bench: &BenchFile) -> String {
    let BenchFile { gyro, base, table, device, lines, .. } = bench;
    let roles = [("device", device), ("gyro", gyro), ("base", base), ("table", table)];
    let roles = roles.into_iter().filter_map(|(name, role)| {
        Some(match role.as_ref()? {
            Role::Real(port) => format!("{name} {port}"),
            Role::Emulated(Some(port)) => format!("{name} {port} (emulated)"),
            Role::Emulated(None) => format!("{name} (emulated)"),
        })
    });
    let lines = lines.iter().map(|(name, line)| format!("{name} {}", line.port));
    roles.chain(lines).collect::<Vec<_>>().join(", ")
}

fn quantities() -> Table {
    let mut table = table(["quantity", "unit", "from", "tags", "what it is"]);
    for quantity in QUANTITIES {
        let tags = quantity.tags.join(", ");
        table.add_row([quantity.name, quantity.unit, quantity.made_by, &tags, quantity.doc.trim()]);
    }
    table
}

fn faults() -> Table {
    let mut table = table(["fault", "strikes", "lasts", "what it does", "parameters"]);
    for info in FaultKind::all() {
        let values = info.parameters.iter().zip(info.typical.values());
        let parameters: Vec<String> =
            values.map(|(one, typical)| vocabulary::parameter(one, typical)).collect();
        let (strikes, lasts) = (vocabulary::strikes(info), vocabulary::lasts(info));
        table.add_row([info.name, strikes, &lasts, info.doc.trim(), &parameters.join("\n")]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::{
        Style, Topic, benches, devices, lines, models, plans, quantities, rigs, rows, steps,
    };
    use clap::ValueEnum as _;
    use plan::library::{Kind, names};
    use std::path::Path;

    /// A folder without a project.
    const NOWHERE: &str = "no/such/folder";

    #[test]
    fn everything_that_ships_is_listed_with_its_title() {
        let nowhere = Path::new(NOWHERE);
        let plans = lines(plans(nowhere), Style::PLAIN);
        assert!(names(Kind::Plan).iter().all(|name| plans.contains(name.as_str())), "{plans}");
        let benches = lines(benches(nowhere), Style::PLAIN);
        assert!(names(Kind::Bench).iter().all(|name| benches.contains(name.as_str())), "{benches}");
        let rigs = lines(rigs(nowhere), Style::PLAIN);
        assert!(names(Kind::Rig).iter().all(|name| rigs.contains(name.as_str())), "{rigs}");
        let devices = devices(nowhere);
        assert!(devices.row_count() > 4);
        for row in devices.row_iter() {
            assert!(row.cell_iter().all(|cell| !cell.content().is_empty()), "{devices}");
        }
        let models = models(nowhere);
        for row in models.row_iter() {
            assert!(row.cell_iter().all(|cell| !cell.content().is_empty()), "{models}");
        }
        insta::assert_snapshot!(lines(models, Style::PLAIN));
    }

    #[test]
    fn files_of_the_project_are_listed_as_such() {
        let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/battery-pack");
        let folder = tempfile::tempdir().unwrap();
        for file in ["charge.toml", "Cargo.toml", "rigs/pack.toml", "devices/cells.toml"] {
            let to = folder.path().join(file);
            std::fs::create_dir_all(to.parent().unwrap()).unwrap();
            std::fs::copy(example.join(file), to).unwrap();
        }
        std::fs::create_dir(folder.path().join("benches")).unwrap();
        for (name, text) in [
            (
                "benches/mine.toml",
                "title = \"By the window\"\n[gyro]\nport = \"/dev/ttyUSB0\"\n[command.flash]\nrun = [\"openocd\"]\n",
            ),
            ("benches/bad.toml", "[gyro]\nprot = 1\n"),
            ("rigs/bad.toml", "lines = 3\n"),
        ] {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let tables = Topic::OF_FILES.map(|topic| lines(topic.table(folder.path()), Style::PLAIN));
        let all = tables.concat();
        let own: Vec<&str> = all.lines().filter(|line| line.contains("project")).collect();
        insta::assert_snapshot!(own.join("\n"));
    }

    #[test]
    fn the_keys_of_the_document_are_these() {
        let keys = |topic: &Topic| {
            let all = rows(&topic.table(Path::new(NOWHERE)));
            let first = all.as_array().unwrap()[0].as_object().unwrap().clone();
            format!(
                "{}: {}",
                super::word(topic),
                first.into_iter().map(|(key, _)| key).collect::<Vec<_>>().join(", ")
            )
        };
        let all: Vec<String> = Topic::value_variants().iter().map(keys).collect();
        insta::assert_snapshot!(all.join("\n"));
    }

    #[test]
    fn steps_are_listed_with_what_they_do() {
        insta::assert_snapshot!(lines(steps(), Style::PLAIN));
    }

    #[test]
    fn quantities_have_units() {
        let quantities = lines(quantities(), Style::PLAIN);
        assert!(quantities.contains("lap.gyro_error"), "{quantities}");
    }
}
