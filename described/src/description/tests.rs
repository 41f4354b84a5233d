//! Messages and places of mistakes in descriptions.

mod states;

use super::{Description, FileError};
use miette::{GraphicalReportHandler, GraphicalTheme};
use proptest::prelude::*;

const DBC: &str = include_str!("../../tests/data/oven.dbc");
const OVEN: &str = include_str!("../../tests/data/oven.toml");

/// The mistake as a terminal shows it.
fn refused(text: &str) -> String {
    let read = &mut |name: &str| match name {
        "oven.dbc" => Ok(DBC.to_owned()),
        "broken.dbc" => Ok("VERSION \"\"\n\nBO_ 1 M: X\n".to_owned()),
        "one-id.dbc" => Ok(DBC.replace("BO_ 257", "BO_ 513")),
        "endless.dbc" => Ok(DBC.replace("Status: 4", "Status: 65")),
        "overlap.dbc" => {
            Ok(DBC.replace("16|1@1+ (1,0) [0|1] \"\" Host", "15|1@1+ (1,0) [0|1] \"\" Host"))
        }
        "trace.csv" => Ok("t_s,temp\n0,1\n1,hot\n".to_owned()),
        "back.csv" => Ok("t_s,temp\n1,1\n0,2\n".to_owned()),
        _ => Err("no such file".to_owned()),
    };
    let error = match Description::parse("oven.toml", text, read) {
        Ok(_) => panic!("nothing is wrong with\n{text}"),
        Err(error) => error,
    };
    shown(&error)
}

pub(crate) fn shown(error: &FileError) -> String {
    let mut shown = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .with_width(110)
        .render_report(&mut shown, error)
        .unwrap();
    shown
}

/// The mistakes caused by changes to the oven, one below the other.
fn changed(changes: &[(&str, &str)]) -> String {
    let show = |(from, to): &(&str, &str)| {
        assert!(OVEN.contains(from), "the oven has no {from}");
        format!("{from}  ->  {to}\n{}\n", refused(&OVEN.replacen(from, to, 1)))
    };
    changes.iter().map(show).collect()
}

#[test]
fn the_examples_of_the_manual_are_descriptions() {
    let manual = include_str!("../lib.rs").lines().filter_map(|line| line.strip_prefix("//!"));
    let manual: String = manual.map(|line| format!("{}\n", line.trim_start())).collect();
    let examples: Vec<&str> = manual.split("```toml\n").skip(1).collect();
    for example in &examples {
        let (example, _) = example.split_once("```").unwrap();
        let named = if example.contains("title") { "" } else { "name = \"example\"\n" };
        let read = &mut |_: &str| Ok(DBC.to_owned());
        let found = Description::parse("manual.toml", &format!("{named}{example}"), read);
        found.unwrap_or_else(|error| panic!("{error}\n{example}"));
    }
    assert_eq!(examples.len(), 2);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Files come from outside: any content gives a description or a mistake with its place.
    #[test]
    fn no_file_makes_it_panic(
        at in any::<prop::sample::Index>(), length in 0usize..30, with in "[ -~\n]{0,12}", in_dbc: bool
    ) {
        let change = |text: &str| {
            let start = at.index(text.len());
            let end = (start + length).min(text.len());
            format!("{}{with}{}", &text[..start], &text[end..])
        };
        let (toml, dbc) = match in_dbc {
            true => (OVEN.to_owned(), change(DBC)),
            false => (change(OVEN), DBC.to_owned()),
        };
        if let Err(error) = Description::parse("oven.toml", &toml, &mut |_| Ok(dbc.clone())) {
            let text = if error.file() == "oven.toml" { &toml } else { &dbc };
            prop_assert!(error.range().end <= text.len(), "{error}");
        }
    }
}

#[test]
fn wrong_names() {
    let shown = changed(&[
        ("node = \"Oven\"", "node = \"oven1\""),
        ("[signal.Temperature]", "[signal.Temprature]"),
        ("[signal.Temperature]", "[signal.Setpoint]"),
        ("[message.Status]", "[message.Stauts]"),
        ("answers = \"Command\"", "answers = \"Status\""),
        ("initial = { Setpoint", "initial = { Setpiont"),
        ("initial = { Setpoint = 20", "initial = { Setpoint = \"Warm\""),
        ("value = 20.0", "vlaue = 20.0"),
        ("[parameter.hysteresis]", "[parameter.t]"),
        ("[parameter.hysteresis]", "[parameter.\"my hysteresis\"]"),
    ]);
    insta::assert_snapshot!(shown);
}

#[test]
fn wrong_expressions() {
    let shown = changed(&[
        ("(temperature - ambient)", "(temperature - ambeint)"),
        ("expression = \"heater\"", "expression = \"HeaterOn\""),
        ("start = \"ambient\"", "start = \"heater\""),
        ("expression = \"1500 * heater\"", "expression = \"1500 * * heater\""),
        ("last(heater)", "heater"),
        ("rate = ", "value = 1\nrate = "),
    ]);
    insta::assert_snapshot!(shown);
}

#[test]
fn wrong_numbers() {
    let shown = changed(&[
        ("value = 20.0", "value = 80.0"),
        ("period_s = 0.1", "period_s = 0"),
        ("Setpoint = 20,", "Setpoint = 2000,"),
        ("noise = 0.05", "noise = -1"),
        ("node = \"Oven\"", "node = \"Oven\"\nstep_s = 0"),
    ]);
    insta::assert_snapshot!(shown);
}

#[test]
fn wrong_messages() {
    let shown = changed(&[
        ("period_s = 0.1", ""),
        ("delay_s = 0.002", "timeout_s = 1"),
        ("answers = \"Command\"", ""),
        ("timeout_s = 1.0", "delay_s = 1.0"),
        ("[message.Command]", "[signal.\"Status.HeaterOn\"]\nexpression = 1\n[message.Command]"),
        ("dbc = \"oven.dbc\"", ""),
        ("node = \"Oven\"", ""),
        ("node = \"Oven\"", "node = \"Oven\"\nserial = { baud = 9600 }"),
    ]);
    insta::assert_snapshot!(shown);
}

#[test]
fn wrong_files() {
    let csv = |rest: &str| format!("csv = {rest}");
    let shown = changed(&[
        ("oven.dbc", "away.dbc"),
        ("oven.dbc", "broken.dbc"),
        ("oven.dbc", "endless.dbc"),
        ("oven.dbc", "one-id.dbc"),
        ("oven.dbc", "overlap.dbc"),
        ("expression = \"heater\"", &csv("\"away.csv\"")),
        ("expression = \"heater\"", &csv("\"trace.csv\"")),
        ("expression = \"heater\"", &csv("\"back.csv\"")),
        ("expression = \"heater\"", &csv("\"trace.csv\"\nvalue = \"temperature\"")),
        ("expression = \"heater\"", &csv("\"trace.csv\"\nsteps = [[0, 1]]")),
        ("expression = \"heater\"", "steps = [[0, 1], [0, 2]]"),
        ("expression = \"heater\"", "steps = [[0, 1]]\nrepeat = true"),
        ("expression = \"heater\"", "expression = \"heater\"\nrepeat = true"),
    ]);
    insta::assert_snapshot!(shown);
}

#[test]
fn wrong_layouts() {
    let message = |rest: &str| {
        format!("name = \"m\"\n[[message]]\nname = \"A\"\nsent_by = \"device\"\n{rest}")
    };
    let serial = |rest: &str| format!("serial = {{ baud = 9600 }}\n{}", message(rest));
    let second = "\n[[message]]\nname = \"B\"\nsent_by = \"device\"\n";
    let texts = [
        message(""),
        message("can_id = 0x20000000"),
        message("can_id = 1\nfields = [{ name = \"x\" }]"),
        message("can_id = 1\nfields = [{ name = \"x\", type = \"u12\" }]"),
        message(
            "can_id = 1\nfields = [{ name = \"x\", type = \"u64\" }, { name = \"y\", type = \"u8\" }]",
        ),
        message(
            "can_id = 1\nfields = [{ name = \"x\", type = \"u8\" }, { name = \"x\", type = \"u8\" }]",
        ),
        message("can_id = 1\nfields = [{ name = \"x\", type = \"u8\", minimum = 300 }]"),
        message("can_id = 1\nfields = [{ name = \"x\", type = \"u8\", scale = 0 }]"),
        message(&format!("can_id = 1{second}can_id = 1")),
        message("text = \"x\\n\""),
        serial("can_id = 1"),
        serial(""),
        serial("start = [170]\nchecksum = \"crc16-modbuss\""),
        serial(&format!("start = [170]{second}start = [170, 85]")),
        serial("text = \"T={x}\"").replace("9600", "0"),
        serial("text = \"T={x}\"").replace("9600", "9600, data_bits = 9"),
        serial("text = \"T={x}\"").replace("9600", "9600, stop_bits = 3"),
        serial("text = \"T={x}\""),
        serial("text = \"{a}{b}\\n\""),
        serial("text = \"{a},{b},{c},{d},{e},{f},{g}\\n\""),
        serial("text = \"{a}\\n\"\nfields = [{ name = \"b\", unit = \"V\" }]"),
        serial(&format!("text = \"SET {{a:.1}}\\n\"{second}text = \"SET {{b:.0}}\\n\"")),
        "name = \"m\"".to_owned(),
        "name = ".to_owned(),
    ];
    let shown: String = texts.iter().map(|text| format!("{}\n", refused(text))).collect();
    insta::assert_snapshot!(shown);
}
