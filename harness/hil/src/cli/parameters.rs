//! `hil list parameters`: numbers of devices that plans and device files can set.

use super::listed::{listed, table};
use comfy_table::Table;
use emulators::absolute::AbsoluteParameters;
use emulators::base::{BaseParameters, Wheel};
use emulators::gyro::GyroParameters;
use emulators::parameters::{Domain, ParameterInfo, Parameters};
use emulators::table::TableParameters;
use harness::run::load_description;
use plan::library::Kind;
use std::path::Path;

/// Returns the parameters of the project's described devices, then those of the paper's.
pub(super) fn parameters(project: &Path) -> Table {
    let mut table = table(["parameter", "ideal", "takes", "what it is"]);
    let own = listed(project, Kind::Devices).filter(|file| file.from == "project");
    let own =
        own.filter_map(|file| Some((load_description(&file.library, &file.name).ok()?, file)));
    for (device, file) in own {
        for (parameter, value, unit) in device.parameters() {
            let name = format!("{}.{parameter}", file.name);
            let unit = Some(unit).filter(|unit| *unit != "1").unwrap_or_default();
            let value = format!("{} {unit}", number(value)).trim_end().to_owned();
            let (min, max) = device.range(parameter).unwrap_or((f64::MIN, f64::MAX));
            let takes = takes(Domain { min: min.max(f64::MIN), max: max.min(f64::MAX) });
            table.add_row([&name, &value, &takes, device.doc(parameter).unwrap_or_default()]);
        }
    }
    for (device, infos) in [
        ("gyro", GyroParameters::TABLE),
        ("base", BaseParameters::TABLE),
        ("base.wheels.0", Wheel::TABLE),
        ("table", TableParameters::TABLE),
        ("absolute", AbsoluteParameters::TABLE),
    ] {
        for ParameterInfo { name, doc, domain, ideal } in infos {
            let name = format!("{device}.{name}");
            // Links of the Rust documentation do not work on a terminal.
            let doc = doc.trim().replace("[`", "").replace("`]", "");
            table.add_row([name, number(*ideal), takes(*domain), doc]);
        }
    }
    table
}

fn takes(domain: Domain) -> String {
    match domain {
        Domain::FINITE => "any".to_owned(),
        Domain::NOT_NEGATIVE => "0 or more".to_owned(),
        Domain::POSITIVE => "more than 0".to_owned(),
        Domain::LIMIT => "more than 0, or inf".to_owned(),
        Domain { min, max: f64::MAX } => format!("{} or more", number(min)),
        Domain { min: f64::MIN, max } => format!("{} or less", number(max)),
        Domain { min, max } => format!("{} to {}", number(min), number(max)),
    }
}

fn number(value: f64) -> String {
    record::figures::value(value, 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::listed::lines;
    use super::parameters;
    use std::path::Path;
    use views::console::Style;

    #[test]
    fn parameters_of_the_projects_devices_are_listed() {
        let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/battery-pack");
        let all = lines(parameters(&example), Style::PLAIN);
        let own: Vec<&str> = all.lines().filter(|line| !line.contains("gyro.")).take(6).collect();
        insta::assert_snapshot!(own.join("\n"));
    }

    #[test]
    fn each_has_its_domain() {
        let parameters = lines(parameters(Path::new("no/such/folder")), Style::PLAIN);
        for expected in ["gyro.", "base.wheels.0.toe_deg", "more than 0, or inf", "absolute."] {
            assert!(parameters.contains(expected), "{expected}: {parameters}");
        }
    }
}
