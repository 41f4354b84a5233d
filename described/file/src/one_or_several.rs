//! Values of which a file has one or several.

use schemars::JsonSchema;
use serde::Deserialize;

/// One, or an array of several.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a name or an array of names")]
#[schemars(inline)]
pub enum OneOrSeveral<T> {
    /// One.
    One(T),
    /// Several.
    Several(Vec<T>),
}

impl<T> OneOrSeveral<T> {
    /// All values.
    pub fn as_slice(&self) -> &[T] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::Several(several) => several,
        }
    }
}
