//! What terms act on.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a term acts on.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the contract's words")]
pub enum Acts {
    Bias,
    Scale,
    Delay,
    Clock,
    Axis,
    Saturation,
    Quantisation,
    DeadZone,
    Noise,
    Drive,
    Turn,
    Curvature,
    Slip,
    Reference,
}
