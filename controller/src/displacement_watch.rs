//! Checks whether the base's reported path is credible.
//!
//! The serial line's checksum is one byte: of misaligned answers, one in 256 passes and reads as an arbitrary path. A
//! path that no base could have driven is dropped like an answer with a bad checksum, unless the next one confirms it:
//! then the base restarted its count, for example after a reset. The longer the base was silent, the further it could
//! have driven: the first message after a time-out is not used either before the next one confirms it.
//!
//! On a bus, a message can be overtaken by younger ones. Its sequence number is behind theirs: what it says was true once.

use crate::config::BaseConfig;
use wire::base::Motion;
use wire::time::{Span, Timestamp};
use wire::units::{Length, Speed};

/// What the base said, and when it was heard.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Said {
    at: Timestamp,
    displacement: Length,
    sequence: u8,
    /// It was behind the last used one.
    late: bool,
}

impl Said {
    /// True if it was sent before `other`. In the longest silence that needs no confirmation, a base sends less than half
    /// a round of numbers. A base that does not number its messages is never late.
    const fn is_behind(&self, other: &Self) -> bool {
        matches!(other.sequence.wrapping_sub(self.sequence), 1..=127)
    }
}

/// Checks each motion message before it is used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DisplacementWatch {
    speed_max: Speed,
    /// A message may arrive this long after the motion that it reports. In motion, this is also the longest silence
    /// after which a single message suffices.
    late_max: Span,
    /// At rest, the longest silence after which a single message suffices.
    silence_max: Span,
    credible: Option<Said>,
    /// The last used message reported motion.
    moving: bool,
    doubtful: Option<Said>,
    /// The last message was believed only because it confirmed the previous one.
    anew: bool,
}

impl DisplacementWatch {
    pub(crate) const fn new(config: &BaseConfig) -> Self {
        Self {
            speed_max: config.speed_max,
            late_max: config.timeout_moving,
            silence_max: config.timeout_at_rest,
            credible: None,
            moving: false,
            doubtful: None,
            anew: false,
        }
    }

    /// True if a base could report this motion at `now`. A base that was `ordered` to move, and has not been heard to
    /// stand since, is one that moves.
    pub(crate) fn believes(
        &mut self,
        now: Timestamp,
        motion: &Motion,
        ordered: Option<Timestamp>,
    ) -> bool {
        let Motion { displacement, sequence, .. } = *motion;
        let mut said = Said { at: now, displacement, sequence, late: false };
        let moving = self.moving || ordered.is_some();
        let silence_max = if moving { self.late_max } else { self.silence_max };
        let in_time = self.credible.is_none_or(|Said { at, .. }| {
            now.since(ordered.map_or(at, |ordered| ordered.max(at))) <= silence_max
        });
        said.late = in_time && self.credible.is_some_and(|before| said.is_behind(&before));
        let follows =
            !said.late && self.credible.is_none_or(|before| self.could_follow(&before, &said));
        let confirms = self.doubtful.is_some_and(|before| {
            let again = before.late && before.sequence == sequence;
            !again && !said.is_behind(&before) && self.could_follow(&before, &said)
        });
        let believed = (follows && in_time) || confirms;
        self.anew = believed && !follows;
        if believed {
            self.credible = Some(said);
            self.moving = motion.moving;
            self.doubtful = None;
        } else {
            self.doubtful = Some(said);
        }
        believed
    }

    /// True if the base restarted its count at the last accepted message: the distance before it is unknown.
    pub(crate) const fn counts_anew(&self) -> bool {
        self.anew
    }

    fn could_follow(&self, before: &Said, said: &Said) -> bool {
        let path = (said.displacement - before.displacement).abs();
        path <= self.speed_max * ((said.at - before.at).max(Span::ZERO) + self.late_max)
    }
}

#[cfg(test)]
mod tests {
    use super::{DisplacementWatch, Length, Motion, Span, Speed, Timestamp};
    use crate::config::{BaseConfig, Transport};
    use proptest::prelude::*;
    use std::vec::Vec;

    const SPEED_MAX: f64 = 0.78;

    fn watch() -> DisplacementWatch {
        let speed_max = Speed::from_m_per_s(SPEED_MAX);
        DisplacementWatch::new(&BaseConfig { speed_max, ..BaseConfig::new(Transport::Serial) })
    }

    fn tell(watch: &mut DisplacementWatch, millis: i64, displacement_m: f64, moving: bool) -> bool {
        let displacement = Length::from_m(displacement_m);
        let motion = Motion { displacement, moving, ..Motion::default() };
        watch.believes(Timestamp::ZERO + Span::from_millis(millis), &motion, None)
    }

    fn believes(watch: &mut DisplacementWatch, millis: i64, displacement_m: f64) -> bool {
        tell(watch, millis, displacement_m, false)
    }

    #[test]
    fn one_jump_is_let_go_and_two_are_a_base_that_counts_anew() {
        let mut watch = watch();
        assert!(believes(&mut watch, 0, 3.0), "the first is all there is");
        assert!(!believes(&mut watch, 20, 251.8));
        assert!(believes(&mut watch, 40, 3.01), "as if it had not been");
        assert!(!believes(&mut watch, 60, -90.0));
        assert!(!believes(&mut watch, 80, 17.0), "another one does not bear it out");
        assert!(believes(&mut watch, 100, 3.02));
        assert!(!believes(&mut watch, 120, 0.0));
        assert!(!watch.counts_anew());
        assert!(believes(&mut watch, 140, 0.0) && watch.counts_anew());
        assert!(believes(&mut watch, 160, 0.01) && !watch.counts_anew());
    }

    /// Found by a campaign: a corrupted answer 1.8 s after the last one read as a path of 1.6 m.
    #[test]
    fn after_a_silence_one_message_is_not_enough() {
        let mut watch = watch();
        assert!(tell(&mut watch, 0, 1.0, true));
        assert!(!tell(&mut watch, 1800, 2.2, true));
        assert!(!tell(&mut watch, 1820, 1.04, false), "it does not confirm the one before");
        assert!(tell(&mut watch, 1840, 1.04, false) && !watch.counts_anew());
        // At rest, messages may be further apart.
        assert!(tell(&mut watch, 3400, 1.04, false));
    }

    #[test]
    fn after_an_order_to_move_one_that_may_be_from_before_it_is_not_enough() {
        let mut watch = watch();
        let order = Some(Timestamp::ZERO + Span::from_millis(400));
        let mut tell = |millis, moving| {
            let motion = Motion { moving, ..Motion::default() };
            watch.believes(Timestamp::ZERO + Span::from_millis(millis), &motion, order)
        };
        assert!(tell(0, false) && tell(420, true), "the base has begun to move");
        assert!(!tell(700, false) && tell(720, true));
    }

    /// Whether each message of a moving base, 20 ms apart, is believed: its number and path in metres.
    fn believed(arrivals: &[(u8, f64)]) -> Vec<bool> {
        let mut watch = watch();
        let said = |(number, &(sequence, displacement_m)): (usize, &(u8, f64))| {
            let displacement = Length::from_m(displacement_m);
            let motion = Motion { displacement, sequence, moving: true, ..Motion::default() };
            let at = Timestamp::ZERO + Span::from_millis(20 * number as i64);
            watch.believes(at, &motion, None)
        };
        arrivals.iter().enumerate().map(said).collect()
    }

    #[test]
    fn what_younger_messages_have_overtaken_is_not_used() {
        let late = [(254, 0.1), (0, 0.12), (255, 0.11), (1, 0.13), (255, 0.11), (2, 0.14)];
        assert_eq!(believed(&late), [true, true, false, true, false, true]);
        let doubled = [(7, 0.1), (9, 0.12), (8, 0.11), (8, 0.11), (10, 0.13)];
        assert_eq!(believed(&doubled), [true, true, false, false, true]);
    }

    #[test]
    fn a_base_that_starts_again_is_believed_from_its_second_message() {
        assert_eq!(believed(&[(90, 0.1), (0, 0.0), (1, 0.0), (2, 0.0)]), [true, false, true, true]);
    }

    #[test]
    fn a_base_that_does_not_number_its_messages_is_never_late() {
        assert_eq!(believed(&[(0, 0.1), (0, 0.11), (0, 0.12)]), [true; 3]);
    }

    proptest! {
        #[test]
        fn a_base_within_its_speed_is_believed_whatever_the_delays(
            steps in prop::collection::vec((1i64..500, -SPEED_MAX..SPEED_MAX, 0i64..250), 1..100),
        ) {
            let mut watch = watch();
            let (mut at, mut arrived, mut displacement) = (0, 0, 0.0);
            for (millis, speed, late) in steps {
                at += millis;
                displacement += speed * millis as f64 * 1e-3;
                arrived = arrived.max(at + late);
                prop_assert!(believes(&mut watch, arrived, displacement));
            }
        }
    }
}
