//! Why data cannot be identified.

/// Why a data set cannot be identified.
#[derive(Debug, thiserror::Error)]
pub enum IdentifyError {
    /// The data lack what the kind needs.
    #[error("{0}")]
    Data(String),
    /// The model does not fit the data.
    #[error("{0}")]
    Model(String),
}

impl IdentifyError {
    /// The data have no `what`.
    pub(crate) fn missing(what: &str) -> Self {
        Self::Data(format!("no {what}"))
    }
}
