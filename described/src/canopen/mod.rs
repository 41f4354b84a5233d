//! CANopen devices (CiA 301): an object dictionary from an EDS, and the services that a device has by it.
//!
//! Everything here is free of IO, and time is an argument. A [`Node`] is the protocol of an emulated device: it reads
//! the values of its objects from the [`Application`], and writes to it what masters write. A [`SdoClient`] is the other
//! end of SDO transfers, for plans.

mod abort;
mod client;
mod device_file;
mod dictionary;
mod eds;
mod emergency;
mod layout;
mod nmt;
mod node;
mod objects;
mod pdo;
mod sdo;
#[cfg(test)]
mod tests;

pub use abort::Abort;
pub use client::{Progress, SdoClient};
pub(crate) use device_file::{held, layout, unused};
pub use dictionary::{Dictionary, Entry};
pub(crate) use layout::NODE;
pub use layout::{SDO_REQUEST, SDO_RESPONSE};
pub(crate) use node::{Heard, Node};
pub(crate) use objects::Application;
