//! Meaning of expressions, and messages for invalid ones.

use super::array::Array;
use super::operation::Binary;
use super::program::choose;
use super::{
    Batch, Expression, ExpressionError, Meaning, Operation, Scope, States, Unknown, parser,
};
use crate::file::Outside;
use crate::hint;
use crate::lookup::Lookup;
use proptest::prelude::*;
use std::sync::Arc;

/// `t`, `x`, `y` and `Command.Setpoint` are the slots 0 to 3; `last(x)` is slot 4; the array `cell` from 1 to 3 is in
/// the slots 5 to 7, and the machine `mode`, entered at slot 9, in slot 8.
struct Names;

const CELL: Array = Array { slot: 5, count: 3, first: 1 };

impl Scope for Names {
    fn variable(&self, name: &str) -> Result<Meaning, Unknown> {
        let known = ["t", "x", "y", "Command.Setpoint"];
        let unknown = || (format!("no variable `{name}`"), hint::proposal(name, &known));
        match name {
            "cell" => Ok(Meaning::Array(CELL)),
            "i" => Ok(Meaning::Number(2.0)),
            "mode" => Ok(Meaning::Slot(8)),
            "ocv" => {
                let values = vec![3.0, 4.0];
                let table = Lookup::new(vec![0.0, 1.0], Vec::new(), values, Outside::Clamp);
                Ok(Meaning::Table(Arc::new(table)))
            }
            "plane" => {
                let axis = vec![0.0, 10.0];
                let values = vec![0.0, 1.0, 2.0, 7.0];
                let table = Lookup::new(axis.clone(), axis, values, Outside::Extrapolate);
                Ok(Meaning::Table(Arc::new(table)))
            }
            _ => {
                known.iter().position(|known| *known == name).map(Meaning::Slot).ok_or_else(unknown)
            }
        }
    }

    fn last(&self, name: &str) -> Result<Meaning, Unknown> {
        self.variable(name).map(|found| match found {
            Meaning::Array(array) => Meaning::Array(array),
            _ => Meaning::Slot(4),
        })
    }

    fn states(&self, machine: &str) -> Result<States<'_>, Unknown> {
        let known = ["mode"];
        let unknown = || (format!("no machine `{machine}`"), hint::proposal(machine, &known));
        let states = States { slot: 8, entered: 9, names: &[] };
        known.contains(&machine).then_some(states).ok_or_else(unknown)
    }

    fn named(&self, _variable: &str, value: &str) -> Result<f64, Unknown> {
        let known = ["Open", "Closed"];
        let unknown = || (format!("no value `{value}`"), hint::proposal(value, &known));
        known.iter().position(|known| *known == value).map(|place| place as f64).ok_or_else(unknown)
    }
}

const VARIABLES: [f64; 10] = [10.0, 3.0, -2.0, 40.0, 7.0, 4.1, 3.9, 4.3, 1.0, 2.5];

fn parse(text: &str) -> Result<Expression, ExpressionError> {
    Expression::parse(text, &Names)
}

fn value(text: &str) -> f64 {
    let expression = parse(text).unwrap_or_else(|error| panic!("{text}: {}", error.message));
    expression.value(&VARIABLES)
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
fn arrays_tables_and_machines_have_their_words() {
    for (text, expected) in [
        ("cell[1] + cell[i]", 8.0),
        ("cell[i + 1] - cell[min(i + 5, 3)]", 0.0),
        ("cell[x - 1]", 3.9),
        ("cell[x]", 4.3),
        ("max(cell) - min(cell) < 0.4 + 1e-9", 1.0),
        ("sum(cell)", 4.1 + 3.9 + 4.3),
        ("mean(cell) * 3 - sum(cell) < 1e-12", 1.0),
        ("10 * argmax(cell) + argmin(cell)", 32.0),
        ("ocv(0.25) + ocv(x)", 7.25),
        ("plane(5, 5)", 2.5),
        ("x * plane(x + 7, 10) - 1", 20.0),
        ("mode == \"Closed\"", 1.0),
        ("mode != 'Closed' or x == 3", 1.0),
        ("time_in(mode)", 7.5),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
    for text in ["cell[x + 1]", "cell[x / 2]", "cell[0/0]", "1 / cell[y]"] {
        let found = parse(text).map(|expression| expression.value(&VARIABLES));
        assert!(found.is_ok_and(f64::is_nan) || text == "cell[0/0]", "{text}");
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
        "cell + 1",
        "cell[4]",
        "cell[i + 2]",
        "cell[1.5]",
        "x[1]",
        "cell[1",
        "sum(x)",
        "mean(cell[1])",
        "max(cell, 3)",
        "sum + 1",
        "ocv * 2",
        "ocv(1, 2)",
        "plane(1)",
        "mode == \"Clsoed\"",
        "\"Closed\" == mode",
        "mode == \"Closed",
        "time_in(modus)",
        "x + mode == \"Closed\"",
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

/// The value by evaluating the operations one by one, without constant folding.
fn naive(operations: &[Operation], variables: &[f64]) -> f64 {
    let mut stack = Vec::new();
    for operation in operations {
        let mut pop = || stack.pop().unwrap();
        let value = match operation {
            Operation::Constant(value) => *value,
            Operation::Variable(slot) => variables[*slot],
            Operation::Unary(unary) => unary.apply(pop()),
            Operation::Binary(binary) => {
                let right = pop();
                binary.apply(pop(), right)
            }
            Operation::Clamp => {
                let (high, low, x) = (pop(), pop(), pop());
                Binary::Max.apply(low, Binary::Min.apply(high, x))
            }
            Operation::Choose => {
                let (otherwise, then, condition) = (pop(), pop(), pop());
                choose(condition, then, otherwise)
            }
            Operation::Element(array) => array.element(pop(), variables),
            Operation::Aggregate(aggregate, array) => aggregate.of(*array, variables),
            Operation::LookUp(table) if table.dimensions() == 1 => table.value(pop(), f64::NAN),
            Operation::LookUp(table) => {
                let y = pop();
                table.value(pop(), y)
            }
        };
        stack.push(value);
    }
    stack.pop().unwrap()
}

/// Texts of expressions with all features.
fn expressions() -> impl Strategy<Value = String> {
    let leaf = prop::sample::select(vec![
        "1",
        "0",
        "2.5",
        "x",
        "y",
        "t",
        "i",
        "cell[2]",
        "max(cell)",
        "sum(cell)",
        "time_in(mode)",
        "last(x)",
        "(mode == 'Closed')",
        "Command.Setpoint",
    ]);
    leaf.prop_map(str::to_owned).prop_recursive(6, 40, 3, |inner| {
        let operator = prop::sample::select(vec![
            "+", "-", "*", "*", "/", "%", "^", "<", "==", "and", "or",
        ]);
        prop_oneof![
            6 => (inner.clone(), operator, inner.clone()).prop_map(|(a, op, b)| format!("({a} {op} {b})")),
            1 => inner.clone().prop_map(|a| format!("(-{a})")),
            1 => inner.clone().prop_map(|a| format!("ocv({a})")),
            1 => inner.clone().prop_map(|a| format!("cell[1 + {a} % 3]")),
            1 => (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("plane({a}, {b})")),
            1 => (inner.clone(), inner.clone(), inner.clone()).prop_map(|(a, b, c)| format!("if({a}, {b}, {c})")),
            1 => (inner.clone(), inner.clone(), inner).prop_map(|(a, b, c)| format!("clamp({a}, {b}, {c})")),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn the_program_is_what_is_written(text in expressions(), variables in prop::array::uniform10(-5.0f64..5.0)) {
        // Expressions that are too deep, or with an invalid index, are refused by the parser.
        let Ok(operations) = parser::parse(&text, &Names) else { return Ok(()) };
        let (found, expected) = (Expression::of(&operations).value(&variables), naive(&operations, &variables));
        prop_assert!(found == expected || (found.is_nan() && expected.is_nan()), "{text}: {found} {expected}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// A batch gives the value of each expression, whatever their shapes.
    #[test]
    fn a_batch_is_its_expressions(
        texts in prop::collection::vec((expressions(), 1_usize..30), 1..5),
        variables in prop::array::uniform10(-5.0f64..5.0),
    ) {
        // Several variants of each with other inputs, interleaved with the others.
        let written = texts.iter().flat_map(|(text, count)| (0..*count).map(move |index| (index, text)));
        let mut written: Vec<(usize, String)> = written
            .map(|(index, text)| (index, if index % 2 == 0 { text.clone() } else { text.replace('x', "y") }))
            .collect();
        written.sort();
        let expressions: Vec<Expression> = written.iter().filter_map(|(_, text)| parse(text).ok()).collect();
        // Two occasions, so that shapes are split.
        let placed = expressions.iter().enumerate();
        let batch = Batch::new(placed.map(|(place, expression)| (place > 20, place, expression)));
        let mut values = vec![0.0; expressions.len()];
        for block in batch.blocks_of(&(0..values.len())) {
            batch.evaluate(block, &variables, &mut values);
        }
        for (expression, value) in expressions.iter().zip(values) {
            prop_assert_eq!(value.to_bits(), expression.value(&variables).to_bits());
        }
    }
}

/// Cells of a pack are evaluated together, and one with another shape by itself.
#[test]
fn those_of_one_shape_are_found() {
    let texts =
        ["3.3 + 0.8 * x - t * y", "3.4 + 0.7 * x - t * y", "3.3 + 0.8 * x", "min(x, y) + 1", "x"];
    let expressions = texts.map(|text| parse(text).unwrap());
    let placed = expressions.iter().enumerate();
    let batch = Batch::new(placed.map(|(place, expression)| ((), place, expression)));
    assert_eq!(batch.shapes(), [vec![0, 1], vec![2], vec![3], vec![4]]);
}

proptest! {
    #[test]
    fn no_text_makes_it_panic(text in "[-+*/%^()<>=!,.\\[\\]'\" a-z0-9_x§]{0,40}") {
        if let Ok(expression) = parse(&text) {
            let _ = expression.value(&[]);
        }
    }

    #[test]
    fn sums_and_products_are_those_of_rust(a in -1e3f64..1e3, b in -1e3f64..1e3, c in -1e3f64..1e3) {
        prop_assert_eq!(value(&format!("{a} + {b} * {c} - {a} / {b}")), a + b * c - a / b);
    }
}
