//! Channel numbers, for formats without names.

use super::entry::Channel;

/// Most channels of one file; frames of further ones are left out. Assumption: as many as a 32-bit mask can name, as in
/// Vector's driver; the logs of one bench have a few.
pub const CHANNELS_MAX: usize = 32;

/// Assigns numbers from 1 to channels: `canN` gets N + 1 if that is free, any other name the lowest free number.
#[derive(Debug)]
pub(super) struct Numbers {
    /// By number minus one; the length limits the number of channels.
    channels: Vec<Option<Channel>>,
}

impl Numbers {
    /// Numbers up to `most`.
    pub(super) fn up_to(most: usize) -> Self {
        Self { channels: vec![None; most] }
    }

    /// The number of a channel, and whether it is the channel's first entry; `None` if there are too many.
    pub(super) fn of(&mut self, channel: Channel) -> Option<(usize, bool)> {
        if let Some(known) = self.channels.iter().position(|known| *known == Some(channel)) {
            return Some((known + 1, false));
        }
        let own = channel.as_str().strip_prefix("can").and_then(|number| number.parse().ok());
        let free = |index: &usize| self.channels.get(*index).is_some_and(Option::is_none);
        let index = own.filter(free).or_else(|| (0..self.channels.len()).find(free))?;
        self.channels[index] = Some(channel);
        Some((index + 1, true))
    }

    /// The channels that have numbers.
    pub(super) fn named(&self) -> Vec<(usize, Channel)> {
        let all = self.channels.iter().zip(1..);
        all.filter_map(|(channel, number)| Some((number, (*channel)?))).collect()
    }
}

/// The channel of a number from 1: number 1 is `can0`.
pub(super) fn channel(number: u32) -> Option<Channel> {
    Some(Channel::numbered(number.checked_sub(1)?))
}
