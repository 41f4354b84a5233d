//! Devices that their users describe without writing Rust.

mod description;
mod device;
mod error;
mod expression;
mod file;
mod hint;
mod layout;
mod place;

pub use description::Description;
pub use device::Device;
pub use error::DescriptionError;
pub use layout::{
    ByteOrder, Carried, Decoded, Decoder, EncodeError, Layout, Medium, Message, SIGNAL_BITS_MAX,
    Sender, Signal, SignalName, Wired,
};
