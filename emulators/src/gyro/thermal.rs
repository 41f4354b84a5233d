//! Temperature of a gyro's coil and of the sensor beside it, and their effects.

use super::parameters::{GyroParameters, remainder};
use crate::random::RandomStream;
use libm::round;

/// Temperatures in degC.
#[derive(Debug, Clone, Copy)]
struct Temperatures {
    coil: f64,
    sensor: f64,
}

/// Coil and sensor temperature, advanced in steps of about a second.
///
/// The coil warms by its own power and follows the room, both with one time constant: over a step h its distance from
/// the steady temperature falls by e^(-h/tau), exactly. The sensor follows the coil with its own lag. Within a step
/// both are taken as linear; the error is h^2/8 times the second derivative: for 20 K in 35 min and 1 s less than 1e-6
/// K.
#[derive(Debug, Clone)]
pub(super) struct Thermal {
    start: Temperatures,
    end: Temperatures,
    reading: f64,
    noise: RandomStream,
}

impl Thermal {
    pub(super) fn new(parameters: &GyroParameters, seed: u64, device: &str) -> Self {
        let cold = remainder(parameters.powered_before_s, parameters.thermal_time_constant_s);
        let coil = parameters.ambient_celsius + parameters.self_heating_kelvin * (1.0 - cold);
        let now = Temperatures { coil, sensor: coil };
        let noise = RandomStream::new(seed, device, "gyro temperature sensor");
        Self { start: now, end: now, reading: coil, noise }
    }

    /// The coil's temperature at the start and at the end of the step.
    pub(super) const fn coil(&self) -> (f64, f64) {
        (self.start.coil, self.end.coil)
    }

    /// The coil's temperature after `share` of the step.
    pub(super) fn coil_at(&self, share: f64) -> f64 {
        self.start.coil + (self.end.coil - self.start.coil) * share
    }

    pub(super) const fn reading(&self) -> f64 {
        self.reading
    }

    /// Ends the step early, after `share` of it.
    pub(super) fn cut(&mut self, share: f64) {
        self.end.coil = self.coil_at(share);
        self.end.sensor = self.start.sensor + (self.end.sensor - self.start.sensor) * share;
    }

    /// Reads the sensor and advances by `step_s` from the end of the last step.
    pub(super) fn advance(&mut self, parameters: &GyroParameters, step_s: f64) {
        let start = self.end;
        self.reading = self.read(parameters, start.sensor);
        let steady = parameters.steady_celsius();
        let left = remainder(step_s, parameters.thermal_time_constant_s);
        let coil = steady + (start.coil - steady) * left;
        // A lag L settles r L below a ramp of slope r.
        let behind = (coil - start.coil) / step_s * parameters.temperature_lag_s;
        let left = remainder(step_s, parameters.temperature_lag_s);
        let sensor = coil - behind + (start.sensor - start.coil + behind) * left;
        self.start = start;
        self.end = Temperatures { coil, sensor };
    }

    fn read(&mut self, parameters: &GyroParameters, sensor: f64) -> f64 {
        let mut reading = sensor + parameters.temperature_offset_kelvin;
        if parameters.temperature_noise_kelvin > 0.0 {
            reading += parameters.temperature_noise_kelvin * self.noise.standard_normal();
        }
        let resolution = parameters.temperature_resolution_kelvin;
        if resolution > 0.0 { round(reading / resolution) * resolution } else { reading }
    }
}

/// A quantity that moves linearly from one value to another in a given number of outputs.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ramp {
    pub(super) value: f64,
    slope: f64,
}

impl Ramp {
    pub(super) fn new(from: f64, to: f64, outputs: u32) -> Self {
        Self { value: from, slope: (to - from) / f64::from(outputs) }
    }

    #[inline]
    pub(super) fn step(&mut self) {
        self.value += self.slope;
    }
}

#[cfg(test)]
mod tests {
    use super::Thermal;
    use crate::gyro::parameters::GyroParameters;

    fn warming() -> GyroParameters {
        GyroParameters {
            ambient_celsius: 22.0,
            self_heating_kelvin: 20.0,
            thermal_time_constant_s: 2_100.0,
            ..Default::default()
        }
    }

    #[test]
    fn warm_up_is_exponential_whatever_the_step() {
        for step_s in [0.5, 1.0, 100.0] {
            let mut thermal = Thermal::new(&warming(), 1, "gyro");
            assert_eq!(thermal.coil().1, 22.0);
            for _ in 0..(2_100.0 / step_s) as u32 {
                thermal.advance(&warming(), step_s);
            }
            let expected = 42.0 - 20.0 * (-1.0f64).exp();
            assert!((thermal.coil().1 - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn a_hot_start_begins_warm_and_the_room_changes_it() {
        let mut parameters = GyroParameters { powered_before_s: 1e6, ..warming() };
        let mut thermal = Thermal::new(&parameters, 1, "gyro");
        assert!((thermal.coil().1 - 42.0).abs() < 1e-9);
        parameters.ambient_celsius = 30.0;
        thermal.advance(&parameters, 2_100.0);
        assert!((thermal.coil().1 - (50.0 - 8.0 * (-1.0f64).exp())).abs() < 1e-9);
    }

    #[test]
    fn the_sensor_lags_a_ramp_by_slope_times_lag() {
        let parameters = GyroParameters { temperature_lag_s: 60.0, ..warming() };
        let mut thermal = Thermal::new(&parameters, 1, "gyro");
        for _ in 0..600 {
            thermal.advance(&parameters, 1.0);
        }
        let (start, end) = thermal.coil();
        // The slope itself falls by 60/2100 within a lag.
        let behind = start - thermal.reading();
        assert!((behind / ((end - start) * 60.0) - 1.0).abs() < 0.04, "{behind}");
    }

    #[test]
    fn readings_have_steps_offset_and_noise() {
        let parameters = GyroParameters {
            ambient_celsius: 20.3,
            temperature_resolution_kelvin: 0.25,
            temperature_offset_kelvin: 1.0,
            ..Default::default()
        };
        let mut thermal = Thermal::new(&parameters, 1, "gyro");
        thermal.advance(&parameters, 1.0);
        assert_eq!(thermal.reading(), 21.25);
        let noisy = GyroParameters { temperature_noise_kelvin: 0.1, ..Default::default() };
        let mut thermal = Thermal::new(&noisy, 1, "gyro");
        thermal.advance(&noisy, 1.0);
        let first = thermal.reading();
        thermal.advance(&noisy, 1.0);
        assert_ne!(first, thermal.reading());
    }
}
