//! Detects whether nodes unrelated to the run flood the bus of the base.

use wire::can::BIT_RATE;
use wire::can::CanFrame;
use wire::time::{Span, Timestamp};

/// Window for the load.
const WINDOW: Span = Span::from_secs(1);
/// Share of the bus for other nodes; beyond it the bus is flooded. Assumption: a bus is planned for at most half its
/// capacity, its own nodes included. A virtual bus has no pacing and takes far more than full load.
pub(super) const LOAD_MAX: f64 = 0.5;
/// A run that breaks off within this time after a flood breaks off because of it. Assumption: a controller gives up
/// within a few seconds of silence, and stopping takes two.
const AFTERMATH: Span = Span::from_secs(10);

#[derive(Debug, Default)]
pub(super) struct FloodWatch {
    frames: u64,
    window: Option<Window>,
    /// Largest share of the bus in any window, and time of the last flooded window.
    load_max: f64,
    flooded: Option<Timestamp>,
}

#[derive(Debug, Clone, Copy)]
struct Window {
    began: Timestamp,
    bits: i64,
}

impl FloodWatch {
    pub(super) fn take(&mut self, now: Timestamp, frame: &CanFrame) {
        self.frames += 1;
        let window = self.window.get_or_insert(Window { began: now, bits: 0 });
        window.bits += i64::from(frame.bits());
        let window = *window;
        self.look(now, window);
        if now - window.began >= WINDOW {
            self.window = None;
        }
    }

    /// A window cut short by a busy machine counts as a whole one: its frames have crossed.
    fn look(&mut self, now: Timestamp, window: Window) {
        let lasted = (now - window.began).max(WINDOW);
        let load = window.bits as f64 / BIT_RATE as f64 / lasted.as_secs_f64();
        self.load_max = self.load_max.max(load);
        if load > LOAD_MAX {
            self.flooded = Some(now);
        }
    }

    /// Number of frames of other nodes.
    pub(super) const fn frames(&self) -> u64 {
        self.frames
    }

    /// A message that blames a flood of `port` for a run that broke off at `end`; `None` if there was no flood.
    pub(super) fn verdict(&self, end: Timestamp, port: &str) -> Option<String> {
        let recent = self.flooded.is_some_and(|at| end - at <= AFTERMATH);
        recent.then(|| {
            format!(
                "{port} was flooded: {} frames of other nodes, in one second up to {:.0} % of what a bus \
                 of {} kbit/s carries",
                self.frames,
                self.load_max * 100.0,
                BIT_RATE / 1_000,
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{AFTERMATH, FloodWatch, Span, Timestamp};
    use wire::can::{CanFrame, Id, StandardId};

    /// Frames of 8 bytes, 111 bits each, evenly over two seconds.
    fn watched(frames_per_s: i64) -> FloodWatch {
        let id = Id::Standard(StandardId::new(0x2aa).unwrap());
        let frame = CanFrame::new(id, &[0x55; 8]).unwrap();
        let mut watch = FloodWatch::default();
        for index in 0..2 * frames_per_s {
            let at = Timestamp::from_nanos(index * 1_000_000_000 / frames_per_s);
            watch.take(at, &frame);
        }
        watch
    }

    #[test]
    fn a_busy_bus_is_no_flood() {
        let watch = watched(2_200);
        assert_eq!((watch.frames(), watch.verdict(Timestamp::ZERO, "can:can0")), (4_400, None));
    }

    #[test]
    fn a_flood_is_named_for_a_while() {
        let watch = watched(9_000);
        let end = Timestamp::ZERO + Span::from_secs(2);
        insta::assert_snapshot!(
            watch.verdict(end, "can:vcan0").unwrap(),
            @"can:vcan0 was flooded: 18000 frames of other nodes, in one second up to 200 % of what a bus of 500 kbit/s carries"
        );
        assert_eq!(watch.verdict(end + AFTERMATH, "can:vcan0"), None);
    }
}
