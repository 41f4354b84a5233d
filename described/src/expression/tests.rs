//! What expressions mean, and what is said of those that mean nothing.

use super::{Expression, ExpressionError, Scope};
use crate::hint;
use proptest::prelude::*;

/// `t`, `x`, `y` and `Command.Setpoint` are the slots 0 to 3; `last(x)` is slot 4.
struct Names;

impl Scope for Names {
    fn variable(&self, name: &str) -> Result<usize, (String, String)> {
        let known = ["t", "x", "y", "Command.Setpoint"];
        let unknown = || (format!("no variable `{name}`"), hint::proposal(name, &known));
        known.iter().position(|known| *known == name).ok_or_else(unknown)
    }

    fn last(&self, name: &str) -> Result<usize, (String, String)> {
        self.variable(name).map(|_| 4)
    }
}

fn parse(text: &str) -> Result<Expression, ExpressionError> {
    Expression::parse(text, &Names)
}

fn value(text: &str) -> f64 {
    let expression = parse(text).unwrap_or_else(|error| panic!("{text}: {}", error.message));
    expression.value(&[10.0, 3.0, -2.0, 40.0, 7.0])
}

#[test]
fn operators_bind_as_in_mathematics() {
    for (text, expected) in [
        ("1 + 2 * 3", 7.0),
        ("-x^2", -9.0),
        ("(-x)^2", 9.0),
        ("2^-1", 0.5),
        ("2^3^2", 512.0),
        ("-2^-2", -0.25),
        ("7 - 2 - 1", 4.0),
        ("8 / 4 / 2", 1.0),
        ("2 * -x", -6.0),
        ("-1 % 3", 2.0),
        ("1.5e1 + .5", 15.5),
        ("t - x*y + Command.Setpoint", 56.0),
        ("last(x) - x", 4.0),
        ("2 * pi", std::f64::consts::TAU),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
}

#[test]
fn what_is_true_is_one() {
    for (text, expected) in [
        ("x > 2", 1.0),
        ("x >= 3 and y < 0", 1.0),
        ("x == 3 or 1 / 0 > 1", 1.0),
        ("not x == 3", 0.0),
        ("not (x > 5) and x != 4", 1.0),
        ("1 + (x > 2) * 5", 6.0),
        ("if(x > 2, 10, 20)", 10.0),
        ("if(x > 5, 10, if(y <= -2, 30, 20))", 30.0),
        ("if(x > 0, sqrt(x + 1), sqrt(-1))", 2.0),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
}

#[test]
fn functions_are_those_of_the_table() {
    for (text, expected) in [
        ("min(x, y, 1)", -2.0),
        ("max(x, y, 5)", 5.0),
        ("clamp(x, 0, 2)", 2.0),
        ("clamp(y, 0, 2)", 0.0),
        ("abs(y) + sign(y) + sign(0)", 1.0),
        ("floor(2.7) + ceil(2.2) + round(2.5)", 8.0),
        ("exp(ln(5)) - 5 < 1e-12", 1.0),
        ("log10(1000)", 3.0),
        ("sin(0) + cos(0) + tan(0) + tanh(0)", 1.0),
        ("atan2(1, 0) - asin(1)", 0.0),
        ("acos(1) + atan(0)", 0.0),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
}

#[test]
fn what_is_not_a_number_is_not_hidden() {
    for text in [
        "0 / 0",
        "sqrt(-1)",
        "min(0/0, 1)",
        "clamp(0/0, 0, 1)",
        "if(0/0, 1, 2)",
        "x % 0",
        "not (0/0 > 1)",
        "1 or 0/0",
    ] {
        assert!(value(text).is_nan(), "{text}");
    }
}

#[test]
fn mistakes_are_shown_where_they_are() {
    let mut table = String::new();
    for text in [
        "",
        "1 +",
        "1 2",
        "(1 + 2",
        "x < y < 3",
        "Command.Setpiont * 2",
        "sqr(x)",
        "clamp(x, 1)",
        "min(x)",
        "abs + 1",
        "x ** 2",
        "x && y",
        "x = 3",
        "x != 3 ! y",
        "1.2.3",
        "x § y",
        "last(3)",
        "and x",
    ] {
        let error = parse(text).unwrap_err();
        let marks = " ".repeat(error.at.start) + &"^".repeat(error.at.len().max(1));
        let help = error.help.map_or(String::new(), |help| format!("; {help}"));
        table += &format!("{text}\n{marks} {}{help}\n", error.message);
    }
    insta::assert_snapshot!(table);
}

#[test]
fn what_is_too_deep_is_refused() {
    let deep = "(".repeat(200) + "1" + &")".repeat(200);
    assert_eq!(parse(&deep).unwrap_err().message, "the expression is nested too deeply");
    let wide = "1 - (".repeat(40) + "1" + &")".repeat(40);
    let message = parse(&wide).unwrap_err().message;
    assert_eq!(message, "the expression keeps too many values at once");
    assert!(parse(&"1+".repeat(2000)).unwrap_err().message.contains("at most"));
    // Long is not deep.
    assert_eq!(value(&format!("1{}", "+1".repeat(900))), 901.0);
}

proptest! {
    #[test]
    fn no_text_makes_it_panic(text in "[-+*/%^()<>=!,. a-z0-9_x§]{0,40}") {
        if let Ok(expression) = parse(&text) {
            let _ = expression.value(&[]);
        }
    }

    #[test]
    fn sums_and_products_are_those_of_rust(a in -1e3f64..1e3, b in -1e3f64..1e3, c in -1e3f64..1e3) {
        prop_assert_eq!(value(&format!("{a} + {b} * {c} - {a} / {b}")), a + b * c - a / b);
    }
}
