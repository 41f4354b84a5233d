//! What messages look like, whoever sends them.

/// A signal of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SignalForm {
    /// Its name in the layout.
    pub name: String,
    /// Unit of its values; empty where it has none.
    pub unit: String,
    /// What it is.
    pub doc: String,
}

/// A message of a layout.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MessageForm {
    /// Its name in the layout.
    pub name: String,
    /// What it is.
    pub doc: String,
    /// Its signals.
    pub signals: Vec<SignalForm>,
}
