//! Where each kind of fault is switched on and off.

use super::super::bench::Carrier;
use super::super::lines::{BaseLink, Lines, Node};
use super::super::stage::Stage;
use super::Faults;
use super::makes_frames;
use crate::faults::{Chance, FaultKind, Target, Toward};
use crate::hosted::HostedController;
use crate::link::SerialLine;
use emulators::base::BaseFault;
use emulators::gyro::GyroFault;
use wire::time::{Span, Timestamp};
use wire::units::Angle;

impl Faults {
    /// Switches a fault on; one that is over in an instant is done.
    pub(super) fn begin(&mut self, now: Timestamp, index: usize, stage: &mut Stage) {
        let fault = self.ledger.fault(index).clone();
        let kind = fault.what;
        if kind.info().reach.is_line() {
            if fault.target == Target::Base && stage.lines.base.is_bus() {
                self.last_of_bus = index;
            }
            return self.begin_on_line(now, index, (fault.target, fault.toward), &kind, stage);
        }
        let chance = Chance::new(self.seed, &index.to_string());
        if let Some(of_gyro) = gyro_fault(&kind) {
            return stage.bench.gyro.begin_fault(index, of_gyro, chance.into_stream());
        }
        match (kind, &mut stage.bench.carrier) {
            (FaultKind::EncoderJump { angle_deg }, Carrier::Base(base)) => {
                base.jump_encoder(now, Angle::from_deg(angle_deg));
                self.ledger.acted(index, 1);
            }
            (FaultKind::LostSteps { steps }, Carrier::Table(table)) => {
                table.lose_steps(now, steps);
                self.ledger.acted(index, 1);
            }
            (FaultKind::SchedulerStall { .. }, _) => self.host.stall(),
            (FaultKind::ClockStep { step_s }, _) => {
                self.host.step_clock(Span::from_secs_f64(step_s));
            }
            (FaultKind::WrongUnit { .. } | FaultKind::WrongSign { .. }, _) => {
                stage.slips.begin(index, kind, chance);
            }
            (_, Carrier::Base(base)) => {
                if let Some(of_base) = base_fault(&kind) {
                    base.begin_fault(now, index, of_base, chance.into_stream());
                }
            }
            (_, Carrier::Table(_)) => {}
        }
    }

    /// Switches a fault off; how often it has acted.
    pub(super) fn end(
        &mut self,
        now: Timestamp,
        index: usize,
        stage: &mut Stage,
        controller: Option<&mut impl HostedController>,
    ) -> u64 {
        let fault = self.ledger.fault(index);
        let kind = fault.what;
        if kind.info().reach.is_line() {
            if let (Target::Base, BaseLink::Can(bus)) = (fault.target, &mut stage.lines.base) {
                return bus.end_fault(now, index);
            }
            let lines = serial_lines(&mut stage.lines, fault.target);
            return lines.into_iter().flatten().map(|(_, line)| line.end_fault(index)).sum();
        }
        if gyro_fault(&kind).is_some() {
            return stage.bench.gyro.end_fault(index);
        }
        match (kind, &mut stage.bench.carrier) {
            (FaultKind::SchedulerStall { .. }, _) => {
                self.host.go_on(now, controller);
                self.host.taken()
            }
            (FaultKind::ClockStep { step_s }, _) => {
                self.host.step_clock(-Span::from_secs_f64(step_s));
                1
            }
            (FaultKind::WrongUnit { .. } | FaultKind::WrongSign { .. }, _) => {
                stage.slips.end(index)
            }
            (_, Carrier::Base(base)) => base.end_fault(now, index),
            (_, Carrier::Table(_)) => 0,
        }
    }

    fn begin_on_line(
        &self,
        now: Timestamp,
        index: usize,
        (target, toward): (Target, Toward),
        kind: &FaultKind,
        stage: &mut Stage,
    ) {
        let chance = |way: &str| Chance::new(self.seed, &format!("{index} {way}"));
        if let (Target::Base, BaseLink::Can(bus)) = (target, &mut stage.lines.base) {
            const NODES: [Node; 2] = [Node::Controller, Node::Base];
            let mut strike = |way, from| {
                let fault = (index, kind, chance(way));
                bus.begin_fault(now, fault, from, &NODES, Node::Stranger);
            };
            if makes_frames(kind) {
                return strike("bus", None);
            }
            if toward != Toward::Device {
                strike("to host", Some(Node::Base));
            }
            if toward != Toward::Host {
                strike("to device", Some(Node::Controller));
            }
            return;
        }
        for (way, line) in serial_lines(&mut stage.lines, target).into_iter().flatten() {
            if toward == Toward::Both || toward == way {
                let name = if way == Toward::Host { "to host" } else { "to device" };
                line.begin_fault(now, index, kind, chance(name));
            }
        }
    }
}

/// Both directions of the serial line to a target.
fn serial_lines(lines: &mut Lines, target: Target) -> [Option<(Toward, &mut SerialLine)>; 2] {
    let both =
        |to_host, to_device| [Some((Toward::Host, to_host)), Some((Toward::Device, to_device))];
    match (target, &mut lines.base) {
        (Target::Gyro, _) => both(&mut lines.gyro, &mut lines.gyro_commands),
        (Target::Table, _) => both(&mut lines.from_table, &mut lines.to_table),
        (Target::Base, BaseLink::Serial { to_base, to_controller }) => both(to_controller, to_base),
        _ => [None, None],
    }
}

/// The switch of the gyro that a kind is.
fn gyro_fault(kind: &FaultKind) -> Option<GyroFault> {
    Some(match *kind {
        FaultKind::Stuck { .. } => GyroFault::Stuck,
        FaultKind::OverRange { lost_percent } => {
            GyroFault::OverRange { lost: lost_percent / 100.0 }
        }
        FaultKind::BiasStep { deg_per_h } => {
            GyroFault::BiasStep { by: (deg_per_h / 3_600.0).to_radians() }
        }
        FaultKind::NoiseBurst { rms_deg_per_s } => {
            GyroFault::Noise { rms: rms_deg_per_s.to_radians() }
        }
        FaultKind::TemperatureFrozen { .. } => GyroFault::TemperatureFrozen,
        FaultKind::TemperatureWild { rms_kelvin } => GyroFault::TemperatureWild { rms_kelvin },
        FaultKind::Restart { .. } => GyroFault::Off,
        _ => return None,
    })
}

/// The switch of the base that a kind is.
fn base_fault(kind: &FaultKind) -> Option<BaseFault> {
    Some(match *kind {
        FaultKind::RefuseCommands { .. } => BaseFault::RefuseCommands,
        FaultKind::StuckOdometry { .. } => BaseFault::StuckOdometry,
        FaultKind::WheelSlip { slip_percent } => {
            BaseFault::WheelSlip { lost: slip_percent / 100.0 }
        }
        FaultKind::LateStop { late_s } => BaseFault::LateStop { by: Span::from_secs_f64(late_s) },
        FaultKind::EmergencyStop { .. } => BaseFault::EmergencyStop,
        _ => return None,
    })
}
