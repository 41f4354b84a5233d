//! Every mistake in a plan is shown at its place.

use crate::{DEPTH_MAX, FILE_LEN_MAX, FileError, Plan, STEPS_MAX};
use miette::{GraphicalReportHandler, GraphicalTheme};

const HEAD: &str = "name = \"p\"\ntitle = \"a plan\"\ndevices = \"paper-table\"\n";
const TAIL: &str = "\n[[measurement]]\nname = \"m\"\ndoc = \"d\"\nquantity = \"table.error\"\nunit = \
                    \"deg\"\ncheck = { all_within = [-1, 1] }\n";

fn with_steps(steps: &str) -> String {
    format!("{HEAD}steps = [\n  {steps}\n]\n{TAIL}")
}

fn with_measurement(measurement: &str) -> String {
    let steps = "{ table_turn = { angle_deg = 360 } }, { straight = { distance_m = 1 } }";
    format!("{HEAD}steps = [{steps}]\n\n[[measurement]]\n{measurement}\n")
}

fn error(text: &str) -> FileError {
    Plan::parse("p.toml", text).expect_err(text)
}

/// As in a terminal without colours.
pub(super) fn rendered(error: &FileError) -> String {
    let theme = GraphicalTheme::unicode_nocolor();
    let handler = GraphicalReportHandler::new_themed(theme).with_width(100);
    let mut shown = String::new();
    handler.render_report(&mut shown, error).unwrap();
    shown
}

#[test]
fn mistakes_of_writing_are_shown_in_place() {
    let cases = [
        ("no TOML at all", format!("{HEAD}steps = [")),
        ("an unknown key of a plan", format!("{HEAD}steps = []\nseeds = 1\n")),
        ("an unknown key of a step", with_steps("{ bias_test = { durations_s = 20 } }")),
        ("a misspelt step", with_steps("{ trun = { angle_deg = 90 } }")),
        (
            "two actions in a step",
            with_steps("{ wait = { duration_s = 1 }, turn = { angle_deg = 9 } }"),
        ),
        ("no action in a step", with_steps("{ label = \"warm\" }")),
        ("a wrong type", with_steps("{ wait = { duration_s = \"20\" } }")),
        ("a step that is no table", with_steps("\"wait\"")),
        ("a negative duration", with_steps("{ wait = { duration_s = -20 } }")),
        ("a negative limit", with_steps("{ bias_test = {}, time_limit_s = -1 }")),
        ("a missing key", with_steps("{ turn = {} }")),
        ("no repetitions", with_steps("{ repeat = { times = 0, steps = [{ bias_test = {} }] } }")),
        ("nothing to repeat", with_steps("{ repeat = { times = 2, steps = [] } }")),
        (
            "two kinds of sweep",
            with_steps(
                "{ sweep = { parameter = \"gyro.x\", values = [1], from = 1, steps = [{ bias_test = {} }] } }",
            ),
        ),
        ("an unsafe name", with_steps("{ use_calibration = \"../../etc\" }")),
        ("a misspelt choice", with_steps("{ heading_source = \"odometer\" }")),
        ("a rig", "[[line]]\nname = \"bus\"\ncan = {}\n".to_owned()),
        ("a device", "name = \"oven\"\ntitle = \"Oven\"\n[state.heat]\nstart = 0\n".to_owned()),
    ];
    insta::assert_snapshot!(table(&cases));
}

#[test]
fn mistakes_of_meaning_are_shown_in_place() {
    let base = "name = \"m\"\ndoc = \"d\"\nquantity = \"table.error\"\n";
    let cases = [
        ("no steps", format!("{HEAD}steps = []\n{TAIL}")),
        ("no measurement", format!("{HEAD}steps = [{{ bias_test = {{}} }}]\n")),
        (
            "a band reversed",
            with_measurement(&format!(
                "{base}unit = \"deg\"\ncheck = {{ all_within = [0.25, -0.25] }}"
            )),
        ),
        (
            "two checks",
            with_measurement(&format!(
                "{base}unit = \"deg\"\ncheck = {{ all_within = [0, 1], mean_within = [0, 1] }}"
            )),
        ),
        (
            "a fault without its parameters",
            format!(
                "{HEAD}steps = [{{ bias_test = {{}} }}]\n{TAIL}\n[[fault]]\ntarget = \"gyro\"\nwhat = \"disconnect\"\n"
            ),
        ),
        (
            "an unknown quantity",
            with_measurement(
                "name = \"m\"\ndoc = \"d\"\nquantity = \"table.eror\"\nunit = \"deg\"\ncheck = { all_within = [0, 1] }",
            ),
        ),
        (
            "a wrong unit",
            with_measurement(&format!(
                "{base}unit = \"deg\"\ncheck = {{ slope_within = {{ against = \"temperature\", band = [-1, 0] }} }}"
            )),
        ),
        (
            "a phase that no step has",
            format!(
                "{HEAD}steps = [{{ bias_test = {{}}, label = \"resting\" }}]\n[[measurement]]\n{base}\
                 where = {{ \"during.restng\" = 1 }}\nunit = \"deg\"\ncheck = {{ all_within = [0, 1] }}"
            ),
        ),
        (
            "an unknown tag",
            with_measurement(&format!(
                "{base}where = {{ directoin = 1 }}\nunit = \"deg\"\ncheck = {{ all_within = [0, 1] }}"
            )),
        ),
        (
            "identified from nothing",
            with_steps("{ identify = { from = \"turns\", name = \"a\" } }"),
        ),
        (
            "identified over nothing",
            with_steps(
                "{ table_turn = { angle_deg = 360 }, label = \"warm\" }, { identify = { from = \"turns\", name = \"a\", over = \"worm\" } }",
            ),
        ),
        (
            "two models of one name",
            with_steps(
                "{ table_turn = { angle_deg = 360 } },\n  { identify = { from = \"turns\", name = \"a\" } },\n  { identify = { from = \"turns\", name = \"a\" } }",
            ),
        ),
        (
            "an unknown phase",
            with_measurement(&format!(
                "{base}unit = \"deg\"\ncheck = {{ never_outside = {{ band = [0, 1], during = \"strait\" }} }}"
            )),
        ),
        (
            "an unlike second quantity",
            with_measurement(&format!(
                "{base}unit = \"1\"\ncheck = {{ rms_ratio_within = {{ to = \"lap.return_x\", band = [0, 1] }} }}"
            )),
        ),
        (
            "a position that is none",
            with_measurement(&format!(
                "{base}unit = \"1\"\ncheck = {{ all_but_in_square = {{ count = 1, side_m = 0.1, \
                 y = \"lap.return_y\" }} }}"
            )),
        ),
        (
            "a name used twice",
            format!("{}{TAIL}{TAIL}", with_steps("{ bias_test = {} }").trim_end_matches(TAIL)),
        ),
        (
            "an answer nobody asks for",
            with_measurement(
                "name = \"m\"\ndoc = \"d\"\nquantity = \"operator.gap\"\nunit = \"mm\"\ncheck = { all_within = [0, 1] }",
            ),
        ),
        (
            "a calibration from an unknown fit",
            with_steps(
                "{ fit = { name = \"line\", quantity = \"table.error\", model = { line = { against = \"temperature\" } } } },\n  { save_calibration = { name = \"c\", from = [\"lines\"] } }",
            ),
        ),
        (
            "a calibration from a useless fit",
            with_steps(
                "{ fit = { name = \"line\", quantity = \"gyro.rate\", model = \"mean\" } },\n  { save_calibration = { name = \"c\", from = [\"line\"] } }",
            ),
        ),
    ];
    insta::assert_snapshot!(table(&cases));
}

#[test]
fn contradictory_properties_are_shown_in_place() {
    let with = |properties: &str| {
        let steps = "{ repeat = { times = 2, steps = [{ straight = { distance_m = 1 } }] } }";
        with_steps(steps) + properties
    };
    let cases = [
        ("an unknown property", with("[[property]]\nalways = { fresh_headings = {} }\n")),
        ("an unknown state", with("[[property]]\nsometimes = \"gyro_silence\"\n")),
        (
            "an unknown limit",
            with("[[property]]\nalways = { fresh_heading = { age_ms_max = 100 } }\n"),
        ),
        (
            "a limit that is none",
            with("[[property]]\nalways = { recovers = { within_s_max = -1 } }\n"),
        ),
        (
            "one property, two limits",
            with(
                "[[property]]\nalways = { fresh_heading = { age_s_max = 0.1 } }\n[[property]]\nalways \
                 = { fresh_heading = { age_s_max = 0.2 } }\n",
            ),
        ),
        (
            "one state twice",
            with("[[property]]\nsometimes = \"bus_off\"\n[[property]]\nsometimes = \"bus_off\"\n"),
        ),
        (
            "slower than the plan drives",
            with("[[property]]\nalways = { within_limits = { speed_m_per_s_max = 0.3 } }\n"),
        ),
        (
            "gentler than the ramps",
            with(
                "[[property]]\nalways = { within_limits = { steer_acceleration_deg_per_s2_max = 10 } }\n",
            ),
        ),
        (
            "harder than the brakes",
            with("[[property]]\nalways = { stops_on_loss = { braking_m_per_s2_min = 2 } }\n"),
        ),
        (
            "more exact than the controller stops",
            with("[[property]]\nalways = { done_is_done = { turn_deg_max = 0.01 } }\n"),
        ),
        (
            "sooner than the controller speaks",
            with("[[property]]\nalways = { recovers = { within_s_max = 0.01 } }\n"),
        ),
    ];
    insta::assert_snapshot!(table(&cases));
}

#[test]
fn every_property_can_be_written() {
    use crate::{Property, Sometimes};
    let mut text = with_steps("{ straight = { distance_m = 1 } }");
    for property in Property::all() {
        let value = match property {
            Property::Always(always) => format!("always = {{ {} = {{}} }}", always.name()),
            Property::Sometimes(state) => format!("sometimes = \"{}\"", state.name()),
            Property::Stated(_) => unreachable!("it is not built in"),
        };
        text += &format!("[[property]]\n{value}\n");
    }
    let plan = Plan::parse("p.toml", &text).unwrap();
    assert_eq!(plan.properties, Property::all());
    assert!(plan.properties.contains(&Property::Sometimes(Sometimes::BusOff)));
    let limits = "[[property]]\nalways = { within_limits = { speed_m_per_s_max = 0.4, \
                  acceleration_m_per_s2_max = 0.4, steer_acceleration_deg_per_s2_max = 15 } }\n";
    let exact = with_steps("{ straight = { distance_m = 1 } }") + limits;
    assert!(Plan::parse("p.toml", &exact).is_ok(), "a limit that is just met");
}

fn table(cases: &[(&str, String)]) -> String {
    cases.iter().map(|(what, text)| format!("## {what}\n{}\n", rendered(&error(text)))).collect()
}

#[test]
fn sizes_are_bounded() {
    let mut nested = "{ bias_test = {} }".to_owned();
    for _ in 0..DEPTH_MAX {
        nested = format!("{{ repeat = {{ times = 1, steps = [{nested}] }} }}");
    }
    assert!(error(&with_steps(&nested)).message().starts_with("steps nested"));

    let many = "{ bias_test = {} },".repeat(STEPS_MAX + 1);
    assert!(error(&with_steps(&many)).message().starts_with("more than"));

    let mut often = "{ bias_test = {} }".to_owned();
    for _ in 0..2 {
        often = format!("{{ repeat = {{ times = 100000, steps = [{often}] }} }}");
    }
    assert!(error(&with_steps(&often)).message().contains("when carried out"));

    let long = "#".repeat(FILE_LEN_MAX + 1);
    assert!(rendered(&error(&long)).contains("bytes"));

    // Deeper than the parser's own limit.
    assert!(Plan::parse("p.toml", &format!("{HEAD}steps = {}", "[".repeat(10_000))).is_err());
}

proptest::proptest! {
    #[test]
    fn no_text_makes_it_panic(text in "\\PC{0,200}") {
        if let Err(error) = Plan::parse("p.toml", &text) {
            rendered(&error);
        }
    }

    #[test]
    fn no_edit_makes_it_panic(at in 0usize..400, with in "[\\[\\]{}=\",0-9a-z.\n-]{0,3}") {
        let mut text = with_steps("{ repeat = { times = 2, steps = [{ turn = { angle_deg = 90 } }] } }");
        let at = at % (text.len() + 1);
        text.insert_str(at, &with);
        if let Err(error) = Plan::parse("p.toml", &text) {
            proptest::prop_assert!(error.range().end <= text.len());
            proptest::prop_assert!(rendered(&error).contains("p.toml:"));
        }
    }
}
