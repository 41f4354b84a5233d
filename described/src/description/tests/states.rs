//! Mistakes in machines, arrays, tables and answers.

use super::refused;

const BASE: &str = r#"
name = "d"
[parameter.ambient]
value = 20
[parameter."gain[1..3]"]
value = 1
[table.ocv]
x = [0, 0.5, 1]
y = [3.0, 3.6, 4.2]
[table.map]
x = [0, 1]
y = [0, 10]
z = [[1, 2], [3, 8]]
[state."cell[1..3]"]
value = "ocv(gain[i] / 2)"
[state.heat]
rate = "ambient - heat"
[state.count]
[machine.mode]
states = ["Off", "On", "Fault"]
start = "Off"
transitions = [
  { from = "Off", to = "On", on = "Go" },
  { from = ["On"], to = "Fault", when = "heat > 30" },
  { to = "Off", after_s = 2, set = { heat = 20 } },
]
enter.Fault = { count = "count + 1" }
[signal."V[1..2]"]
expression = "cell[i]"
[signal.Mode]
in.mode = { Off = 0, On = "heat" }
expression = 9
[[message]]
name = "Status"
sent_by = "device"
can_id = 1
period_s = 1
fields = [
  { name = "V1", type = "u8" }, { name = "V2", type = "u8" }, { name = "Mode", type = "u8" },
]
[[message]]
name = "Answer"
sent_by = "device"
can_id = 2
answers = "Go"
times = 2
every_s = 0.1
[[message]]
name = "Busy"
sent_by = "device"
can_id = 3
answers = "Go"
busy = true
[[message]]
name = "Go"
sent_by = "host"
can_id = 4
while_answering = "queue"
queue = 4
"#;

fn changed(changes: &[(&str, &str)]) -> String {
    let show = |(from, to): &(&str, &str)| {
        assert_eq!(BASE.matches(from).count(), 1, "{from}");
        format!("{from}  ->  {to}\n{}\n", refused(&BASE.replace(from, to)))
    };
    changes.iter().map(show).collect()
}

#[test]
fn wrong_machines() {
    insta::assert_snapshot!(changed(&[
        ("start = \"Off\"", "start = \"Of\""),
        ("\"Fault\"]", "\"On\"]"),
        ("\"Fault\"]", "\"Fault\", \"Lost\"]"),
        ("states = [\"Off\", \"On\", \"Fault\"]", "states = []"),
        ("from = [\"On\"]", "from = [\"Onn\"]"),
        ("from = [\"On\"]", "from = []"),
        ("{ to = \"Off\", after_s = 2", "{ to = \"Of\", after_s = 2"),
        (", on = \"Go\"", ""),
        ("on = \"Go\"", "on = \"Status\""),
        ("heat > 30", "heat > 30 and mode == 'Onn'"),
        ("heat > 30", "ambient == 'On'"),
        ("when = \"heat > 30\"", "when = \"1 > 2\""),
        ("after_s = 2", "after_s = 0"),
        ("set = { heat", "set = { ambient"),
        ("set = { heat", "set = { cell1"),
        ("enter.Fault", "enter.Fualt"),
        ("{ count = ", "{ coutn = "),
        ("[machine.mode]", "[machine.heat]"),
        ("in.mode = { Off", "in.mode = { Offf"),
        ("in.mode", "in.modus"),
        ("expression = 9\n", ""),
        ("expression = 9\n", "steps = [[0, 1]]\n"),
    ]));
}

#[test]
fn wrong_arrays() {
    insta::assert_snapshot!(changed(&[
        ("\"cell[1..3]\"", "\"cell[3..1]\""),
        ("\"cell[1..3]\"", "\"cell[1-3]\""),
        ("\"cell[1..3]\"", "\"cell[1..4]\""),
        ("\"cell[1..3]\"", "\"gain[4..6]\""),
        ("[state.heat]", "[state.cell2]\nvalue = 1\n[state.heat]"),
        ("parameter.ambient", "parameter.i"),
        ("ocv(gain[i] / 2)", "ocv(gain / 2)"),
        ("ocv(gain[i] / 2)", "ocv(gain[i + 1])"),
        ("ocv(gain[i] / 2)", "cell[i]"),
        ("ocv(gain[i] / 2)", "max(cell)"),
        ("ocv(gain[i] / 2)", "sum(ambient)"),
        ("heat > 30", "cell[i] > 30"),
        ("\"V[1..2]\"", "\"V[1..3]\""),
        ("[signal.Mode]", "[signal.V2]\nexpression = 1\n[signal.Mode]"),
    ]));
}

#[test]
fn wrong_tables() {
    insta::assert_snapshot!(changed(&[
        ("x = [0, 0.5, 1]", "x = [0, 1, 0.5]"),
        ("x = [0, 0.5, 1]", "x = [0, 0.5]"),
        ("y = [3.0, 3.6, 4.2]", "y = [3.0, 3.6, nan]"),
        ("x = [0, 0.5, 1]\ny = [3.0, 3.6, 4.2]", "x = [0]\ny = [1]"),
        ("x = [0, 0.5, 1]\n", ""),
        ("x = [0, 0.5, 1]\ny = [3.0, 3.6, 4.2]", "csv = \"trace.csv\""),
        ("x = [0, 0.5, 1]\ny = [3.0, 3.6, 4.2]", "csv = \"back.csv\""),
        ("z = [[1, 2], [3, 8]]", "z = [[1, 2], [3]]"),
        ("z = [[1, 2], [3, 8]]", "z = [[1, 2]]"),
        ("y = [0, 10]", "y = [10, 0]"),
        ("[table.map]", "[table.sum]"),
        ("[table.map]", "[table.heat]"),
        ("ocv(gain[i] / 2)", "map(gain[i] / 2)"),
        ("ocv(gain[i] / 2)", "ocv"),
    ]));
}

#[test]
fn wrong_answers() {
    insta::assert_snapshot!(changed(&[
        ("times = 2", "times = 0"),
        ("times = 2\n", ""),
        ("every_s = 0.1\n", ""),
        ("answers = \"Go\"\ntimes", "times"),
        ("answers = \"Go\"\ntimes = 2\nevery_s = 0.1", "period_s = 1"),
        ("while_answering = \"queue\"\nqueue = 4\n", ""),
        ("queue = 4", "queue = 0"),
        ("\"queue\"", "\"refuse\""),
        ("busy = true", "queue = 4"),
        ("while_answering = \"queue\"", "busy = true\nwhile_answering = \"queue\""),
        ("expression = 9", "expression = \"part\""),
    ]));
}
