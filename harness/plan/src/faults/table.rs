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
    use crate::documents::assert_tables;

    #[test]
    fn the_document_is_the_vocabulary() {
        let columns =
            ["kind", "strikes", "lasts", "what it does", "parameters, typical (range)", "source"];
        let rows = FaultKind::all().iter().map(|info| {
            let parameters: Vec<String> = info
                .parameters
                .iter()
                .zip(info.typical.values())
                .map(|(one, typical)| format!("`{}`: {}", parameter(one, typical), one.doc.trim()))
                .collect();
            vec![
                format!("`{}`", info.name),
                strikes(info).to_owned(),
                lasts(info),
                info.doc.trim().to_owned(),
                parameters.join("<br>"),
                info.source.to_owned(),
            ]
        });
        assert_tables("faults.md", &[(&columns, rows.collect())]);
    }
}
