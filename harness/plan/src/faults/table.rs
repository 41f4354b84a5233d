//! The vocabulary as a table, for `docs/faults.md` and the output of `hil list faults`.

use super::{FaultKind, KindInfo, KindParameter, Lasts, Reach, Share};

/// The text above the table in `docs/faults.md`.
const INTRODUCTION: &str = "\
# Faults

What can go wrong on purpose, in a plan:

```toml
[[fault]]
target = \"gyro\"                                  # gyro, base, table, host or operator
toward = \"host\"                                  # of a line: host (what the device sends) or device; both without
what = { burst_loss = { loss_percent = 1, recover_percent = 10, bad_percent = 100, good_percent = 0 } }
when = { step = \"lap\", number = 3, after_s = 2 } # or { at_s = 300 } or { during = \"turn\", number = 3 }
duration_s = 2                                   # without: `during` to the end of the phase, others of the run
probability = 0.3                                # that it happens at all, drawn from the seed
```

A fault of a line acts in a layer of that line, and a fault of a device is a switch in its emulator. The controller knows of
neither.

On a rig, a target is the name of a node or a line, or a message or signal of a node: `cells.CellStatus` is a message,
`cells.VoltageMax` a signal. The kinds for messages strike a message. On CAN, those for lines (`drop`, `delay`, `duplicate`
...) can strike a single message, too, and leave everything else alone. On a serial line, a fault strikes a message only if
it arrives as a whole. The frames of [diagnostics](uds.md#faults) are messages, too. The checksum of a struck message is
recalculated, unless the fault strikes the checksum itself.

A step is named by its key or its label, and each round of a labelled repeat counts. Turns, straights and bias tests are counted
by the commands to the controller: a lap holds four turns. If the column *lasts* names a parameter of the kind, or an instant,
leave `duration_s` out. The first parameter is the severity, which `FaultKind::with_severity` and campaigns scale. Its sign, if it
has one, is the direction.

Two kinds that set the same switch, such as `stuck` and `restart` of a gyro, must not be active at the same time. `hil` refuses
the plan, unless the order and the times of its phases show that they never are.

The host is the machine of everything under test: the controller, and the [programs](virtual-time.md) of a rig. In virtual time
its faults are exact for both. A program that was not scheduled finds, at the end of the fault, all data that has arrived at each
of its ports. A stall ends with the steps of the plan at the latest: while the run is torn down, only the controller can say that
the base stands.

In real time (`hil run --clock real`), the same faults strike emulated devices, and the lines up to their ports. Faults of the
host need the controller in the process. A fault of a real device, or of the machine of another process, is refused before the
run, with status 2.

The table is generated from the program (`hil list faults` prints the same), and a test keeps it up to date.
";

/// Describes the possible targets of a kind.
pub fn strikes(info: &'static KindInfo) -> &'static str {
    match info.reach {
        Reach::Line => "a serial line or bus",
        Reach::SerialLine => "a serial line",
        Reach::CanBus => "a CAN bus",
        Reach::Message(Share::Whole) => "a message",
        Reach::Message(Share::Counter) => "a counter",
        Reach::Message(Share::Checksum) => "a checksum",
        Reach::Message(Share::Signal) => "a signal",
        Reach::Only(ref target) => target.name(),
    }
}

/// Describes the duration of a kind.
pub fn lasts(info: &KindInfo) -> String {
    match (info.lasts, info.parameters.first()) {
        (Lasts::Scheduled, _) => "as scheduled".to_owned(),
        (Lasts::Itself, Some(first)) => format!("its {}", first.name),
        _ => "an instant".to_owned(),
    }
}

/// A parameter with its range and its typical value: `loss_percent = 1 (0 to 100 %)`.
pub fn parameter(parameter: &KindParameter, typical: f64) -> String {
    let (least, greatest) = parameter.range;
    let unit = if parameter.unit == "1" { String::new() } else { format!(" {}", parameter.unit) };
    format!("{} = {typical} ({least} to {greatest}{unit})", parameter.name)
}

/// The complete text of `docs/faults.md`.
pub fn markdown() -> String {
    let mut text = INTRODUCTION.to_owned();
    text.push_str(
        "\n| kind | strikes | lasts | what it does | parameters, typical (range) | source |\n",
    );
    text.push_str("|---|---|---|---|---|---|\n");
    for info in FaultKind::all() {
        let parameters: Vec<String> = info
            .parameters
            .iter()
            .zip(info.typical.values())
            .map(|(one, typical)| format!("`{}`: {}", parameter(one, typical), one.doc.trim()))
            .collect();
        text.push_str(&format!(
            "| `{}` | {} | {} | {} | {} | {} |\n",
            info.name,
            strikes(info),
            lasts(info),
            info.doc.trim(),
            parameters.join("<br>"),
            info.source
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::markdown;

    /// If the document differs, the new text is written to `docs/faults.md.new`.
    #[test]
    fn the_document_is_the_vocabulary() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/faults.md");
        let written = std::fs::read_to_string(path).unwrap_or_default();
        if written != markdown() {
            std::fs::write(format!("{path}.new"), markdown()).unwrap();
            panic!("docs/faults.md is not the vocabulary: mv docs/faults.md.new docs/faults.md");
        }
    }
}
