//! The schemas accept and refuse what the parsers accept and refuse, as far as a schema can know.

use super::FileKind;
use crate::project::{Template, from_dbc};
use clap::ValueEnum as _;
use jsonschema::Validator;
use plan::faults::FaultKind;
use plan::{Action, Name, Plan, quantities};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn validator(kind: FileKind) -> Validator {
    jsonschema::draft202012::new(kind.schema().as_value()).unwrap()
}

fn json(text: &str) -> Value {
    let table: toml::Table = text.parse().unwrap();
    serde_json::to_value(table).unwrap()
}

#[track_caller]
fn assert_takes(validator: &Validator, text: &str, what: &str) {
    let instance = json(text);
    let wrong: Vec<String> = validator
        .iter_errors(&instance)
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect();
    assert!(wrong.is_empty(), "{what}: {wrong:#?}");
}

fn shipped(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../test-plans").join(folder);
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths.filter(|path| path.extension().is_some_and(|extension| extension == "toml")).collect()
}

#[test]
fn every_shipped_file_is_one_of_its_schema() {
    for (kind, folder) in [
        (FileKind::Plan, ""),
        (FileKind::Bench, "benches"),
        (FileKind::Rig, "rigs"),
        (FileKind::Devices, "devices"),
        (FileKind::Model, "models"),
        (FileKind::GyroModel, "devices/gyros"),
        (FileKind::BaseModel, "devices/bases"),
        (FileKind::TableModel, "devices/tables"),
    ] {
        let (validator, files) = (validator(kind), shipped(folder));
        assert!(!files.is_empty(), "{kind:?}");
        for path in files {
            let text = std::fs::read_to_string(&path).unwrap();
            assert_takes(&validator, &text, &path.display().to_string());
            // Its first line points an editor to that schema.
            let line = text.lines().next().and_then(|line| line.strip_prefix("#:schema ")).unwrap();
            let named = path.parent().unwrap().join(line).canonicalize().unwrap();
            assert_eq!(named, schemas().canonicalize().unwrap().join(kind.schema_file()));
        }
    }
}

#[test]
fn the_rig_of_the_example_is_one_of_its_schema() {
    let rig = include_str!("../../../../examples/battery-pack/rigs/pack.toml");
    let several = rig.replace("\"../devices/pack.dbc\"", "[\"a.dbc\", \"b.dbc\"]");
    let replayed = rig.replace("emulate = \"cells\"", "replay = { log = \"cells.log\" }");
    for text in [rig, &several, &replayed] {
        assert_takes(&validator(FileKind::Rig), text, "the battery pack");
    }
}

fn schemas() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../test-plans/schemas")
}

#[test]
fn the_shipped_schemas_are_those_of_the_types() {
    for &kind in FileKind::value_variants() {
        let path = schemas().join(kind.schema_file());
        let same = std::fs::read_to_string(&path).is_ok_and(|text| text == kind.text());
        assert!(same, "{path:?} is not up to date: hil schema --out test-plans/schemas");
    }
}

#[test]
fn every_file_of_a_new_project_names_its_schema_and_is_one_of_it() {
    let dbc = include_str!("../../../../wire/dbc/k2a.dbc");
    let name = Name::new("oven").unwrap();
    for files in [
        Template::Can.files(&name),
        Template::Serial.files(&name),
        from_dbc(&name, "k2a.dbc", dbc.as_bytes(), Some("BASE")).unwrap().files,
    ] {
        let mut checked = 0;
        for file in &files {
            let Some(line) = file.text().lines().next().and_then(|it| it.strip_prefix("#:schema "))
            else {
                assert!(file.path.extension().is_none_or(|it| it != "toml"), "{:?}", file.path);
                continue;
            };
            // The path is relative to the file.
            let folder = file.path.parent().unwrap();
            let path = match line.strip_prefix("../") {
                Some(rest) => folder.parent().unwrap().join(rest),
                None => folder.join(line),
            };
            let schema = files
                .iter()
                .find(|file| file.path == path)
                .unwrap_or_else(|| panic!("no {path:?}"));
            let schema: Value = serde_json::from_str(schema.text()).unwrap();
            let validator = jsonschema::draft202012::new(&schema).unwrap();
            assert_takes(&validator, file.text(), &file.path.display().to_string());
            checked += 1;
        }
        assert!(checked >= 4, "{checked}");
    }
}

/// A plan with this step, and a measurement of this quantity.
fn plan(step: &str, quantity: &str) -> String {
    format!(
        "name = \"p\"\ntitle = \"t\"\ndevices = \"paper\"\nsteps = [{step}]\n\
         [[measurement]]\nname = \"m\"\ndoc = \"d\"\nquantity = \"{quantity}\"\nunit = \"deg\"\n\
         check = {{ all_within = [0, 1] }}\n"
    )
}

const WAIT: &str = "{ wait = { duration_s = 1 } }";

#[test]
fn every_step_and_quantity_is_known() {
    let validator = validator(FileKind::Plan);
    for word in Action::words() {
        assert_takes(&validator, &plan(word.example, "table.error"), word.name);
    }
    let more = ["operator.gap", "signal.Status.Temperature", "period.Status"];
    for name in quantities::NAMES.iter().chain(&more) {
        assert_takes(&validator, &plan(WAIT, name), name);
    }
}

#[test]
fn every_kind_of_fault_is_known_within_its_range_alone() {
    let validator = validator(FileKind::Plan);
    for info in FaultKind::all() {
        let target = info.reach.targets()[0].name();
        for (place, parameter) in info.parameters.iter().enumerate() {
            let with = |value: f64| {
                let what = info.typical.with_value(place, value);
                let what = toml::Value::try_from(what).unwrap();
                format!("{}[[fault]]\ntarget = \"{target}\"\nwhat = {what}\n", plan(WAIT, "pose.x"))
            };
            let (least, greatest) = parameter.range;
            assert_takes(&validator, &with(least), info.name);
            assert_takes(&validator, &with(greatest), info.name);
            assert!(!validator.is_valid(&json(&with(greatest + 1.0))), "{}", parameter.name);
        }
    }
}

/// Checks that parser and schema agree on errors.
#[test]
fn what_the_parser_refuses_the_schema_refuses() {
    let validator = validator(FileKind::Plan);
    assert_takes(&validator, &plan(WAIT, "pose.x"), "the plan without a mistake");
    let with_step = |step: &str| plan(step, "pose.x");
    for (what, text) in [
        ("an unknown step", with_step("{ jump = {} }")),
        ("two actions", with_step("{ wait = { duration_s = 1 }, bias_test = {} }")),
        ("no action", with_step("{ label = \"x\" }")),
        ("an unknown key", with_step("{ wait = { duration_s = 1, days = 1 } }")),
        ("a missing key", with_step("{ turn = {} }")),
        ("a duration of nothing", with_step("{ wait = { duration_s = 0 } }")),
        ("too fast", with_step("{ turn = { angle_deg = 90, rate_deg_per_s = 1001 } }")),
        ("a turn of nothing", with_step("{ turn = { angle_deg = 0 } }")),
        ("a wrong direction", with_step("{ lap = { direction = \"left\" } }")),
        (
            "no repetition",
            with_step("{ repeat = { times = 0, steps = [{ wait = { duration_s = 1 } }] } }"),
        ),
        ("no steps within", with_step("{ repeat = { times = 1, steps = [] } }")),
        (
            "a sweep of nothing",
            with_step(
                "{ sweep = { parameter = \"gyro.x\", steps = [{ wait = { duration_s = 1 } }] } }",
            ),
        ),
        ("an unknown source", with_step("{ heading_source = \"sun\" }")),
        ("no steps", plan("", "pose.x")),
        ("an unknown quantity", plan(WAIT, "table.eror")),
        ("an answer without a name", plan(WAIT, "operator.")),
        ("a wrong name", plan(WAIT, "pose.x").replace("\"p\"", "\"P\"")),
        ("an unknown check", plan(WAIT, "pose.x").replace("all_within", "most_within")),
        ("half a band", plan(WAIT, "pose.x").replace("[0, 1]", "[0]")),
        ("an empty band", plan(WAIT, "pose.x").replace("[0, 1]", "{}")),
        ("no device", plan(WAIT, "pose.x").replace("devices = \"paper\"\n", "")),
        ("both", plan(WAIT, "pose.x").replace("devices", "device = \"d\"\ndevices")),
        ("an unknown property", plan(WAIT, "pose.x") + "[[property]]\nalways = { lucky = {} }\n"),
        (
            "an unknown target",
            plan(WAIT, "pose.x")
                + "[[fault]]\ntarget = \"Sun!\"\nwhat = { drop = { loss_percent = 1 } }\n",
        ),
    ] {
        assert!(Plan::parse("p.toml", &text).is_err(), "the parser takes {what}");
        assert!(!validator.is_valid(&json(&text)), "the schema takes {what}");
    }
}

#[test]
fn mistakes_in_other_files_are_refused() {
    for (kind, text) in [
        (FileKind::Bench, "[gyro]\nport = \"ttyUSB0\""),
        (FileKind::Bench, "[gyro]\nemulated = false"),
        (FileKind::Bench, "[gyroscope]\nemulated = true"),
        (FileKind::Bench, "[timing]\nlate_ms_max = 0"),
        (FileKind::Bench, "[controller]\nin_process = true\ncommand = [\"x\"]"),
        (FileKind::Rig, "title = \"nobody\""),
        (FileKind::Rig, "[[node]]\nname = \"a\"\ntester = true"),
        (FileKind::Rig, "[[node]]\nname = \"a\"\nat = \"b\""),
        (FileKind::Rig, "[[node]]\nname = \"a\"\nat = \"b\"\ntester = true\nemulate = \"c\""),
        (FileKind::Rig, "[[node]]\nname = \"a\"\nat = \"b\"\nunder_test = { command = \"x\" }"),
        (FileKind::Rig, "devices = \"paper\"\n[[line]]\nname = \"a\"\ncan = { bit_rate = 12 }"),
        (FileKind::Rig, "devices = \"paper\"\n[[line]]\nname = \"a\"\ncan = { dbc = 3 }"),
        (FileKind::Rig, "devices = \"paper\"\n[[line]]\nname = \"a\"\ncan = {}\nserial = {}"),
        (FileKind::Device, "title = \"no name\""),
        (FileKind::Device, "name = \"x\"\n[state.a]\nrat = 1"),
        (FileKind::Device, "name = \"x\"\n[message.A]\nperiod_s = \"1\""),
        (FileKind::GyroModel, "title = \"x\"\nstream = { format = \"morse\" }"),
        (
            FileKind::GyroModel,
            "title = \"x\"\nstream = { format = \"navigator\" }\nparameters = { bias = 1 }",
        ),
        (FileKind::Model, "schema = 1\nkind = \"songs\""),
    ] {
        assert!(!validator(kind).is_valid(&json(text)), "{kind:?}: {text}");
    }
}

/// An editor shows these texts while the user types.
#[test]
fn what_an_editor_shows_says_what_things_are() {
    let schema = FileKind::Plan.schema();
    let step = schema.pointer("/$defs/Step/properties").unwrap();
    for word in Action::words() {
        assert_eq!(step[word.name]["description"], word.doc.trim(), "{}", word.name);
    }
    let turn = schema.pointer("/$defs/Turn/properties").unwrap();
    insta::assert_snapshot!(format!("{turn:#}"));
}

#[test]
fn no_schema_speaks_of_null() {
    for &kind in FileKind::value_variants() {
        assert!(!kind.text().contains("\"null\""), "{kind:?}");
    }
}
