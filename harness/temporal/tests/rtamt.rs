//! RTAMT (D. Nickovic, T. Yamaguchi, 2020) as the reference: it computes the same robustness on random formulas and
//! traces.
//!
//! RTAMT evaluates offline in discrete time, one sample per step. Here a step is a nanosecond, and, if no operator of
//! the formula lasts a nanosecond, a millisecond as well. Only samples whose whole horizon is within the trace are
//! compared: after its end RTAMT assumes the neutral infinity, and this crate unknown. RTAMT has no `changes` and less
//! arithmetic (see `form.rs`). It gives only a robustness and no separate truth: where it is zero, only the robustness is
//! compared.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use common::LETTERS;
use common::form::{Form, form};
use common::trace::{Trace, online, parsed, rows, trace};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use temporal::Truth;

const TRACES: usize = 60;
const FORMULAS: usize = 3_000;
const MILLISECOND: i64 = 1_000_000;

fn interop() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/interop")
}

fn python() -> OsString {
    std::env::var_os("HIL_TESTS_PYTHON").unwrap_or_else(|| "python3".into())
}

fn is_there() -> bool {
    let loaded = Command::new(python()).args(["-c", "import rtamt"]).output();
    if loaded.is_ok_and(|loaded| loaded.status.success()) {
        return true;
    }
    let why = format!("{} has no rtamt", python().to_string_lossy());
    let how = "tests/interop/README.md says how to install it";
    skips::skip_unless("HIL_TESTS_NEED_PYTHON", why, how);
    false
}

/// RTAMT's robustness of each formula at each sample.
fn ask(asked: &Value) -> Vec<Vec<f64>> {
    let mut child = Command::new(python())
        .arg(interop().join("rtamt_robustness.py"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(asked.to_string().as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "RTAMT refuses");
    let answers: Vec<Vec<Value>> = serde_json::from_slice(&output.stdout).unwrap();
    let number = |value: &Value| match value.as_str() {
        Some(infinity) => infinity.parse().unwrap(),
        None => value.as_f64().unwrap(),
    };
    answers.iter().map(|answer| answer.iter().map(number).collect()).collect()
}

/// Number of moments compared, and of those with a non-zero robustness.
fn compare(form: &Form, truths: &[Truth], theirs: &[f64]) -> (usize, usize) {
    let end = truths.len() - form.horizon() as usize;
    let mut decided = 0;
    for at in 0..end {
        let (ours, theirs) = (truths[at], theirs[at]);
        let place = format!("{} at {at}: {ours:?}, RTAMT {theirs}", form.text(1));
        let robustness = ours.robustness().unwrap_or_else(|| panic!("{place}"));
        let is_same = robustness == theirs || (robustness - theirs).abs() <= 1e-9;
        assert!(is_same, "{place}");
        if theirs != 0.0 {
            assert_eq!(ours.holds(), Some(theirs > 0.0), "{place}");
            decided += 1;
        }
    }
    (end, decided)
}

#[test]
fn robustness_is_that_of_rtamt() {
    if !is_there() {
        return;
    }
    let mut runner = TestRunner::deterministic();
    let strategy = trace(60..61, false);
    let traces: Vec<Trace> =
        (0..TRACES).map(|_| strategy.new_tree(&mut runner).unwrap().current()).collect();
    let strategy = form();
    let mut forms = Vec::new();
    while forms.len() < FORMULAS {
        let form = strategy.new_tree(&mut runner).unwrap().current();
        if let Some(text) = form.rtamt() {
            forms.push((form, text));
        }
    }
    let columns = |trace: &Trace| {
        let rows = rows(trace, 0);
        let column = |signal: usize| rows.iter().map(|row| row[signal]).collect::<Vec<_>>();
        json!(BTreeMap::from_iter((0..3).map(|signal| (LETTERS[signal], column(signal)))))
    };
    let formulas = forms.iter().enumerate();
    let formulas: Vec<_> =
        formulas.map(|(index, (_, text))| json!({"text": text, "trace": index % TRACES})).collect();
    let traces_said: Vec<_> = traces.iter().map(columns).collect();
    let answers = ask(&json!({"traces": traces_said, "formulas": formulas}));
    assert_eq!(answers.len(), forms.len());

    let (mut moments, mut decided, mut coarse) = (0, 0, 0);
    let mut seen = BTreeMap::<_, usize>::new();
    for (index, ((form, _), theirs)) in forms.iter().zip(&answers).enumerate() {
        let trace = &traces[index % TRACES];
        let mut operators = Vec::new();
        form.operators(&mut operators);
        operators.into_iter().for_each(|name| *seen.entry(name).or_default() += 1);
        let steps = if form.is_coarse() { &[1, MILLISECOND][..] } else { &[1] };
        for step in steps {
            let truths = online(&parsed(form, *step), trace, *step);
            let compared = compare(form, &truths, theirs);
            moments += compared.0;
            decided += compared.1;
        }
        coarse += usize::from(form.is_coarse());
    }
    println!(
        "{FORMULAS} formulas, {coarse} of them in milliseconds too; {moments} moments, {decided} decided: {seen:?}"
    );
    assert!(coarse > 500 && decided > 50_000, "{coarse} {decided}");
    // Every operator that both support occurred.
    assert!(seen.len() == 25 && seen.values().all(|count| *count >= 50), "{seen:?}");
}
