//! `hil list`: what ships, and which names a plan can use.

use super::failure::Failure;
use super::{say, say_json};
use clap::{Args, ValueEnum};
use comfy_table::{ContentArrangement, Row, Table, presets};
use emulators::absolute::AbsoluteParameters;
use emulators::base::{BaseParameters, Wheel};
use emulators::gyro::GyroParameters;
use emulators::parameters::{Domain, ParameterInfo, Parameters};
use emulators::table::TableParameters;
use harness::run::load_plan;
use plan::bench_file::{BenchFile, ROLES, Role};
use plan::faults::{FaultKind, table as vocabulary};
use plan::library::{Kind, Library, LibraryError, names};
use plan::quantities::QUANTITIES;
use plan::{Action, STEP_EXAMPLES};
use record::outcome::Outcome;
use serde_json::{Map, Value};
use views::console::Style;

/// What can be listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Topic {
    /// Plans that ship.
    Plans,
    /// What a step of a plan can do.
    Steps,
    /// Device files, and the gyros, bases and tables that they name, that ship.
    Devices,
    /// Bench files that ship.
    Benches,
    /// Identified models and calibrations that ship.
    Models,
    /// What a plan can measure.
    Quantities,
    /// What device files and plans can set: device.parameter.
    Parameters,
    /// What can go wrong on purpose.
    Faults,
}

/// Lists what ships and what plans can name.
#[derive(Debug, Args)]
pub(super) struct ListArguments {
    /// What to list; everything without.
    #[arg(value_enum)]
    topic: Option<Topic>,
    /// Print one JSON document: of each topic a list of objects.
    #[arg(long)]
    pub(super) json: bool,
}

impl Topic {
    /// As it is typed.
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    fn table(self) -> Result<Table, Failure> {
        match self {
            Self::Plans => plans(),
            Self::Steps => Ok(steps()),
            Self::Devices => devices(),
            Self::Benches => benches(),
            Self::Models => models(),
            Self::Quantities => Ok(quantities()),
            Self::Parameters => Ok(parameters()),
            Self::Faults => Ok(faults()),
        }
    }
}

impl ListArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        let topics = match &self.topic {
            Some(topic) => std::slice::from_ref(topic),
            None => Topic::value_variants(),
        };
        let mut tables = Vec::new();
        for topic in topics {
            tables.push((topic, topic.table()?));
        }
        if self.json {
            let all: Map<String, Value> =
                tables.iter().map(|(topic, table)| (topic.name(), rows(table))).collect();
            say_json(&all)?;
        } else {
            let style = Style::of_stdout();
            let texts: Vec<String> =
                tables.into_iter().map(|(_, table)| lines(table, style)).collect();
            say(&texts.join("\n"))?;
        }
        Ok(Outcome::Passed)
    }
}

fn table<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table.set_header(header);
    table
}

/// A row as an object: what stands in each column, by the column's name, its spaces underscores.
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

fn lines(mut table: Table, style: Style) -> String {
    table
        .load_style(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(style.width)
        .force_no_tty();
    table.lines().map(|line| line.trim_end().to_owned() + "\n").collect()
}

fn plans() -> Result<Table, Failure> {
    let mut table = table(["plan", "title", "paper"]);
    for name in names(Kind::Plan) {
        let plan = load_plan(&Library::shipped(), &name)?;
        table.add_row([name, plan.title, plan.paper.unwrap_or_default()]);
    }
    Ok(table)
}

fn steps() -> Table {
    let mut table = table(["step", "what is done", "example"]);
    for ((name, doc), (_, example)) in Action::DOCS.iter().zip(STEP_EXAMPLES) {
        table.add_row([name, doc.trim(), example]);
    }
    table
}

fn models() -> Result<Table, Failure> {
    let mut table = table(["name", "kind", "terms or origin"]);
    for name in names(Kind::Model) {
        let (_, model) = plan::models::read(&Library::shipped(), &name)
            .map_err(harness::run::PrepareError::from)?;
        let terms: Vec<&str> = model.terms.iter().map(|term| term.name.as_str()).collect();
        table.add_row([name, format!("model of {}", model.kind.name()), terms.join(", ")]);
    }
    for name in names(Kind::Calibration) {
        let source = Library::shipped()
            .open(Kind::Calibration, &name)
            .map_err(harness::run::PrepareError::from)?;
        // The first line says what made it.
        let origin = source.text.lines().next().and_then(|line| line.strip_prefix("# "));
        table.add_row([name, Kind::Calibration.to_string(), origin.unwrap_or_default().to_owned()]);
    }
    Ok(table)
}

fn devices() -> Result<Table, Failure> {
    let mut table = table(["name", "kind", "title"]);
    for kind in [Kind::Devices, Kind::GyroModel, Kind::BaseModel, Kind::TableModel] {
        for name in names(kind) {
            let title = title(kind, &name).map_err(harness::run::PrepareError::from)?;
            table.add_row([name, kind.to_string(), title]);
        }
    }
    Ok(table)
}

fn benches() -> Result<Table, Failure> {
    let mut table = table(["bench", "gyro", "base", "table", "title"]);
    for name in names(Kind::Bench) {
        let bench = BenchFile::load(&name)?;
        let [gyro, base, turntable] = ROLES.map(|role| match bench.role(role) {
            Role::Real(port) => port.to_string(),
            Role::Emulated(None) => "emulated".to_owned(),
            Role::Emulated(Some(port)) => format!("emulated on {port}"),
        });
        table.add_row([name, gyro, base, turntable, bench.title]);
    }
    Ok(table)
}

/// The title of a file, whatever else is in it.
fn title(kind: Kind, name: &str) -> Result<String, LibraryError> {
    let source = Library::shipped().open(kind, name)?;
    let file: toml::Table = source.text.parse().unwrap_or_default();
    Ok(file.get("title").and_then(|title| title.as_str()).unwrap_or_default().to_owned())
}

fn quantities() -> Table {
    let mut table = table(["quantity", "unit", "from", "tags", "what it is"]);
    for quantity in QUANTITIES {
        let tags = quantity.tags.join(", ");
        table.add_row([quantity.name, quantity.unit, quantity.made_by, &tags, quantity.doc.trim()]);
    }
    table
}

fn parameters() -> Table {
    let mut table = table(["parameter", "ideal", "takes", "what it is"]);
    for (device, infos) in [
        ("gyro", GyroParameters::TABLE),
        ("base", BaseParameters::TABLE),
        ("base.wheels.0", Wheel::TABLE),
        ("table", TableParameters::TABLE),
        ("absolute", AbsoluteParameters::TABLE),
    ] {
        for ParameterInfo { name, doc, domain, ideal } in infos {
            let name = format!("{device}.{name}");
            // Links of the Rust documentation lead nowhere on a terminal.
            let doc = doc.trim().replace("[`", "").replace("`]", "");
            table.add_row([name, number(*ideal), takes(*domain), doc]);
        }
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

fn takes(domain: Domain) -> String {
    match domain {
        Domain::FINITE => "any".to_owned(),
        Domain::NOT_NEGATIVE => "0 or more".to_owned(),
        Domain::POSITIVE => "more than 0".to_owned(),
        Domain::LIMIT => "more than 0, or inf".to_owned(),
        Domain { min, max } => format!("{} to {}", number(min), number(max)),
    }
}

fn number(value: f64) -> String {
    record::figures::value(value, 0.0)
}

#[cfg(test)]
mod tests {
    use super::{
        Style, Topic, benches, devices, lines, models, parameters, plans, quantities, rows, steps,
    };
    use clap::ValueEnum as _;
    use plan::library::{Kind, names};

    #[test]
    fn everything_that_ships_is_listed_with_its_title() {
        let plans = lines(plans().unwrap(), Style::PLAIN);
        assert!(names(Kind::Plan).iter().all(|name| plans.contains(name.as_str())), "{plans}");
        let benches = lines(benches().unwrap(), Style::PLAIN);
        assert!(names(Kind::Bench).iter().all(|name| benches.contains(name.as_str())), "{benches}");
        let devices = devices().unwrap();
        assert!(devices.row_count() > 4);
        for row in devices.row_iter() {
            assert!(row.cell_iter().all(|cell| !cell.content().is_empty()), "{devices}");
        }
        let models = models().unwrap();
        for row in models.row_iter() {
            assert!(row.cell_iter().all(|cell| !cell.content().is_empty()), "{models}");
        }
        insta::assert_snapshot!(lines(models, Style::PLAIN));
    }

    #[test]
    fn the_keys_of_the_document_are_these() {
        let keys = |topic: &Topic| {
            let all = rows(&topic.table().unwrap());
            let first = all.as_array().unwrap()[0].as_object().unwrap().clone();
            format!(
                "{}: {}",
                topic.name(),
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
    fn quantities_and_parameters_have_units_and_domains() {
        let quantities = lines(quantities(), Style::PLAIN);
        assert!(quantities.contains("lap.gyro_error"), "{quantities}");
        let parameters = lines(parameters(), Style::PLAIN);
        for expected in ["gyro.", "base.wheels.0.toe_deg", "more than 0, or inf", "absolute."] {
            assert!(parameters.contains(expected), "{expected}: {parameters}");
        }
    }
}
