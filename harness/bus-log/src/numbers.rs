//! Numbers of channels, for formats that have no names.

use super::entry::Channel;

/// Channels of one file; frames of more are left out. Assumption: as many as a mask of 32 bits names, as
/// in Vector's driver; the logs of one bench have a few.
pub const CHANNELS_MAX: usize = 32;

/// Which channel has which number, from 1: `canN` gets N + 1 where it is free, any other name the lowest
/// that is free.
#[derive(Debug)]
pub(super) struct Numbers {
    /// By number less one; as many places as there may be channels.
    channels: Vec<Option<Channel>>,
}

impl Numbers {
    /// Numbers up to `most`.
    pub(super) fn up_to(most: usize) -> Self {
        Self { channels: vec![None; most] }
    }

    /// The number of a channel; `None` where there are too many.
    pub(super) fn of(&mut self, channel: Channel) -> Option<usize> {
        if let Some(known) = self.channels.iter().position(|known| *known == Some(channel)) {
            return Some(known + 1);
        }
        let own = channel.as_str().strip_prefix("can").and_then(|number| number.parse().ok());
        let free = |index: &usize| self.channels.get(*index).is_some_and(Option::is_none);
        let index = own.filter(free).or_else(|| (0..self.channels.len()).find(free))?;
        self.channels[index] = Some(channel);
        Some(index + 1)
    }
}

/// The channel of a number from 1: number 1 is `can0`.
pub(super) fn channel(number: u32) -> Option<Channel> {
    Some(Channel::numbered(number.checked_sub(1)?))
}
