//! Motion in phases between commands and ramp ends.
//!
//! Within a phase both rates are single ramps, so that odometers have a closed form, and the place on
//! the floor has one as well unless the base steers while it drives. Then pieces of [`PIECE_S`] are
//! integrated, counted from the start of the phase. Whoever asks where the base is, and how often,
//! changes nothing.

use super::ramp::Ramp;
use super::track::{PIECE_NS, PIECE_S, Piece, Track, TrackModel};
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
    phase_end: Timestamp,
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
            phase_end: Timestamp::MAX,
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

    /// When a ramp ends next; [`Timestamp::MAX`] where none does.
    pub(super) const fn phase_end(&self) -> Timestamp {
        self.phase_end
    }

    /// Where everything is at `now`, not before the last [`advance`](Self::advance).
    pub(super) fn state_at(&self, now: Timestamp) -> State {
        let (displacement, steered) = self.odometers_at(now);
        let reckoned = self.place_at(
            now,
            &TrackModel::PERFECT,
            &self.at_start.reckoned,
            &self.at_piece.reckoned,
        );
        State { displacement, steered, truth: self.truth_at(now), reckoned }
    }

    /// The odometers at `now`: path and steering angle.
    pub(super) fn odometers_at(&self, now: Timestamp) -> (f64, f64) {
        let t = (now - self.phase_start).as_secs_f64();
        let (path, turn) = (self.drive.integral(t), self.steer.integral(t));
        (self.at_start.displacement + path, self.at_start.steered + turn)
    }

    /// Where the base is at `now`, not before the last [`advance`](Self::advance).
    pub(super) fn truth_at(&self, now: Timestamp) -> Track {
        self.place_at(now, &self.phase_model, &self.at_start.truth, &self.at_piece.truth)
    }

    /// The turret's true heading at `now`, not before the last [`advance`](Self::advance).
    pub(super) fn heading_at(&self, now: Timestamp) -> f64 {
        let (drives, steers) = (!self.drive.is_at_rest(), !self.steer.is_at_rest());
        let from = &self.at_start.truth;
        if !drives && !steers {
            return from.heading();
        }
        let elapsed = now - self.phase_start;
        if !steers {
            let path = self.drive.integral(elapsed.as_secs_f64());
            return from.heading_after_arc(&self.phase_model, path);
        }
        if drives && elapsed.as_nanos() / PIECE_NS <= self.pieces {
            let piece = self.piece(piece_start(self.pieces), elapsed.as_secs_f64());
            return self.at_piece.truth.heading_after_piece(&self.phase_model, &piece);
        }
        self.truth_at(now).heading()
    }

    /// It steers and drives at once: there is no closed form.
    fn is_steered_on_the_way(&self) -> bool {
        !(self.steer.is_at_rest() || self.drive.is_at_rest())
    }

    /// One of the two places, from where it was at the start of the phase and after the last whole piece.
    fn place_at(
        &self,
        now: Timestamp,
        model: &TrackModel,
        at_start: &Track,
        at_piece: &Track,
    ) -> Track {
        let elapsed = now - self.phase_start;
        let t = elapsed.as_secs_f64();
        if self.is_steered_on_the_way() {
            let done = self.pieces.max(elapsed.as_nanos() / PIECE_NS);
            let place = self.after_pieces(*at_piece, model, done);
            place.after_piece(model, &self.piece(piece_start(done), t))
        } else if !self.drive.is_at_rest() {
            at_start.after_arc(model, self.drive.integral(t))
        } else if !self.steer.is_at_rest() {
            at_start.after_turn(model, self.steer.integral(t))
        } else {
            *at_start
        }
    }

    /// Goes on to `now` within the phase: the caller stops at [`phase_end`](Self::phase_end) and
    /// calls [`start_phase`](Self::start_phase) there.
    pub(super) fn advance(&mut self, now: Timestamp) {
        if !self.is_steered_on_the_way() {
            return;
        }
        let done = (now - self.phase_start).as_nanos() / PIECE_NS;
        if done > self.pieces {
            let State { truth, reckoned, .. } = self.at_piece;
            self.at_piece.truth = self.after_pieces(truth, &self.phase_model, done);
            self.at_piece.reckoned = self.after_pieces(reckoned, &TrackModel::PERFECT, done);
            self.pieces = done;
        }
    }

    /// From the last whole piece on through those up to `done`.
    fn after_pieces(&self, from: Track, model: &TrackModel, done: i64) -> Track {
        (self.pieces..done).fold(from, |place, piece| {
            place.after_piece(model, &self.piece(piece_start(piece), piece_start(piece + 1)))
        })
    }

    const fn piece(&self, from_s: f64, to_s: f64) -> Piece<'_> {
        Piece { drive: &self.drive, steer: &self.steer, from_s, to_s }
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
        self.phase_end = self.drive.settles_at(now).min(self.steer.settles_at(now));
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
}

fn piece_start(piece: i64) -> f64 {
    piece as f64 * PIECE_S
}
