//! Terms that are converted, terms that are rejected, and the agreement of both ends.

mod cancel;

use super::{calibration, corrections, learned};
use controller::calibration::{Calibration, Factor};
use controller::correction::{Acts, Driver, Form, Term};
use identification::model::Model;

/// A model of these terms, each written as the body of a `[[terms]]`.
fn model(terms: &[&str]) -> Model {
    let head = "schema = 1\nkind = 'turns'\n[fields]\ncoil = 'temperature'\nspin = 'table_rate'\n\
                since_on = 'time'\npsi = 'heading'\nsupply = 'auxiliary'\n";
    let terms = terms.iter().map(|term| format!("[[terms]]\n{term}\n"));
    toml::from_str(&(head.to_owned() + &terms.collect::<String>())).unwrap()
}

/// The body of a term: what it acts on, its drivers, its form, and its parameters.
fn term(acts: &str, drivers: &str, form: &str, parameters: &[(&str, f64, &str)]) -> String {
    let parameters: Vec<_> = parameters
        .iter()
        .map(|(name, value, unit)| {
            format!("{{ name = '{name}', value = {value:e}, unit = '{unit}' }}")
        })
        .collect();
    let drivers: Vec<_> = drivers.split_whitespace().map(|driver| format!("'{driver}'")).collect();
    format!(
        "name = 't'\nterm = '{acts}'\ndrivers = [{}]\nform = '{form}'\nparameters = [{}]",
        drivers.join(", "),
        parameters.join(", ")
    )
}

fn refusal(term: &str) -> String {
    corrections(&model(&[term])).expect_err(term).to_string()
}

#[test]
fn a_controller_mends_no_wiring_and_asks_nothing_of_a_reference() {
    let with = |fault: &str, unit: &str| {
        let text = format!(
            "schema = 1\nkind = 'series'\n[fields]\n[[corrections]]\nfault = '{fault}'\nfield = 'table'\nvalue = 0.2\nunit = '{unit}'\n"
        );
        corrections(&toml::from_str(&text).unwrap())
    };
    assert!(with("reversed_sign", "1").is_err());
    assert!(with("reference_noise", "s").unwrap().is_empty());
}

#[test]
fn a_term_is_carried_in_si() {
    let shupe = term("bias", "rate_of(coil)", "linear", &[("h", 10.0, "deg/h/(K/min)")]);
    let line =
        term("scale", "coil", "linear", &[("slope", -1444.0, "ppm/K"), ("origin", 36.98, "Cel")]);
    let found = corrections(&model(&[&shupe, &line])).unwrap();
    let deg = std::f64::consts::PI / 180.0;
    let Term {
        acts: Acts::Bias,
        driver: Driver::TemperatureRate,
        form: Form::Linear { slope, origin },
        within: None,
        within_2: None,
    } = &found[0]
    else {
        panic!("{found:?}")
    };
    assert!((slope / (10.0 * deg / 60.0) - 1.0).abs() < 1e-12 && *origin == 0.0, "{slope}");
    assert_eq!(found[1].driver, Driver::Temperature);
    let Form::Linear { slope, origin } = found[1].form else { panic!("{found:?}") };
    assert!((slope + 0.001_444).abs() < 1e-15 && origin == 36.98);
}

#[test]
fn the_calibration_in_force_stays_but_for_its_own_terms() {
    let mut in_force = Calibration { scale: 1.01, ..Calibration::default() };
    in_force.factors.push(Factor::Constant(0.99)).unwrap();
    let one = term("bias", "", "constant", &[("value", 1.0, "deg/h")]);
    let combined = calibration(&model(&[&one]), &in_force).unwrap();
    assert_eq!((combined.scale, combined.factors.len()), (1.01, 1));
    assert_eq!(combined.corrections.len(), 1);
    assert_eq!(calibration(&model(&[]), &combined).unwrap(), in_force);
}

/// The ends of the data go with the term, and a straight line a tenth of their distance beyond.
#[test]
fn a_term_is_held_where_the_data_end_by_both() {
    let seen = [("seen_from", 20.0, "Cel"), ("seen_to", 40.0, "Cel")];
    let numbers = |one: &'static str, unit| {
        [&[(one, 2.0, unit), ("origin", 30.0, "Cel")], &seen[..]].concat()
    };
    let line = term("bias", "coil", "linear", &numbers("slope", "deg/h/K"));
    let curve = term("bias", "coil", "quadratic", &numbers("coefficient", "deg/h/K^2"));
    let product = [
        ("coefficient", 1.0, "1/K/(deg/s)"),
        ("seen_from", 20.0, "Cel"),
        ("seen_to", 40.0, "Cel"),
        ("seen_from_2", -180.0, "deg/s"),
        ("seen_to_2", 90.0, "deg/s"),
    ];
    let product = term("scale", "coil spin", "product", &product);
    let seconds = [("slope", 0.1, "deg/s/h"), ("seen_from", 0.0, "s"), ("seen_to", 60.0, "s")];
    let ageing = term("bias", "trend(since_on)", "linear", &seconds);
    let model = model(&[&line, &curve, &product, &ageing]);
    let found = corrections(&model).unwrap();
    assert_eq!(found[3].within, None, "what ages goes on ageing");
    assert_eq!(found[0].within, Some([18.0, 42.0]));
    assert_eq!(found[1].within, Some([20.0, 40.0]));
    let [low, high] = found[2].within_2.unwrap();
    let half_turn = std::f64::consts::PI;
    assert!((low + half_turn).abs() < 1e-12 && (high - half_turn / 2.0).abs() < 1e-12);
    let emulated = learned(&model).unwrap().terms;
    for (corrected, emulated) in found.iter().zip(&emulated) {
        assert_eq!((corrected.within, corrected.within_2), (emulated.within, emulated.within_2));
    }
}

/// If the play's output itself is the driver, origin included, it equals the temperature plus the difference of the
/// output from it.
#[test]
fn what_goes_through_a_play_as_a_whole_is_two_terms() {
    let parameters = [
        ("slope", 2.0, "deg/h/K"),
        ("half_width", 1.5, "K"),
        ("origin", 30.0, "Cel"),
        ("through", 1.0, "1"),
    ];
    let whole = term("bias", "branch_of(coil)", "linear", &parameters);
    let found = corrections(&model(&[&whole])).unwrap();
    assert_eq!(found[0].driver, Driver::TemperatureBranch { half_width_kelvin: 1.5 });
    assert_eq!(found[1].driver, Driver::Temperature);
    let (Form::Linear { slope: own, origin: middle }, Form::Linear { slope, origin }) =
        (&found[0].form, &found[1].form)
    else {
        panic!("{found:?}")
    };
    assert_eq!((own, *middle, *origin), (slope, 0.0, 30.0));
    assert_eq!(learned(&model(&[&whole])).unwrap().terms.len(), 2);
}

#[test]
fn a_function_beyond_every_error_is_refused() {
    let spline = |value: f64| {
        let values = [("value_1", value, "deg/s"), ("value_2", 0.0, "deg/s")];
        term("bias", "coil", "spline", &values) + "\nknots = [20, 40]"
    };
    assert!(corrections(&model(&[&spline(0.4)])).is_ok());
    assert!(refusal(&spline(100.0)).contains("cancel"), "{}", refusal(&spline(100.0)));
}

#[test]
fn what_cannot_be_carried_is_named_with_the_reason() {
    let rate = ("slope", 1.0, "deg/s/K");
    for (term, why) in [
        (term("delay", "spin", "delay", &[("delay", 0.01, "s")]), "not correctable online"),
        (term("dead_zone", "spin", "dead_zone", &[("width", 0.01, "deg/s")]), "dead zone"),
        (term("noise", "", "constant", &[("value", 1.0, "deg/h")]), "only known afterwards"),
        (term("turn", "spin", "linear", &[rate]), "of the drive"),
        (term("bias", "supply", "linear", &[rate]), "no view of `supply`"),
        (term("bias", "rate_of(spin)", "linear", &[rate]), "no view of `rate_of(spin)`"),
        (term("bias", "room", "linear", &[rate]), "does not say what `room` is"),
        (term("bias", "coil", "linear", &[]), "no parameter `slope`"),
        (term("bias", "coil", "linear", &[("slope", 1.0, "furlong")]), "unit `furlong`"),
        (term("bias", "", "linear", &[rate]), "no driver"),
        (term("bias", "lag_of(coil)", "linear", &[rate]), "no parameter `time_constant`"),
        (term("bias", "coil", "surface", &[]), "surface"),
        (term("bias", "coil spin", "linear", &[rate]), "product"),
        (
            term("bias", "coil", "harmonic", &[("cos", 1.0, "deg/s"), ("sin", 1.0, "deg/s")]),
            "heading",
        ),
        (
            term(
                "bias",
                "coil",
                "periodic",
                &[("cos", 1.0, "deg/s"), ("sin", 1.0, "deg/s"), ("period", 0.0, "K")],
            ),
            "not usable",
        ),
        (
            term("scale", "spin", "spline", &[("value_1", 0.0, "1"), ("value_2", 1.0, "1")])
                + "\nknots = [1, 2]",
            "unit of its knots",
        ),
        (
            term("scale", "coil", "spline", &[("value_1", 0.0, "1"), ("value_2", 1.0, "1")])
                + "\nknots = [2, 1]",
            "rising order",
        ),
    ] {
        let said = refusal(&term);
        assert!(said.starts_with("term `t` cannot be carried: ") && said.contains(why), "{said}");
    }
    let many = vec![term("bias", "", "constant", &[("value", 1.0, "deg/h")]); 18];
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    let refused = corrections(&model(&many)).unwrap_err();
    assert_eq!(refused.0.len(), 2);
    assert!(refused.to_string().contains("16 terms at most"), "{refused}");
}

#[test]
fn an_emulated_gyro_learns_what_a_controller_cannot_correct() {
    let found = learned(&model(&[
        &term("delay", "spin", "delay", &[("delay", 0.01, "s")]),
        &term("delay", "lag_of(spin)", "delay", &[("time_constant", 0.01, "s")]),
        &term("dead_zone", "spin", "dead_zone", &[("width", 0.01, "deg/s"), ("gain", 1.0, "1")]),
        &term("saturation", "spin", "saturation", &[("limit", 90.0, "deg/s")]),
    ]))
    .unwrap();
    let parameter = |name: &str| found.parameters[name];
    assert_eq!(parameter("latency_s"), 0.01);
    assert!((parameter("bandwidth_hz") - 15.915_494).abs() < 1e-5);
    assert!((parameter("dead_zone_deg_per_s") - 0.01).abs() < 1e-12);
    assert!((parameter("range_deg_per_s") - 90.0).abs() < 1e-12);
    let noise = term("noise", "", "constant", &[("value", 1.0, "deg/h")]);
    assert!(learned(&model(&[&noise])).unwrap_err().to_string().contains("Noise"));
}
