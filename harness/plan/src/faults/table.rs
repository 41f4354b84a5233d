//! The vocabulary as a table: the columns of `docs/faults.md` and of `hil list faults`.

use super::{KindInfo, KindParameter, Lasts, Reach, Share};

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
        Reach::Powered => "a device's supply",
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

#[cfg(test)]
mod tests {
    use super::super::FaultKind;
    use super::{lasts, parameter, strikes};

    /// If the table in the document differs, the new text is written to `docs/faults.md.new`.
    #[test]
    fn the_document_is_the_vocabulary() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/faults.md");
        let written = std::fs::read_to_string(path).unwrap();
        let (introduction, _) = written.split_once("\n| kind |").expect("a table");
        let mut text = introduction.to_owned();
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
        if written != text {
            std::fs::write(format!("{path}.new"), text).unwrap();
            panic!("docs/faults.md is not the vocabulary: mv docs/faults.md.new docs/faults.md");
        }
    }
}
