//! Motion in phases between commands and ramp ends.
//!
//! Drive and steering follow the commanded rates like servos ([`servo`](super::servo)). Between the encoder of the
//! steering and the steered parts there may be play: after a reversal the truth stands still until the play is taken
//! up. Each such change starts a phase.
//!
//! Within a phase both rates are single ramps, so that odometers have a closed form. The position on the floor has one
//! as well, unless the base steers while it drives: then the module integrates pieces of [`PIECE_S`], counted from the
//! start of the phase. The result does not depend on when or how often the state is read.

use super::ramp::Ramp;
use super::servo::Servo;
use super::track::{PIECE_NS, PIECE_S, Piece, Track, TrackModel};
use wire::time::Timestamp;

/// Odometers and positions at one instant; SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct State {
    /// Path by the odometer.
    pub(super) displacement: f64,
    /// Steering angle by the odometer, unwrapped.
    pub(super) steered: f64,
    pub(super) truth: Track,
    /// Remaining counter-clockwise encoder turn of the steering before its play is taken up.
    pub(super) slack: f64,
    /// The base's own estimate; its body heading is the heading at the last pose write.
    pub(super) reckoned: Track,
}

/// How rates follow commands, and the true steering follows its encoder; SI units. Exactly by default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Following {
    pub(super) drive: Servo,
    pub(super) steer: Servo,
    /// Play of the steering.
    pub(super) play: f64,
}

/// Play below this counts as taken up (rad): less than a nanosecond's turn.
const PLAY_MIN: f64 = 1e-9;

#[derive(Debug, Clone)]
pub(super) struct Kinematics {
    following: Following,
    model: TrackModel,
    /// The model of the current phase.
    phase_model: TrackModel,
    phase_start: Timestamp,
    phase_end: Timestamp,
    commanded: [Ramp; 2],
    drive: Ramp,
    steer: Ramp,
    at_start: State,
    /// Number of pieces of the phase already integrated, and the state after them.
    pieces: i64,
    at_piece: State,
}

impl Kinematics {
    pub(super) fn new(model: TrackModel) -> Self {
        Self {
            following: Following::default(),
            model,
            phase_model: model,
            phase_start: Timestamp::ZERO,
            phase_end: Timestamp::MAX,
            commanded: [Ramp::default(); 2],
            drive: Ramp::default(),
            steer: Ramp::default(),
            at_start: State::default(),
            pieces: 0,
            at_piece: State::default(),
        }
    }

    /// The current model from odometer rates to motion.
    pub(super) const fn model_now(&self) -> &TrackModel {
        &self.phase_model
    }

    /// Acceleration of the drive in this phase, signed.
    pub(super) const fn acceleration(&self) -> f64 {
        self.drive.acceleration()
    }

    /// What drive and steering are to follow at `now`.
    pub(super) fn commanded_at(&self, now: Timestamp) -> [f64; 2] {
        let t = (now - self.phase_start).as_secs_f64();
        self.commanded.map(|commanded| commanded.rate(t))
    }

    /// True if drive or steering turns, or is commanded to.
    pub(super) fn is_moving(&self) -> bool {
        !self.commanded.iter().all(Ramp::is_at_rest)
    }

    pub(super) const fn targets(&self) -> (f64, f64) {
        (self.commanded[0].target(), self.commanded[1].target())
    }

    /// The odometers' rates at `now`.
    pub(super) fn rates_at(&self, now: Timestamp) -> (f64, f64) {
        let t = (now - self.phase_start).as_secs_f64();
        (self.drive.rate(t), self.steer.rate(t))
    }

    /// The next ramp end; [`Timestamp::MAX`] after the last.
    pub(super) const fn phase_end(&self) -> Timestamp {
        self.phase_end
    }

    /// The state at `now`, not before the last [`advance`](Self::advance).
    pub(super) fn state_at(&self, now: Timestamp) -> State {
        let (displacement, steered) = self.odometers_at(now);
        let reckoned = self.place_at(
            now,
            &TrackModel::PERFECT,
            &self.at_start.reckoned,
            &self.at_piece.reckoned,
        );
        let turned = steered - self.at_start.steered;
        let slack = (self.at_start.slack - turned).clamp(0.0, self.following.play);
        State { displacement, steered, truth: self.truth_at(now), slack, reckoned }
    }

    /// The odometers at `now`: path and steering angle.
    pub(super) fn odometers_at(&self, now: Timestamp) -> (f64, f64) {
        let t = (now - self.phase_start).as_secs_f64();
        let (path, turn) = (self.drive.integral(t), self.steer.integral(t));
        (self.at_start.displacement + path, self.at_start.steered + turn)
    }

    /// The true position at `now`, not before the last [`advance`](Self::advance).
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

    /// True if the base steers and drives at once: then there is no closed form.
    fn is_steered_on_the_way(&self) -> bool {
        !(self.steer.is_at_rest() || self.drive.is_at_rest())
    }

    /// One of the two positions, from those at the start of the phase and after the last whole piece.
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

    /// Advances to `now` within the phase: the caller stops at [`phase_end`](Self::phase_end) and calls
    /// [`start_phase`](Self::start_phase) there.
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

    /// Integrates from the last whole piece up to piece `done`.
    fn after_pieces(&self, from: Track, model: &TrackModel, done: i64) -> Track {
        (self.pieces..done).fold(from, |place, piece| {
            place.after_piece(model, &self.piece(piece_start(piece), piece_start(piece + 1)))
        })
    }

    const fn piece(&self, from_s: f64, to_s: f64) -> Piece<'_> {
        Piece { drive: &self.drive, steer: &self.steer, from_s, to_s }
    }

    /// From `now` on, ramps to `drive` and `steer` with at most these accelerations.
    pub(super) fn start_phase(
        &mut self,
        now: Timestamp,
        (drive, drive_limit): (f64, f64),
        (steer, steer_limit): (f64, f64),
    ) {
        let state = self.state_at(now);
        let [drive_rate, steer_rate] = self.commanded_at(now);
        self.phase_start = now;
        self.commanded =
            [Ramp::new(drive_rate, drive, drive_limit), Ramp::new(steer_rate, steer, steer_limit)];
        self.set_state(state);
        self.follow();
    }

    /// Sets the models from commands to motion; call at the start of a phase.
    pub(super) fn set_model(&mut self, model: TrackModel, following: Following) {
        (self.model, self.following) = (model, following);
        self.follow();
    }

    /// Computes the rates of drive, steering and truth from their commands, and the end of the phase.
    fn follow(&mut self) {
        let now = self.phase_start;
        let [drive, steer] = &self.commanded;
        self.phase_end = drive.settles_at(now).min(steer.settles_at(now));
        self.phase_model = self.model.in_phase(drive, steer);
        (self.drive, self.steer) = (*drive, *steer);
        if self.following == Following::default() {
            return;
        }
        let Following { drive: drive_servo, steer: steer_servo, play } = self.following;
        let reverses = if play > 0.0 { steer.passes(0.0) } else { None };
        let changes =
            [drive_servo.changes_after(drive), steer_servo.changes_after(steer), reverses];
        let first = changes.into_iter().flatten().min();
        self.phase_end = first.map_or(self.phase_end, |after| self.phase_end.min(now + after));
        // At its ends a rate may be on either side of a level, but not in the middle. Without an end it is constant.
        let middle = match self.phase_end {
            Timestamp::MAX => 0.0,
            end => 0.5 * (end - now).as_secs_f64(),
        };
        let steer_rate = steer.rate(middle);
        self.drive = drive_servo.follow(drive, drive.rate(middle));
        self.steer = steer_servo.follow(steer, steer_rate);
        let slack = self.at_start.slack.min(play);
        let free = if steer_rate > 0.0 { slack } else { slack - play };
        if free.abs() > PLAY_MIN && !self.steer.is_at_rest() {
            self.phase_model.turn_scale = 0.0;
            if let Some(after) = self.steer.adds_up_to(free) {
                self.phase_end = self.phase_end.min(now + after);
            }
        }
    }

    /// Moves the base elsewhere; call at rest.
    pub(super) fn set_state(&mut self, state: State) {
        self.at_start = state;
        self.at_piece = state;
        self.pieces = 0;
    }
}

fn piece_start(piece: i64) -> f64 {
    piece as f64 * PIECE_S
}
