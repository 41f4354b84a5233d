//! Why data cannot be identified.

/// Why a data set cannot be identified: the data lack what the kind needs, or the model does not fit them.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct IdentifyError(pub(crate) String);

impl IdentifyError {
    /// The data have no `what`.
    pub(crate) fn missing(what: &str) -> Self {
        Self(format!("no {what}"))
    }
}
