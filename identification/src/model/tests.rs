//! A written term reads back in the units it was written in.

use super::{Acts, Driver, Form, KNOT, Shape, Term, Wrap};
use crate::dataset::{Column, Dataset, Kind, Role, Unit};
use crate::problem::{Channels, DisplayUnit};

const ROWS: usize = 40;

/// A temperature in degrees Celsius, an acceleration, and a rotation in deg/s.
pub(super) fn channels() -> Channels {
    let column = |name: &str, role, unit, value: &dyn Fn(f64) -> f64| {
        Column::new(name, role, unit, (0..ROWS).map(|row| value(row as f64)).collect())
    };
    let dataset = Dataset::new(
        "bench",
        Kind::Turns,
        vec![
            column("time", Role::Time, Unit::Second, &|row| 60.0 * row),
            column("coil", Role::Temperature, Unit::Celsius, &|row| 20.0 + 0.3 * row),
            column("jolt", Role::Auxiliary, Unit::MetrePerSecondSquared, &|row| row.sin()),
        ],
        vec![0; ROWS],
    );
    let mut channels = Channels::new(&dataset);
    channels.rotation = (0..ROWS).map(|row| 0.01 * row as f64).collect();
    channels.rotation_unit = Unit::DegreePerSecond;
    channels
}

fn written(shape: &Shape) -> Term {
    let fitted = (0.25, 0.01);
    let unit = DisplayUnit::new("deg/s", Unit::DegreePerSecond.si());
    let coefficients = vec![fitted; shape.width()];
    Term::from_shape(shape, &coefficients, &[], &unit, &channels())
}

fn unit<'a>(term: &'a Term, name: &str) -> &'a str {
    &term.parameter(name).unwrap_or_else(|| panic!("no {name} in {term:?}")).unit
}

fn shape(driver: Driver, form: Form, numbers: &[(&str, f64)]) -> Shape {
    let plain = Shape::new("t", Acts::Bias, driver, form);
    numbers.iter().fold(plain, |shape, (name, value)| shape.with(name, *value))
}

#[test]
fn a_place_is_in_the_unit_of_the_field_and_a_difference_is_not() {
    let coil = || Driver::plain("coil");
    let of = |wrap| Driver::new(wrap, "coil");
    let bump = shape(coil(), Form::Bump, &[("centre", 26.0), ("width", 2.0)]);
    let branch = [("half_width", 1.5), ("origin", 30.0)];
    let whole = [("half_width", 1.5), ("origin", 30.0), ("through", 1.0)];
    for (shape, name, expected) in [
        (&bump, "centre", "Cel"),
        (&bump, "width", "K"),
        (&shape(coil(), Form::Linear, &[("origin", 30.0)]), "origin", "Cel"),
        (&shape(coil(), Form::Hinge, &[("at", 30.0)]), "at", "Cel"),
        (&shape(coil(), Form::Hinge, &[("at", 30.0)]), "slope", "deg/s/K"),
        (&shape(of(Wrap::LagOf), Form::Linear, &[("origin", 30.0)]), "origin", "Cel"),
        (&shape(of(Wrap::RateOf), Form::Linear, &[("origin", 0.1)]), "origin", "K/s"),
        (&shape(of(Wrap::BranchOf), Form::Linear, &branch), "origin", "K"),
        (&shape(of(Wrap::BranchOf), Form::Linear, &whole), "origin", "Cel"),
        (&shape(of(Wrap::BranchOf), Form::Linear, &whole), "half_width", "K"),
    ] {
        assert_eq!(unit(&written(shape), name), expected, "{name} of {}", shape.label());
    }
}

#[test]
fn a_spline_says_the_unit_of_its_knots() {
    let mut spline = shape(Driver::plain("reference_rate"), Form::Spline, &[]);
    spline.knots = vec![0.0, 0.1, 0.2];
    let term = written(&spline);
    assert_eq!(unit(&term, KNOT[0]), "deg/s");
    assert!((term.knots[1] - 0.1_f64.to_degrees()).abs() < 1e-12, "{term:?}");
    let over_coil = Shape { drivers: vec![Driver::plain("coil")], ..spline.clone() };
    assert_eq!(unit(&written(&over_coil), KNOT[0]), "Cel");
    let mut surface = Shape { form: Form::Surface, ..spline };
    surface.drivers.push(Driver::plain("coil"));
    surface.knots_2 = vec![20.0, 30.0];
    let term = written(&surface);
    assert_eq!((unit(&term, KNOT[0]), unit(&term, KNOT[1])), ("deg/s", "Cel"));
}

#[test]
fn what_is_written_is_read() {
    let coil = || Driver::plain("coil");
    let rate = || Driver::plain("reference_rate");
    let mut spline = shape(rate(), Form::Spline, &[]);
    spline.knots = vec![0.0, 0.1, 0.2];
    let mut surface = Shape { form: Form::Surface, ..spline.clone() };
    surface.drivers.push(coil());
    surface.knots_2 = vec![20.0, 30.0];
    let mut product = shape(coil(), Form::Product, &[("origin", 25.0), ("origin_2", 0.1)]);
    product.drivers.push(rate());
    for shape in [
        shape(coil(), Form::Bump, &[("centre", 26.0), ("width", 2.0)]),
        shape(rate(), Form::Tanh, &[("centre", 0.1), ("width", 0.02)]),
        shape(Driver::plain("jolt"), Form::Quadratic, &[("origin", 0.5)]),
        shape(Driver::new(Wrap::RateOf, "coil"), Form::Cubic, &[("origin", 0.1)]),
        spline,
        surface,
        product,
    ] {
        let term = written(&shape);
        let text = toml::to_string(&term).unwrap();
        let (found, coefficients) =
            toml::from_str::<Term>(&text).unwrap().to_shape(&channels()).unwrap();
        let close = |a: &[f64], b: &[f64]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
        };
        assert!(close(&coefficients, &vec![0.25; shape.width()]), "{text}");
        assert!(close(&found.knots, &shape.knots), "{text}");
        assert!(close(&found.knots_2, &shape.knots_2), "{text}");
        for (name, value) in &shape.fixed {
            assert!(close(&[found.number(name).unwrap()], &[*value]), "{name}: {text}");
        }
        assert_eq!(found.fixed.len(), shape.fixed.len(), "{text}");
    }
}

#[test]
fn a_power_is_held_where_the_data_end_and_a_line_a_little_beyond() {
    let channels = channels();
    let limits = |form| {
        let shape = shape(Driver::plain("coil"), form, &[("origin", 25.0)]).within_seen(&channels);
        shape.limits(0).unwrap().map(|end| (10.0 * end).round() / 10.0)
    };
    // From 20 to 31.7 degC.
    assert_eq!(limits(Form::Quadratic), [20.0, 31.7]);
    assert_eq!(limits(Form::Cubic), [20.0, 31.7]);
    assert_eq!(limits(Form::Linear), [18.8, 32.9]);
}

/// Older models were written so; the number is in degrees Celsius all the same.
#[test]
fn a_place_in_kelvin_is_the_same_number_of_degrees_celsius() {
    let mut term = written(&shape(Driver::plain("coil"), Form::Hinge, &[("at", 30.0)]));
    let at = term.parameters.iter_mut().find(|one| one.name == "at").unwrap();
    "K".clone_into(&mut at.unit);
    let (found, _) = term.to_shape(&channels()).unwrap();
    assert_eq!(found.number("at"), Some(30.0));
}

#[test]
fn knots_without_a_unit_are_in_that_of_the_field() {
    let mut spline = shape(Driver::plain("reference_rate"), Form::Spline, &[]);
    spline.knots = vec![0.0, 0.1, 0.2];
    let mut term = written(&spline);
    term.parameters.retain(|one| one.name != KNOT[0]);
    let (found, _) = term.to_shape(&channels()).unwrap();
    assert!((found.knots[2] - 0.2).abs() < 1e-12);
    term.parameters.push(crate::finding::Parameter {
        name: KNOT[0].to_owned(),
        value: 1.0,
        standard_error: None,
        unit: "furlong".to_owned(),
        range: None,
    });
    assert!(term.to_shape(&channels()).unwrap_err().contains("furlong"));
}

#[test]
fn a_time_constant_below_zero_is_refused_by_its_place() {
    let lag = Driver::new(Wrap::LagOf, "coil");
    let mut term = written(&shape(lag, Form::Linear, &[("time_constant", 90.0), ("origin", 20.0)]));
    assert!(term.to_shape(&channels()).is_ok());
    let constant = term.parameters.iter_mut().find(|one| one.name == "time_constant");
    constant.expect("a lag has one").value = -3.0;
    let told = term.to_shape(&channels()).expect_err("no lag ends before it begins");
    assert_eq!(told, "term `t`: its `time_constant` is -3 s: expected zero or more");
}

/// Rows a minute apart: its error was zero.
#[test]
fn a_step_lies_somewhere_between_two_rows() {
    let step = shape(Driver::new(Wrap::Step, "time"), Form::Step, &[("at", 200.0)]);
    let term = written(&step);
    let at = term.parameter("at").expect("a place");
    assert!(at.standard_error.is_some_and(|error| (error - 60.0 / 12f64.sqrt()).abs() < 1e-9));
}
