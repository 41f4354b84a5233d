//! From rotor steps to the table's angle: play of the gear and eccentricity.

use super::parameters::TableParameters;
use super::profile::Profile;
use super::slip::{STEPS_PER_ELECTRICAL_CYCLE, Slip};
use libm::{round, sin};
use wire::time::Timestamp;
use wire::units::Angle;

/// A pause in which the rotor does not follow the field.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stand {
    from: f64,
    steps: f64,
}

/// Rotor, gear and table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mechanics {
    /// Steps lost in completed moves, with the sign of the moves.
    lost: f64,
    /// Slip of the current move.
    slip: Slip,
    /// The rotor stands still for this many steps of the field, from this step of the move on.
    stand: Option<Stand>,
    /// Angle of the table when the move began, in rad.
    table: f64,
}

impl Mechanics {
    /// At power-up the table stands in the middle of the play, since its history is unknown.
    pub(super) const AT_POWER_UP: Self =
        Self { lost: 0.0, slip: Slip::None, stand: None, table: 0.0 };

    /// Ends the move `profile`, completed or aborted, at `now`.
    pub(super) fn end_move(&mut self, p: &TableParameters, profile: &Profile, now: Timestamp) {
        let stood = self.stood(profile, now) / STEPS_PER_ELECTRICAL_CYCLE;
        let stood = round(stood) * STEPS_PER_ELECTRICAL_CYCLE;
        self.lost += profile.direction() * (self.slip.locked_in(profile, now) + stood);
        (self.slip, self.stand) = (Slip::None, None);
        self.table = self.table_at(p, profile, now);
    }

    /// Stops the rotor from now on, until the field is ahead by `steps`; at rest, from the next move on.
    pub(super) fn stand(&mut self, profile: &Profile, now: Timestamp, steps: f64) {
        self.stand = Some(Stand { from: profile.commanded(now), steps });
    }

    /// Steps that the rotor is behind after standing still, unsigned.
    fn stood(&self, profile: &Profile, now: Timestamp) -> f64 {
        self.stand
            .map_or(0.0, |stand| (profile.commanded(now) - stand.from).clamp(0.0, stand.steps))
    }

    /// Starts a move with this slip.
    pub(super) fn begin_move(&mut self, slip: Slip) {
        self.slip = slip;
    }

    /// Steps lost until `now`, signed.
    pub(super) fn lost_steps(&self, profile: &Profile, now: Timestamp) -> f64 {
        self.lost
            + profile.direction() * (self.slip.behind(profile, now) + self.stood(profile, now))
    }

    /// The table's angle by its gear, play included, in rad.
    fn table_at(&self, p: &TableParameters, profile: &Profile, now: Timestamp) -> f64 {
        let rotor = profile.position(now) - self.lost_steps(profile, now);
        let gear = Angle::from_deg(rotor * p.step_deg).rad();
        let half_play = 0.5 * Angle::from_deg(p.backlash_deg).rad();
        // The gear moves in one direction within a move, and takes the table along once the play is taken up.
        self.table.clamp(gear - half_play, gear + half_play)
    }

    /// The table's true angle, unwrapped: zero at power-up.
    pub(super) fn angle_at(&self, p: &TableParameters, profile: &Profile, now: Timestamp) -> Angle {
        let table = self.table_at(p, profile, now);
        let harmonic = |times: f64, amplitude_deg: f64, phase_deg: f64| {
            let phase = Angle::from_deg(phase_deg).rad();
            Angle::from_deg(amplitude_deg) * (sin(times * table + phase) - sin(phase))
        };
        Angle::from_rad(table)
            + harmonic(1.0, p.eccentricity_1x_deg, p.eccentricity_1x_phase_deg)
            + harmonic(2.0, p.eccentricity_2x_deg, p.eccentricity_2x_phase_deg)
    }
}
