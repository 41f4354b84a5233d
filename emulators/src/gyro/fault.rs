//! Deliberate faults of a gyro. Faults of its line are elsewhere.

use super::GyroEmulator;
use crate::random::RandomStream;
use wire::gyro::{GyroSample, Sequence};
use wire::packet::Packet;
use wire::units::Temperature;

/// A fault of a gyro. None of them shows in the stream's valid bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GyroFault {
    /// Repeats the first reading after the fault began. The sequence number continues.
    Stuck,
    /// The range is smaller.
    OverRange {
        /// Lost share of the range, within 0 to 1.
        lost: f64,
    },
    /// The bias is shifted.
    BiasStep {
        /// The shift, rad/s.
        by: f64,
    },
    /// Additional white noise on each output.
    Noise {
        /// Its standard deviation, rad/s.
        rms: f64,
    },
    /// The temperature sensor repeats its first reading after the fault began.
    TemperatureFrozen,
    /// The temperature sensor is noisy.
    TemperatureWild {
        /// Its standard deviation, K.
        rms_kelvin: f64,
    },
    /// No supply: silent, then a restart with sequence number and integrated angle zero.
    Off,
}

/// A fault with the values that it repeats.
#[derive(Debug, Clone)]
pub(super) struct Kept {
    fault: GyroFault,
    first: Option<f64>,
}

impl GyroEmulator {
    /// Switches a fault on under `number`, with its random numbers from `chance`.
    pub fn begin_fault(&mut self, number: usize, fault: GyroFault, chance: RandomStream) {
        if fault == GyroFault::Off {
            self.pending.clear();
        }
        self.faults.switch_on(number, Kept { fault, first: None }, chance);
    }

    /// Switches a fault off; returns the number of outputs it has changed or suppressed.
    pub fn end_fault(&mut self, number: usize) -> u64 {
        let Some((acted, kept)) = self.faults.switch_off(number) else { return 0 };
        if kept.fault == GyroFault::Off {
            self.integrated = 0.0;
            self.sequence = self.sequence.map(|sequence| Sequence { value: 0, ..sequence });
        }
        acted
    }

    /// Writes the output for the rate `wanted`, with active faults, to `packet`; `false` while the gyro is off.
    #[cold]
    pub(super) fn output_faulty(
        &mut self,
        wanted: f64,
        interval_s: f64,
        packet: &mut Packet,
    ) -> bool {
        let Some(sample) = self.measure_faulty(wanted, interval_s) else { return false };
        *packet = self.encoder.encode(&sample);
        true
    }

    /// The output for the rate `wanted`, with active faults; `None` while it is off.
    pub(super) fn measure_faulty(&mut self, wanted: f64, interval_s: f64) -> Option<GyroSample> {
        let mut rate = wanted;
        let mut range = self.range;
        for switch in self.faults.iter_mut() {
            match switch.fault.fault {
                GyroFault::BiasStep { by } => {
                    rate += by;
                    self.leapt += by * interval_s;
                }
                GyroFault::Noise { rms } => rate += rms * switch.chance.standard_normal(),
                GyroFault::OverRange { lost } => {
                    range *= 1.0 - lost;
                    // Counted below, once it is known whether the range mattered.
                    continue;
                }
                GyroFault::Off => {
                    switch.acted += 1;
                    return None;
                }
                _ => continue,
            }
            switch.acted += 1;
        }
        let over_range = rate.abs() > range;
        rate = rate.clamp(-range, range);
        for switch in self.faults.iter_mut() {
            match switch.fault.fault {
                GyroFault::OverRange { .. } => switch.acted += u64::from(over_range),
                GyroFault::Stuck => {
                    rate = *switch.fault.first.get_or_insert(rate);
                    switch.acted += 1;
                }
                _ => {}
            }
        }
        let mut sample = self.sample(rate, interval_s, over_range);
        if let Some(temperature) = &mut sample.temperature {
            *temperature = self.faulty_temperature(*temperature);
        }
        Some(sample)
    }

    fn faulty_temperature(&mut self, temperature: Temperature) -> Temperature {
        let mut celsius = temperature.celsius();
        for switch in self.faults.iter_mut() {
            match switch.fault.fault {
                GyroFault::TemperatureFrozen => {
                    celsius = *switch.fault.first.get_or_insert(celsius);
                }
                GyroFault::TemperatureWild { rms_kelvin } => {
                    celsius += rms_kelvin * switch.chance.standard_normal();
                }
                _ => continue,
            }
            switch.acted += 1;
        }
        Temperature::from_celsius(celsius)
    }
}
