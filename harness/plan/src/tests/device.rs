//! Plans of a custom device.

use crate::{Plan, Rig};
use described::Description;

const PLAN: &str = include_str!("device.toml");
const DBC: &str = "VERSION \"\"
BU_: Tester Oven
BO_ 256 Command: 2 Tester
 SG_ Setpoint : 0|12@1+ (0.1,0) [0|400] \"degC\" Oven
 SG_ Enable : 12|1@1+ (1,0) [0|1] \"\" Oven
BO_ 257 Status: 4 Oven
 SG_ Temperature : 0|16@1- (0.01,0) [-50|300] \"degC\" Tester
 SG_ Heater : 16|8@1+ (0.5,0) [0|100] \"%\" Tester
";
const DESCRIPTION: &str = "name = \"oven\"
title = \"An oven\"
dbc = \"oven.dbc\"
node = \"Oven\"
[parameter.ambient]
value = 20
unit = \"degC\"
maximum = 50
[signal.Temperature]
expression = \"ambient\"
[signal.Heater]
expression = \"0\"
[message.Status]
period_s = 0.1
";

fn rig() -> Rig {
    of_dbc(DBC)
}

fn of_dbc(dbc: &str) -> Rig {
    let read = &mut |_: &str| Ok(dbc.to_owned());
    let description = Description::parse("oven.toml", DESCRIPTION, read);
    Rig::of_device(description.unwrap_or_else(|error| panic!("{error:?}")).into())
}

/// The error of the plan after replacing `from`, as a user sees it.
fn refused(from: &str, to: &str) -> String {
    assert!(PLAN.contains(from), "{from}");
    let text = PLAN.replace(from, to);
    let checked = Plan::parse("oven-settles.toml", &text)
        .and_then(|plan| plan.check_rig("oven-settles.toml", &text, &rig()));
    let Err(error) = checked else { panic!("taken: {to}") };
    let report = miette::Report::new(error);
    let mut out = String::new();
    let handler = miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::none());
    handler.with_width(120).render_report(&mut out, report.as_ref()).unwrap();
    out
}

#[test]
fn a_plan_speaks_of_what_its_device_has() {
    let plan = Plan::parse("oven-settles.toml", PLAN).unwrap();
    plan.check_rig("oven-settles.toml", PLAN, &rig()).unwrap();
    assert!(plan.judged(&rig()).is_empty());
}

#[test]
fn a_value_is_sent_by_its_name() {
    let dbc = DBC.to_owned() + "VAL_ 256 Enable 0 \"Off\" 1 \"On\" ;\n";
    let rig = of_dbc(&dbc);
    let check = |value: &str| {
        let text = PLAN.replace("Enable = 1", &format!("Enable = {value}"));
        assert_ne!(text, PLAN);
        Plan::parse("p.toml", &text).and_then(|plan| plan.check_rig("p.toml", &text, &rig))
    };
    check("\"On\"").unwrap();
    check("0").unwrap();
    assert_eq!(check("\"Onn\"").unwrap_err().to_string(), "`Enable` has no value `Onn`");
    assert_eq!(
        check("nan").unwrap_err().to_string(),
        "invalid value: floating point `NaN`, expected a finite number or the name of a value"
    );
}

#[test]
fn a_value_between_two_steps_of_its_signal_is_refused() {
    let check = |value: &str| {
        let text = PLAN.replace("Setpoint = 60", &format!("Setpoint = {value}"));
        Plan::parse("p.toml", &text).and_then(|plan| plan.check_rig("p.toml", &text, &rig()))
    };
    for value in ["0.1", "0.3", "33.3", "399.9", "0.30000000000000004"] {
        check(value).unwrap();
    }
    assert_eq!(
        check("33.34").unwrap_err().to_string(),
        "Setpoint = 33.34, and 33.3 would be sent: it counts in steps of 0.1"
    );
}

#[test]
fn a_range_is_told_without_the_rounding_of_its_product() {
    // 2047 times 0.1 is 204.70000000000002.
    let rig = of_dbc(&DBC.replace("0|12@1+ (0.1,0) [0|400]", "0|12@1- (0.1,0) [0|0]"));
    let text = PLAN.replace("Setpoint = 60", "Setpoint = 600");
    let plan = Plan::parse("p.toml", &text).unwrap();
    let error = plan.check_rig("p.toml", &text, &rig).unwrap_err();
    assert_eq!(error.to_string(), "Setpoint = 600, expected -204.8 to 204.7 degC");
}

#[test]
fn what_the_device_has_not_is_shown_in_place() {
    let cases = [
        ("message = \"Command\", set = { Enable = 1", "message = \"Comand\", set = { Enable = 1"),
        ("Setpoint = 60", "Setpont = 60"),
        ("Setpoint = 60", "Setpoint = 600"),
        ("Setpoint = 60", "Setpoint = \"Warm\""),
        ("stop_sending = \"Command\"", "stop_sending = \"Status\""),
        (
            "above = { quantity = \"signal.Temperature\"",
            "above = { quantity = \"signal.Temprature\"",
        ),
        ("quantity = \"signal.Temperature\"\nunit", "quantity = \"signal.Setpoint\"\nunit"),
        ("unit = \"degC\"", "unit = \"K\""),
        ("quantity = \"period.Status\"", "quantity = \"period.State\""),
        ("device.ambient\", value = 20", "device.ambent\", value = 20"),
        ("device.ambient\", value = 20", "device.ambient\", value = 200"),
        ("device.ambient", "gyro.ambient"),
        ("{ wait = { duration_s = 120 }", "{ lap = { direction = \"cw\" }"),
        ("quantity = \"period.Status\"", "quantity = \"lap.return_x\""),
        ("target = \"device\"", "target = \"gyro\""),
        ("drop = { loss_percent = 1 }", "flip = { flip_percent = 1 }"),
        ("device = \"oven\"\n", "device = \"oven\"\ndevices = \"paper\"\n"),
        ("[[fault]]", "[[property]]\nalways = { finite_outputs = {} }\n\n[[fault]]"),
        ("{ Enable = 0 }, every_s = 0 }", "{ Enable = 0.5 }, every_s = 0 }"),
        ("{ Enable = 0 }, every_s = 0 }", "{ Enable = 0 }, every_s = 3 }"),
        (
            "[[fault]]",
            "[[property]]\nname = \"the run itself\"\nalways = \"Temperature < 100 degC\"\n\n[[fault]]",
        ),
        ("[[fault]]", "[[property]]\nalways = \"Temprature < 100 degC\"\n\n[[fault]]"),
        ("[[fault]]", "[[property]]\nalways = \"Temperature < 100 V\"\n\n[[fault]]"),
        (
            "[[fault]]",
            "[[property]]\nalways = 'Temperature < 100 -> within 0 s: Heater == 0'\n\n[[fault]]",
        ),
        ("[[fault]]", "[[property]]\nsometimes = \"Heater >\"\n\n[[fault]]"),
        ("[[fault]]", "[[property]]\nname = \"n\"\nsometimes = \"bus_off\"\n\n[[fault]]"),
        (
            "[[fault]]",
            "[[property]]\nalways = \"Heater < 1\"\nsometimes = \"Heater > 1\"\n\n[[fault]]",
        ),
        (
            "[[fault]]",
            "[[reaction]]\nname = \"r\"\nfrom = \"Heater > 1\"\nto = \"Heate < 1\"\n\n[[fault]]",
        ),
        ("quantity = \"period.Status\"", "quantity = \"reaction.cooling\""),
    ];
    let shown: Vec<String> = cases.iter().map(|(from, to)| refused(from, to)).collect();
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn a_signal_of_another_group_than_the_multiplexer_says_is_shown_in_place() {
    let dbc = DBC
        .replace("SG_ Enable :", "SG_ Enable M :")
        .replace("SG_ Setpoint :", "SG_ Setpoint m1 :")
        + "BO_ 300 Endless: 65 Tester\n";
    let rig = of_dbc(&dbc);
    let check = |text: &str| {
        Plan::parse("p.toml", text).and_then(|plan| plan.check_rig("p.toml", text, &rig))
    };
    check(PLAN).unwrap();
    let error = check(&PLAN.replace("Enable = 1", "Enable = 0")).unwrap_err();
    assert_eq!(error.to_string(), "`Command` has no `Setpoint` where `Enable` is 0");
    let unknown = PLAN.replace("stop_sending = \"Command\"", "stop_sending = \"Endless\"");
    let error = check(&unknown).unwrap_err();
    let help = miette::Diagnostic::help(&error).map(|help| help.to_string());
    assert!(help.is_some_and(|help| help.contains("line 9: Endless: it has 65 bytes")));
}

/// Found by a user: it passed, and stopped nothing.
#[test]
fn only_what_a_step_sends_can_be_stopped() {
    let silent = PLAN.lines().filter(|line| !line.contains("{ send =")).collect::<Vec<_>>();
    let silent = silent.join("\n");
    let plan = Plan::parse("p.toml", &silent).unwrap();
    let error = plan.check_rig("p.toml", &silent, &rig()).unwrap_err();
    assert_eq!(error.to_string(), "no step of this plan sends `Command`");
}

#[test]
fn what_is_of_a_device_is_of_no_robot() {
    let robot = PLAN.replace("device = \"oven\"\n", "devices = \"paper\"\n");
    let error = Plan::parse("p.toml", &robot).unwrap_err();
    assert_eq!(error.to_string(), "`send` is for a device of your own");
}

#[test]
fn a_reaction_that_is_waited_for_is_one_of_the_plans() {
    let waits = "{ wait = { duration_s = 120 }, label = \"holding\" }";
    let said = refused(waits, "{ reaction = \"warmng\", label = \"holding\" }");
    assert!(said.contains("no [[reaction]] `warmng` in this plan"), "{said}");
    assert!(said.contains("did you mean `warming`?"), "{said}");
    assert!(said.contains("{ reaction = \"warmng\""), "{said}");
}
