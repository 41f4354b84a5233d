//! The diagnostics of a device as described, checked.

use super::{KeyFunction, Number};
use crate::expression::Expression;
use crate::isotp::IsoTp;
use std::collections::BTreeMap;
use wire::time::Span;

#[derive(Debug, Clone)]
pub(crate) struct Diagnosis {
    pub(crate) isotp: IsoTp,
    pub(crate) p2: Span,
    pub(crate) p2_star: Span,
    pub(crate) s3: Span,
    /// Numbers of the sessions, the default session included.
    pub(crate) sessions: Vec<u8>,
    pub(crate) response_pending: bool,
    pub(crate) reset: Span,
    pub(crate) flow_control_delay: Expression,
    pub(crate) separation: Expression,
    /// Those that are supported.
    pub(crate) services: BTreeMap<u8, Service>,
    pub(crate) dids: BTreeMap<u16, Did>,
    /// By the sub-function that requests the seed.
    pub(crate) security: BTreeMap<u8, Security>,
    pub(crate) routines: BTreeMap<u16, Routine>,
    pub(crate) dtcs: Vec<Dtc>,
}

/// What a request needs.
#[derive(Debug, Clone, Default)]
pub(crate) struct Access {
    /// `None` for all.
    pub(crate) sessions: Option<Vec<u8>>,
    pub(crate) security: Option<u8>,
    pub(crate) when: Option<Expression>,
}

#[derive(Debug, Clone)]
pub(crate) struct Service {
    pub(crate) access: Access,
    pub(crate) delay: Expression,
}

#[derive(Debug, Clone)]
pub(crate) struct Did {
    pub(crate) content: Content,
    pub(crate) read: Access,
    pub(crate) write: Option<Access>,
    pub(crate) delay: Expression,
}

#[derive(Debug, Clone)]
pub(crate) enum Content {
    Fixed(Vec<u8>),
    Fields(Vec<Field>),
}

#[derive(Debug, Clone)]
pub(crate) struct Field {
    pub(crate) number: Number,
    pub(crate) value: Expression,
    pub(crate) set: Option<String>,
}

#[derive(Debug, Clone)]
pub(crate) struct Security {
    pub(crate) key: KeyFunction,
    pub(crate) seed_bytes: usize,
    pub(crate) key_bytes: usize,
    pub(crate) attempts: u32,
    pub(crate) delay: Span,
    pub(crate) access: Access,
}

#[derive(Debug, Clone)]
pub(crate) struct Routine {
    pub(crate) start: Vec<(String, Expression)>,
    pub(crate) stop: Option<Vec<(String, Expression)>>,
    pub(crate) results: Option<Vec<Field>>,
    pub(crate) access: Access,
    pub(crate) delay: Expression,
}

#[derive(Debug, Clone)]
pub(crate) struct Dtc {
    /// 24 bits.
    pub(crate) code: u32,
    pub(crate) failed: Expression,
    pub(crate) debounce: Span,
    pub(crate) warning: bool,
}
