//! Messages of a layout, as tables show them.

use described::Layout;

#[derive(Debug, Clone, PartialEq)]
pub struct SignalForm {
    pub name: String,
    /// Unit of its values; empty without a unit.
    pub unit: String,
    pub doc: String,
    /// Names of values, if the layout has any, by the values in its unit.
    pub names: Vec<(f64, String)>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct MessageForm {
    pub name: String,
    /// Its line, if nodes send messages of that name on several.
    pub line: Option<String>,
    pub doc: String,
    pub signals: Vec<SignalForm>,
}

impl MessageForm {
    /// Its name, behind its line where that tells it apart.
    pub fn full_name(&self) -> String {
        self.line.iter().chain([&self.name]).map(String::as_str).collect::<Vec<_>>().join(".")
    }
}

pub(super) fn forms(layout: &Layout) -> Vec<MessageForm> {
    let signal = |signal: &described::Signal| SignalForm {
        name: signal.name.clone(),
        unit: signal.unit.clone(),
        doc: signal.doc.clone(),
        names: signal.names().map(|(name, value)| (value, name.to_owned())).collect(),
    };
    let form = |message: &described::Message| MessageForm {
        name: message.name.clone(),
        line: None,
        doc: message.doc.clone(),
        signals: message.signals.iter().map(signal).collect(),
    };
    layout.messages().iter().map(form).collect()
}
