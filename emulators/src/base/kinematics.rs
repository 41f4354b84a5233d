//! Motion in phases between commands and ramp ends.
//!
//! Within a phase both rates are single ramps, so that odometers have a closed form, and the place on
//! the floor has one as well unless the base steers while it drives. Then pieces of [`PIECE_S`] are
//! integrated, counted from the start of the phase. Whoever asks where the base is, and how often,
//! changes nothing.

use super::ramp::Ramp;
use super::track::{PIECE_NS, PIECE_S, Track, TrackModel};
use wire::time::Timestamp;

/// Odometers and places at one instant; SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct State {
    /// Path by the odometer.
    pub(super) displacement: f64,
    /// Steering angle by the odometer, unwrapped.
    pub(super) steered: f64,
    /// Where the base is.
    pub(super) truth: Track,
    /// Where it believes to be; the body's heading stands for the heading at the last pose write.
    pub(super) reckoned: Track,
}

#[derive(Debug)]
pub(super) struct Kinematics {
    model: TrackModel,
    /// The same for the phase.
    phase_model: TrackModel,
    phase_start: Timestamp,
    drive: Ramp,
    steer: Ramp,
    at_start: State,
    /// Pieces of the phase that are already integrated, and where they led.
    pieces: i64,
    at_piece: State,
}

impl Kinematics {
    pub(super) fn new(model: TrackModel) -> Self {
        Self {
            model,
            phase_model: model,
            phase_start: Timestamp::ZERO,
            drive: Ramp::default(),
            steer: Ramp::default(),
            at_start: State::default(),
            pieces: 0,
            at_piece: State::default(),
        }
    }

    /// How the odometers' rates become motion in this phase.
    pub(super) const fn model_now(&self) -> &TrackModel {
        &self.phase_model
    }

    /// Acceleration of the drive in this phase, signed.
    pub(super) const fn acceleration(&self) -> f64 {
        self.drive.acceleration()
    }

    /// Drive or steering turns, or is told to.
    pub(super) fn is_moving(&self) -> bool {
        !(self.drive.is_at_rest() && self.steer.is_at_rest())
    }

    /// The rates that are being ramped to: drive and steering.
    pub(super) const fn targets(&self) -> (f64, f64) {
        (self.drive.target(), self.steer.target())
    }

    /// The odometers' rates at `now`.
    pub(super) fn rates_at(&self, now: Timestamp) -> (f64, f64) {
        let t = (now - self.phase_start).as_secs_f64();
        (self.drive.rate(t), self.steer.rate(t))
    }

    /// When a ramp ends next.
    pub(super) fn phase_end(&self) -> Option<Timestamp> {
        let ends =
            [self.drive.settles_at(self.phase_start), self.steer.settles_at(self.phase_start)];
        ends.into_iter().flatten().min()
    }

    /// Where everything is at `now`, not before the last [`advance`](Self::advance).
    pub(super) fn state_at(&self, now: Timestamp) -> State {
        let elapsed = now - self.phase_start;
        let t = elapsed.as_secs_f64();
        let path = self.drive.integral(t);
        let turn = self.steer.integral(t);
        let (truth, reckoned) = if self.steer.is_at_rest() {
            let start = &self.at_start;
            if self.drive.is_at_rest() {
                return *start;
            }
            let after = |track: &Track, model| track.after_arc(model, path);
            (after(&start.truth, &self.phase_model), after(&start.reckoned, &TrackModel::PERFECT))
        } else if self.drive.is_at_rest() {
            let start = &self.at_start;
            let after = |track: &Track, model| track.after_turn(model, turn);
            (after(&start.truth, &self.phase_model), after(&start.reckoned, &TrackModel::PERFECT))
        } else {
            let mut state = self.at_piece;
            for piece in self.pieces..elapsed.as_nanos() / PIECE_NS {
                self.integrate(&mut state, piece_start(piece), piece_start(piece + 1));
            }
            let done = self.pieces.max(elapsed.as_nanos() / PIECE_NS);
            self.integrate(&mut state, piece_start(done), t);
            (state.truth, state.reckoned)
        };
        State {
            displacement: self.at_start.displacement + path,
            steered: self.at_start.steered + turn,
            truth,
            reckoned,
        }
    }

    /// Goes on to `now` within the phase: the caller stops at [`phase_end`](Self::phase_end) and
    /// calls [`start_phase`](Self::start_phase) there.
    pub(super) fn advance(&mut self, now: Timestamp) {
        if self.steer.is_at_rest() || self.drive.is_at_rest() {
            return;
        }
        let pieces = (now - self.phase_start).as_nanos() / PIECE_NS;
        let mut state = self.at_piece;
        for piece in self.pieces..pieces {
            self.integrate(&mut state, piece_start(piece), piece_start(piece + 1));
        }
        self.pieces = self.pieces.max(pieces);
        self.at_piece = state;
    }

    /// From `now` on, ramp to `drive` and `steer` with at most these accelerations.
    pub(super) fn start_phase(
        &mut self,
        now: Timestamp,
        (drive, drive_limit): (f64, f64),
        (steer, steer_limit): (f64, f64),
    ) {
        let state = self.state_at(now);
        let (drive_rate, steer_rate) = self.rates_at(now);
        self.phase_start = now;
        self.drive = Ramp::new(drive_rate, drive, drive_limit);
        self.steer = Ramp::new(steer_rate, steer, steer_limit);
        self.phase_model = self.model.in_phase(&self.drive, &self.steer);
        self.set_state(state);
    }

    /// From now on, the odometers' rates become motion like this; to be called at the start of a
    /// phase.
    pub(super) fn set_model(&mut self, model: TrackModel) {
        self.model = model;
        self.phase_model = model.in_phase(&self.drive, &self.steer);
    }

    /// The base is somewhere else; to be called at rest.
    pub(super) fn set_state(&mut self, state: State) {
        self.at_start = state;
        self.at_piece = state;
        self.pieces = 0;
    }

    fn integrate(&self, state: &mut State, from_s: f64, to_s: f64) {
        let span = (from_s, to_s);
        state.truth = state.truth.after_piece(&self.phase_model, &self.drive, &self.steer, span);
        state.reckoned =
            state.reckoned.after_piece(&TrackModel::PERFECT, &self.drive, &self.steer, span);
    }
}

fn piece_start(piece: i64) -> f64 {
    piece as f64 * PIECE_S
}
