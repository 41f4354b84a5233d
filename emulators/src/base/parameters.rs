//! The imperfections and limits of a mobile base, each a named number.

use crate::parameters::parameters;

parameters! {
    /// A wheel: where its foot is and how it errs.
    pub struct Wheel {
        /// Foot ahead of the centre of all feet, with the steering at zero.
        x_m: FINITE = 0.0,
        /// Foot to the left of the centre of all feet.
        y_m: FINITE = 0.0,
        /// Radius over nominal radius, less one. This class: 0.002 (1.5 deg/10 m at 0.25 m).
        radius_error: FINITE = 0.0,
        /// Toe: how far the wheel points to the left of the common direction. This class: 0.1 (1.3
        /// deg/10 m at 0.25 m).
        toe_deg: FINITE = 0.0,
    }
}

parameters! {
    /// Limits and imperfections of a synchro-drive base. The default is an ideal one, with the
    /// K2A's limits.
    pub struct BaseParameters {
        /// Fastest drive. Cybermotion K2A: 0.78.
        speed_max_m_per_s: LIMIT = 0.78,
        /// Fastest steering. Cybermotion K2A: 120.
        steer_rate_max_deg_per_s: LIMIT = 120.0,
        /// Hardest change of speed (assumption).
        acceleration_max_m_per_s2: LIMIT = 0.5,
        /// Hardest change of steering rate (assumption).
        steer_acceleration_max_deg_per_s2: LIMIT = 120.0,
        /// Acceleration in force until a host sets another: of the drive. 0.25 fits the paper's lap
        /// of 64 s.
        acceleration_m_per_s2: LIMIT = 0.25,
        /// Acceleration in force until a host sets another: of the steering. 21 fits the paper's lap
        /// of 64 s.
        steer_acceleration_deg_per_s2: LIMIT = 21.0,
        /// The base stops by itself when no velocity command has come for this long (assumption).
        command_timeout_s: LIMIT = 0.5,
        /// True path over the odometer's, less one. This class: 0.001 to 0.01.
        displacement_scale_error: FINITE = 0.0,
        /// True steering angle over the odometer's, less one; what turns the body back in reaction
        /// to the steering is part of it. The paper's robot: 0.011 (its laps, see `leakage`).
        turn_scale_error: FINITE = 0.0,
        /// The same, drawn anew at each start from rest: rms about `turn_scale_error`.
        turn_scale_spread: NOT_NEGATIVE = 0.0,
        /// Curvature of the path by drive torque that leaks into the steering; see
        /// `base::curvature`. The paper's robot: 0.125.
        leakage_deg_per_m: FINITE = 0.0,
        /// The same, drawn anew at each start from rest: rms about `leakage_deg_per_m`.
        leakage_spread_deg_per_m: NOT_NEGATIVE = 0.0,
        /// How much larger the true steering angle is counter-clockwise than clockwise, over the
        /// odometer's: wind-up of the steering. This class: 0 to 0.0005. A ramp through zero
        /// counts as turning to where it ends.
        turn_scale_asymmetry: FINITE = 0.0,
        /// Play of the steering between its encoder and what it turns, wheels and turret: after each
        /// reversal the encoder turns by so much alone. This class: 0.1 to 0.5.
        steering_play_deg: NOT_NEGATIVE = 0.0,
        /// Slowest speed that the drive keeps up against its friction: below it the drive stands. A DC
        /// servo of this class: a thousandth of the top speed (assumption).
        drive_stiction_m_per_s: NOT_NEGATIVE = 0.0,
        /// The same of the steering.
        steering_stiction_deg_per_s: NOT_NEGATIVE = 0.0,
        /// How far the speed is off the commanded one, rms; the odometer sees it. Assumption: 1 % of a
        /// usual speed; see `base::servo`.
        drive_noise_m_per_s: NOT_NEGATIVE = 0.0,
        /// The same of the steering rate.
        steering_noise_deg_per_s: NOT_NEGATIVE = 0.0,
        /// Growth of the true path over the odometer's with time, as tyres warm up and grow: of the
        /// time since the run began, taken at each start from rest. This class: 0.0001 to 0.001.
        tyre_growth_per_h: FINITE = 0.0,
        /// Path lost while speeding up harder than `slip_free_m_per_s2`, as a share for each m/s^2
        /// beyond it: wheels spin. Assumption: some percent.
        slip_driving_per_m_per_s2: FINITE = 0.0,
        /// Path gained while braking harder than that: wheels drag. Assumption: as much.
        slip_braking_per_m_per_s2: FINITE = 0.0,
        /// Acceleration up to which nothing slips (assumption).
        slip_free_m_per_s2: NOT_NEGATIVE = 0.2,
        /// Current of the drive motor in motion (assumption: a 125 kg base on a hard floor and 24 V).
        motor_ampere_rolling: NOT_NEGATIVE = 4.0,
        /// The same on top for each m/s^2 of acceleration, either way (assumption, likewise).
        motor_ampere_per_m_per_s2: NOT_NEGATIVE = 10.0,
        /// Current of the steering motor while it turns (assumption).
        motor_ampere_steering: NOT_NEGATIVE = 2.0,
        /// Step of the odometer's heading. The paper's K2A: 0.3. 0 for none beyond the wire's.
        heading_step_deg: NOT_NEGATIVE = 0.0,
    }
    lists {
        /// The wheels. Without any (the ideal base) nothing but leakage bends the path.
        wheels: Wheel = Vec::new(),
    }
}
