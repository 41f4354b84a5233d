//! Notes on what was lost at the ports of a run, and whether the bench did what the plan says all the same.

use super::journal::Absence;
use super::role_port::Link;
use ports::Counters;
use record::figures::counted;
use record::outcome::PortSide;

/// What was lost at all ports.
#[derive(Debug, Default)]
pub(super) struct Losses {
    /// One sentence each.
    pub(super) notes: Vec<String>,
    /// Why the bench did not do what the plan says; `None` if it did.
    pub(super) why: Option<String>,
    /// Why nobody knows what the devices said, if nothing else explains the end.
    pub(super) unheard: Option<String>,
}

impl Losses {
    /// Adds those of one port. What a controller in this process does at its own ports is its own affair.
    pub(super) fn add(
        &mut self,
        (whose, side): (&str, PortSide),
        link: Link,
        counters: &Counters,
        absences: &[Absence],
    ) {
        let of_bench = side != PortSide::Controller;
        for absence in absences {
            let spoils = of_bench && absence.until.is_some() && !absence.is_expected;
            self.note(spoils, absence.told(whose, link));
        }
        let while_away: u64 = absences.iter().map(Absence::unsent).sum();
        let unsent = link.unsent(counters).saturating_sub(while_away);
        let what = link.counted(unsent);
        match link {
            Link::Pty => self.note_if(unsent, false, || {
                format!("lost at {whose}: {what}, as the other side had not read what came before")
            }),
            // Of a bus on which nobody acknowledges any more, the device may be the cause: an interface says so, and an adapter
            // reads on and refuses.
            _ => self.note_if(unsent, of_bench && matches!(link, Link::Serial | Link::Adapter), || {
                format!("lost at {whose}: {what} for which there was no room, though the record has them")
            }),
        }
        if link == Link::Adapter {
            let refused = counters.refused.min(counters.frames_out);
            self.note_if(refused, of_bench, || {
                let frames = counted(refused, "frame", "frames");
                format!(
                    "the adapter at {whose} refused {frames}: not on the bus, though the record has them"
                )
            });
            self.note_if(u64::from(counters.bytes_in == 0), of_bench, || {
                format!(
                    "the adapter at {whose} has never answered, not even when it was told to open its bus"
                )
            });
        }
        if counters.receive_dropped_frames > 0 {
            let frames = counted(counters.receive_dropped_frames, "frame", "frames");
            let note = format!("lost at {whose}: {frames} for which there was no time");
            if of_bench {
                self.unheard.get_or_insert_with(|| note.clone());
            }
            self.note(false, note);
        }
        for (count, (one, many), how) in [
            (counters.malformed_lines, ("line", "lines"), "that did not follow the SLCAN protocol"),
            (
                counters.unsupported_frames,
                ("frame", "frames"),
                "of a kind or a length that it does not carry",
            ),
            (counters.line_errors, ("byte", "bytes"), "with a framing or parity error"),
        ] {
            self.note_if(count, false, || {
                format!("lost at {whose}: {} {how}", counted(count, one, many))
            });
        }
    }

    /// Adds that nobody opened the pty at this path, at which these nodes were expected.
    pub(super) fn unopened(&mut self, path: &str, line: &str, nodes: &[&str]) {
        let were = match nodes.len() {
            // It is for whoever wants to look.
            0 => return,
            1 => "was",
            _ => "were",
        };
        let nodes: Vec<String> = nodes.iter().map(|node| format!("`{node}`")).collect();
        let who = nodes.join(" and ");
        self.note(
            false,
            format!("nobody opened {path}, the pty of {line}: {who} {were} expected there"),
        );
    }

    fn note_if(&mut self, count: u64, spoils: bool, note: impl FnOnce() -> String) {
        if count > 0 {
            self.note(spoils, note());
        }
    }

    fn note(&mut self, spoils: bool, note: String) {
        if spoils {
            self.why.get_or_insert_with(|| note.clone());
        }
        self.notes.push(note);
    }
}

#[cfg(test)]
mod tests {
    use super::{Absence, Counters, Link, Losses, PortSide};
    use wire::time::Timestamp;

    const AT: &str = "the can0's port slcan:/dev/ttyACM0";

    fn losses(side: PortSide, link: Link, counters: Counters, absences: &[Absence]) -> Losses {
        let mut losses = Losses::default();
        losses.add((AT, side), link, &counters, absences);
        losses
    }

    #[test]
    fn a_port_that_lost_nothing_has_no_note() {
        let counters =
            Counters { bytes_in: 9, frames_in: 4, frames_out: 2, breaks: 1, ..Counters::default() };
        for link in [Link::Pty, Link::EmulatedAdapter, Link::Serial, Link::Interface, Link::Adapter]
        {
            let Losses { notes, why, .. } = losses(PortSide::Bench, link, counters, &[]);
            assert_eq!((notes, why), (Vec::new(), None), "{link:?}");
        }
    }

    /// Found by a user: frames that an adapter refused were told by a counter alone.
    #[test]
    fn what_did_not_reach_a_real_device_is_the_fault_of_the_bench() {
        let counters = Counters { bytes_in: 9, frames_out: 5, refused: 2, ..Counters::default() };
        let Losses { notes, why, .. } = losses(PortSide::Bench, Link::Adapter, counters, &[]);
        insta::assert_snapshot!(why.unwrap(), @"the adapter at the can0's port slcan:/dev/ttyACM0 refused 2 frames: not on the bus, though the record has them");
        assert_eq!(notes.len(), 1);
        let Losses { notes, why, .. } = losses(PortSide::Controller, Link::Adapter, counters, &[]);
        assert_eq!((notes.len(), why), (1, None), "it is the controller that sent them");
        let counters = Counters { overrun_bytes: 1, overrun_frames: 3, ..Counters::default() };
        for (link, what, spoils) in [
            (Link::Serial, Some("1 byte"), true),
            (Link::Interface, Some("3 frames"), false),
            (Link::Pty, Some("1 byte"), false),
            (Link::EmulatedAdapter, None, false),
        ] {
            let Losses { notes, why, .. } = losses(PortSide::Bench, link, counters, &[]);
            let said = what.is_none_or(|what| notes[0].contains(what));
            assert!(said && notes.len() == what.iter().len(), "{link:?}: {notes:?}");
            assert_eq!(why.is_some(), spoils, "{link:?}: {notes:?}");
        }
    }

    /// Found by a user: the adapter had read nothing for five seconds, and the run passed.
    #[test]
    fn frames_that_an_adapter_had_no_room_for_are_the_fault_of_the_bench() {
        let counters =
            Counters { bytes_in: 9, frames_out: 5, overrun_frames: 3, ..Counters::default() };
        let Losses { notes, why, .. } = losses(PortSide::Bench, Link::Adapter, counters, &[]);
        assert!(
            why.is_some_and(|why| why.contains("3 frames for which there was no room")),
            "{notes:?}"
        );
    }

    #[test]
    fn an_adapter_that_says_nothing_is_dead() {
        let counters = Counters { bytes_out: 9, frames_out: 5, ..Counters::default() };
        let Losses { why, .. } = losses(PortSide::Bench, Link::Adapter, counters, &[]);
        assert!(why.unwrap().contains("has never answered"));
    }

    #[test]
    fn a_pty_that_nobody_opened_is_named_with_its_nodes() {
        let mut losses = Losses::default();
        losses.unopened("./can.pty", "can0", &["beat"]);
        losses.unopened("/dev/pts/4", "uart", &["a", "b"]);
        losses.unopened("/dev/pts/5", "body", &[]);
        assert_eq!(losses.why, None, "the bench did what the plan says");
        assert_eq!(
            losses.notes,
            [
                "nobody opened ./can.pty, the pty of can0: `beat` was expected there",
                "nobody opened /dev/pts/4, the pty of uart: `a` and `b` were expected there",
            ]
        );
    }

    #[test]
    fn what_came_in_and_was_lost_is_noted() {
        let counters = Counters {
            bytes_in: 9,
            malformed_lines: 9,
            receive_dropped_frames: 1,
            unsupported_frames: 2,
            line_errors: 3,
            ..Counters::default()
        };
        let Losses { notes, why, unheard } = losses(PortSide::Bench, Link::Adapter, counters, &[]);
        assert_eq!(why, None);
        // Found by a user: all frames that broke a property were among them, and the run passed.
        assert_eq!(unheard.as_ref(), notes.first());
        insta::assert_snapshot!(notes.join("\n"), @r"
        lost at the can0's port slcan:/dev/ttyACM0: 1 frame for which there was no time
        lost at the can0's port slcan:/dev/ttyACM0: 9 lines that did not follow the SLCAN protocol
        lost at the can0's port slcan:/dev/ttyACM0: 2 frames of a kind or a length that it does not carry
        lost at the can0's port slcan:/dev/ttyACM0: 3 bytes with a framing or parity error
        ");
    }

    #[test]
    fn an_absence_counts_unless_the_plan_asked_for_it() {
        let at = |ms: i64| Timestamp::from_nanos(ms * 1_000_000);
        let sent = |overrun_bytes| Counters { overrun_bytes, ..Counters::default() };
        let away = |until, is_expected| Absence {
            what: String::new(),
            from: (at(2_100), 4),
            until,
            is_expected,
        };
        let back = Some((at(3_300), 31));
        let unexpected = losses(PortSide::Bench, Link::Serial, sent(31), &[away(back, false)]);
        // The others found no room.
        assert_eq!(unexpected.notes.len(), 2);
        insta::assert_snapshot!(unexpected.why.unwrap(), @"the can0's port slcan:/dev/ttyACM0 was away from 2.100 s to 3.300 s; lost meanwhile, though the record has them: 27 bytes");
        let quiet = Some((at(3_300), 4));
        for (side, until, is_expected, spoils) in [
            (PortSide::Bench, quiet, false, true),
            (PortSide::Bench, quiet, true, false),
            (PortSide::Controller, quiet, false, false),
            (PortSide::Bench, None, false, false),
        ] {
            let away = [away(until, is_expected)];
            let Losses { notes, why, .. } = losses(side, Link::Serial, Counters::default(), &away);
            assert_eq!((notes.len(), why.is_some()), (1, spoils), "{notes:?}");
        }
    }
}
