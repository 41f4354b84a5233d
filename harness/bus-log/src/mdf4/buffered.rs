//! The bytes of a chain of blocks, in a reused buffer.

use super::super::error::LogError;
use super::super::window::Window;
use super::blocks::Source;
use super::chain::Chain;

/// A chain, and what is read of it and not taken yet.
#[derive(Debug)]
pub(super) struct Buffered {
    chain: Chain,
    window: Window,
}

impl Buffered {
    pub(super) fn new(chain: Chain) -> Self {
        Self { chain, window: Window::new() }
    }

    pub(super) const fn began(&self) -> u64 {
        self.chain.began()
    }

    pub(super) fn bytes(&self) -> &[u8] {
        self.window.bytes()
    }

    /// Fills the buffer to `count` bytes; returns whether it now holds them.
    pub(super) fn has(&mut self, count: usize, source: &mut Source<'_>) -> Result<bool, LogError> {
        self.window.has(count, |out| self.chain.read(source, out))
    }

    /// Takes `count` bytes; `false` if there are fewer.
    pub(super) fn skip(&mut self, count: u64, source: &mut Source<'_>) -> Result<bool, LogError> {
        self.window.skip(count, |out| self.chain.read(source, out))
    }

    /// The number in the first `bytes` bytes of the buffer.
    pub(super) fn number(&self, bytes: usize) -> u64 {
        let bytes = self.bytes().iter().take(bytes);
        bytes.rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
    }
}
