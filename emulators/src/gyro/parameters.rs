//! The imperfections of a gyro, each a named number.

use super::terms::Term;
use crate::parameters::parameters;
use libm::{cos, exp, sincos};
use wire::units::Angle;

/// Default correlation time of the exponentially correlated drift (assumption).
///
/// For this time a 20 s bias test helps least in an immediately following lap of 64 s travel: it maximises the
/// variance of the mean drift during the lap minus the mean drift during the test. No sum of such processes of the
/// same rms is worse. It is not fitted to any result; `gyro::noise` computes it.
pub const WORST_CASE_CORRELATION_S: f64 = 20.0;

/// Default of the shortest correlation time of the bias instability (assumption): well below the 20 s of a bias test,
/// and long enough that white noise covers everything faster.
pub const INSTABILITY_SHORTEST_S: f64 = 1.0;

/// Default of the longest correlation time of the bias instability (assumption): a record of a few hours, over which a
/// data sheet takes its rms.
pub const INSTABILITY_LONGEST_S: f64 = 10_000.0;

parameters! {
    /// The imperfections of a gyro. The default is an ideal one: everything off.
    ///
    /// Signs: counter-clockwise is positive; a positive scale error reads too much. Sizes are those
    /// of this class of instrument (fibre-optic, about 1 to 20 deg/h).
    pub struct GyroParameters {
        /// White noise of the rate, as angle random walk N (IEEE Std 952). KVH E-Core 2000: 0.083;
        /// this class: 0.07 to 1.
        angle_random_walk_deg_per_sqrt_h: NOT_NEGATIVE = 0.0,
        /// Bias instability (IEEE Std 952), flicker noise: rms of all that has correlation times
        /// from `bias_instability_shortest_s` to `bias_instability_longest_s`. Over four decades B
        /// is 0.58 of it, and 0.664 B the flat part of the Allan deviation. The paper's data sheet:
        /// 0.005 (bias drift at stabilised temperature).
        bias_instability_rms_deg_per_s: NOT_NEGATIVE = 0.0,
        /// Shortest correlation time of the bias instability; see [`INSTABILITY_SHORTEST_S`].
        bias_instability_shortest_s: POSITIVE = INSTABILITY_SHORTEST_S,
        /// Longest correlation time of the bias instability; see [`INSTABILITY_LONGEST_S`].
        bias_instability_longest_s: POSITIVE = INSTABILITY_LONGEST_S,
        /// Exponentially correlated (first-order Gauss-Markov) noise of the bias (IEEE Std 952),
        /// rms: for a unit whose Allan deviation shows one.
        bias_drift_deg_per_s: NOT_NEGATIVE = 0.0,
        /// Its correlation time; see [`WORST_CASE_CORRELATION_S`].
        bias_drift_correlation_s: POSITIVE = WORST_CASE_CORRELATION_S,
        /// Where it is not zero, the drift is drawn anew this often and constant in between, in place of that correlation:
        /// what a bias test has found says nothing of a later interval.
        bias_drift_held_s: NOT_NEGATIVE = 0.0,
        /// Rate random walk K (IEEE Std 952), zero at power-up. This class: about 1e-3 and less.
        rate_random_walk_deg_per_s_per_sqrt_s: NOT_NEGATIVE = 0.0,
        /// Turn-on bias, rms from one power-up to the next; drawn once. This class: 1 to 20.
        turn_on_bias_deg_per_h: NOT_NEGATIVE = 0.0,
        /// Constant bias. Where `earth_rate_deg_per_h` is zero, the vertical part of the Earth's rate
        /// is in it (10.1 deg/h at 42.3 deg north).
        bias_deg_per_h: FINITE = 0.0,
        /// Rate of the Earth: 15.041 (a turn in a sidereal day, 23.934 h). Zero leaves it out.
        earth_rate_deg_per_h: NOT_NEGATIVE = 0.0,
        /// Where the bench is, north positive. The axis sees the vertical part of the Earth's rate,
        /// its sine, and where it is tilted the horizontal part too.
        latitude_deg: LATITUDE = 0.0,
        /// Heading of the carrier at which the tilted axis leans to the north.
        tilt_north_heading_deg: FINITE = 0.0,
        /// Bias against coil temperature, about `reference_celsius`. This class: 1 to 5.
        bias_deg_per_h_per_kelvin: FINITE = 0.0,
        /// Bias against the square of the coil temperature, about `reference_celsius`.
        bias_deg_per_h_per_kelvin2: FINITE = 0.0,
        /// Bias against the rate of change of the coil temperature (Shupe effect). This class: 5 to
        /// 20.
        bias_deg_per_h_per_kelvin_per_min: FINITE = 0.0,
        /// The coil temperature at which bias and clock are as stated.
        reference_celsius: CELSIUS = 25.0,
        /// Scale error against coil temperature. The paper's unit: -1444 (slope of Eq. 5 over 360
        /// deg).
        scale_ppm_per_kelvin: FINITE = 0.0,
        /// The coil temperature at which the scale error is `scale_ppm`. The paper's unit: 36.98
        /// (the zero of Eq. 5).
        scale_zero_celsius: CELSIUS = 25.0,
        /// Bias against the distance of the coil temperature from itself with play (thermal
        /// hysteresis): so much lower on warming by more than the play, so much higher on cooling.
        /// This class: 0.1 to 0.3 of the bias against temperature.
        hysteresis_deg_per_h_per_kelvin: FINITE = 0.0,
        /// Half of that play (assumption: some kelvin).
        hysteresis_half_width_kelvin: NOT_NEGATIVE = 0.0,
        /// Bias that dies away after power-up whatever the temperature, as the electronics settle.
        /// This class: tens.
        warm_up_bias_deg_per_h: FINITE = 0.0,
        /// Its time constant. This class: 30 to 40 min.
        warm_up_bias_time_constant_s: POSITIVE = 2_100.0,
        /// Growth of the bias with time since power-up (ageing of the light source). Assumption: 0 to
        /// 1.
        bias_ageing_deg_per_h_per_h: FINITE = 0.0,
        /// A step of the bias, as a connection or a loose fibre makes it (assumption).
        bias_step_deg_per_h: FINITE = 0.0,
        /// When it comes, after power-up.
        bias_step_at_s: NOT_NEGATIVE = 0.0,
        /// A sinusoidal disturbance of the bias, zero at power-up: an air conditioner, say
        /// (assumption).
        periodic_bias_deg_per_h: FINITE = 0.0,
        /// Its period.
        periodic_bias_period_s: POSITIVE = 600.0,
        /// Bias with the carrier heading along `magnetic_heading_deg` (Faraday effect in the Earth's
        /// field); it goes with the cosine. This class: 1 to 10 a gauss, the Earth's field 0.5.
        magnetic_bias_deg_per_h: FINITE = 0.0,
        /// Heading at which that bias is largest.
        magnetic_heading_deg: FINITE = 0.0,
        /// Bias against the current of the carrier's motors, whose field reaches the coil. Assumption:
        /// about 1.
        bias_deg_per_h_per_ampere: FINITE = 0.0,
        /// Bias against the supply voltage. This class: 1 to 5.
        bias_deg_per_h_per_volt: FINITE = 0.0,
        /// How far the supply is off its nominal voltage; may change during a run.
        supply_deviation_volt: FINITE = 0.0,
        /// By how much the current of the carrier's motors pulls the supply down. A lead-acid battery
        /// of 24 V with its cables: 0.02 to 0.1 ohm (assumption).
        supply_sag_volt_per_ampere: NOT_NEGATIVE = 0.0,
        /// Fringes of the bias over the coil temperature about `reference_celsius`: a sine within a
        /// bell, by parasitic interference (assumption: its size is that of the bias against
        /// temperature).
        fringe_bias_deg_per_h: FINITE = 0.0,
        /// From one fringe to the next.
        fringe_period_kelvin: POSITIVE = 4.0,
        /// Standard deviation of the bell.
        fringe_width_kelvin: POSITIVE = 6.0,
        /// A bias against temperature, about `reference_celsius`, that grows from nothing at power-up
        /// (assumption: the coil's potting relaxes).
        drifting_bias_deg_per_h_per_kelvin: FINITE = 0.0,
        /// Time constant of that growth.
        drifting_time_constant_s: POSITIVE = 7_200.0,
        /// Constant scale error. This class: up to 10000 uncorrected.
        scale_ppm: FINITE = 0.0,
        /// How much larger the scale is counter-clockwise than clockwise. This class: 0 to 500.
        scale_asymmetry_ppm: FINITE = 0.0,
        /// Scale error at 30 deg/s that grows with the square of the rate. This class: -700 to
        /// -4000 uncorrected.
        scale_ppm_at_30_deg_per_s: FINITE = 0.0,
        /// Growth of the scale error with time since power-up (ageing of the light source). This class:
        /// 0.1 to 1 % in a life; an hour's worth is exaggerated to be seen (assumption).
        scale_ageing_ppm_per_h: FINITE = 0.0,
        /// Scale error at `resonance_deg_per_s`, falling off with a cusp to both sides: the modulator
        /// or a mount in resonance (assumption).
        resonance_ppm: FINITE = 0.0,
        /// The rate at which that error is largest.
        resonance_deg_per_s: NOT_NEGATIVE = 30.0,
        /// How far from there it has fallen to 1/e.
        resonance_width_deg_per_s: POSITIVE = 5.0,
        /// Scaled rates within this of zero read zero, before bias and noise. This class: 0 to 0.005.
        dead_zone_deg_per_s: NOT_NEGATIVE = 0.0,
        /// Angle between the sensitive axis and the vertical: 1 deg costs 0.055 deg in a turn, 2 deg 0.22.
        axis_tilt_deg: FINITE = 0.0,
        /// Rates beyond this are clipped and flagged. The paper's data sheet: 100.
        range_deg_per_s: LIMIT = f64::INFINITY,
        /// Frequency at which the response, a first-order lag, has fallen by 3 dB. The paper's data
        /// sheet: 100.
        bandwidth_hz: LIMIT = f64::INFINITY,
        /// From the end of the interval that an output covers to its first byte.
        latency_s: LATENCY = 0.0,
        /// How much too fast the gyro's own clock runs, and with it the outputs. KVH DSP-3000: up to
        /// +-30000 from unit to unit.
        clock_error_ppm: CLOCK_ERROR = 0.0,
        /// The same against coil temperature, about `reference_celsius`. KVH DSP-3000: +-2000 over
        /// its temperatures.
        clock_ppm_per_kelvin: CLOCK_ERROR = 0.0,
        /// Temperature of the room; may change during a run.
        ambient_celsius: CELSIUS = 20.0,
        /// How much warmer than the room the coil gets by its own power.
        self_heating_kelvin: KELVIN = 0.0,
        /// Time constant of the coil's temperature; 0 follows at once. This class: 30 to 40 min.
        thermal_time_constant_s: NOT_NEGATIVE = 0.0,
        /// How long the gyro had been switched on when the run began.
        powered_before_s: NOT_NEGATIVE = 0.0,
        /// The warm-up flag is set while the coil is further than this from its steady temperature.
        warm_up_flag_kelvin: LIMIT = f64::INFINITY,
        /// Time by which the temperature sensor lags the coil, first order.
        temperature_lag_s: NOT_NEGATIVE = 0.0,
        /// What the sensor reads too much.
        temperature_offset_kelvin: KELVIN = 0.0,
        /// White noise of the sensor, rms of a reading.
        temperature_noise_kelvin: NOT_NEGATIVE = 0.0,
        /// Step of the sensor's readings; 0 for none beyond that of the stream.
        temperature_resolution_kelvin: NOT_NEGATIVE = 0.0,
    }
    lists {
        /// Error terms beside those that have a name here; see [`Term`].
        terms: Term = Vec::new(),
    }
}

/// The rate at which `scale_ppm_at_30_deg_per_s` is specified: the paper's table rate.
const CUBIC_REFERENCE_DEG_PER_S: f64 = 30.0;
const PPM: f64 = 1e-6;
const SECONDS_PER_MINUTE: f64 = 60.0;

impl GyroParameters {
    /// Steady temperature of the coil.
    pub(super) fn steady_celsius(&self) -> f64 {
        self.ambient_celsius + self.self_heating_kelvin
    }

    /// Deterministic bias in rad/s for the coil at `celsius`, changing by `kelvin_per_s`.
    pub(super) fn bias(&self, celsius: f64, kelvin_per_s: f64) -> f64 {
        let off_reference = celsius - self.reference_celsius;
        let deg_per_h = self.bias_deg_per_h
            + off_reference
                * (self.bias_deg_per_h_per_kelvin
                    + off_reference * self.bias_deg_per_h_per_kelvin2)
            + self.bias_deg_per_h_per_kelvin_per_min * kelvin_per_s * SECONDS_PER_MINUTE
            + self.earth_deg_per_h().0;
        wire::units::AngularRate::from_deg_per_h(deg_per_h).rad_per_s()
    }

    /// The components of the Earth's rate along the axis: the constant one, and the largest one through the tilt,
    /// which varies with the cosine of the heading.
    pub(super) fn earth_deg_per_h(&self) -> (f64, f64) {
        if self.earth_rate_deg_per_h == 0.0 {
            return (0.0, 0.0);
        }
        let (sin_latitude, cos_latitude) = sincos(Angle::from_deg(self.latitude_deg).rad());
        let (sin_tilt, cos_tilt) = sincos(Angle::from_deg(self.axis_tilt_deg).rad());
        let earth = self.earth_rate_deg_per_h;
        (earth * sin_latitude * cos_tilt, earth * cos_latitude * sin_tilt)
    }

    /// Bias per ampere of the carrier's motors: through their field and the supply.
    pub(super) fn motor_deg_per_h_per_ampere(&self) -> f64 {
        self.bias_deg_per_h_per_ampere
            - self.bias_deg_per_h_per_volt * self.supply_sag_volt_per_ampere
    }

    /// Factor on the rate, for the coil at `celsius`, at low rates and as the mean of both directions.
    pub(super) fn scale(&self, celsius: f64) -> f64 {
        let ppm = self.scale_ppm + self.scale_ppm_per_kelvin * (celsius - self.scale_zero_celsius);
        (1.0 + ppm * PPM) * cos(Angle::from_deg(self.axis_tilt_deg).rad())
    }

    /// Scale error per (rad/s)^2.
    pub(super) fn cubic(&self) -> f64 {
        let reference = Angle::from_deg(CUBIC_REFERENCE_DEG_PER_S).rad();
        self.scale_ppm_at_30_deg_per_s * PPM / (reference * reference)
    }

    /// Scale error of counter-clockwise rates; that of clockwise ones is its negative.
    pub(super) fn half_asymmetry(&self) -> f64 {
        self.scale_asymmetry_ppm * PPM / 2.0
    }

    /// Output rate over nominal output rate, for the coil at `celsius`.
    pub(super) fn clock_rate(&self, celsius: f64) -> f64 {
        let ppm =
            self.clock_error_ppm + self.clock_ppm_per_kelvin * (celsius - self.reference_celsius);
        let bound = crate::parameters::Domain::CLOCK_ERROR;
        1.0 + ppm.clamp(bound.min, bound.max) * PPM
    }
}

/// The share of a first-order difference left after `seconds`; zero without a time constant.
pub(super) fn remainder(seconds: f64, time_constant_s: f64) -> f64 {
    if time_constant_s > 0.0 { exp(-seconds / time_constant_s) } else { 0.0 }
}
