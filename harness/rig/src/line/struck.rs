//! Faults of a line, and of the messages of its ends.

use super::{End, EndId, Line, Wire};
use crate::link::Struck;
use plan::faults::{Chance, Chances, FaultKind, Toward};
use record::Device;
use wire::can::Id;
use wire::time::Timestamp;

impl Line {
    /// Begins a fault of the line: it strikes what the device at the end `of` sends, what the others send to it, or
    /// both. Each direction has its own random numbers. On a bus, with an identifier, it strikes only frames with that
    /// identifier.
    pub fn begin_fault(
        &mut self,
        now: Timestamp,
        (number, kind): (usize, &FaultKind),
        (of, toward, only): (EndId, Toward, Option<Id>),
        chances: &Chances,
    ) {
        self.struck_last = number;
        // Of the paper's base, each frame is judged by whether it came through.
        let is_of_base = |end: &End| matches!(end.who, Device::Base | Device::Controller);
        let is_of_rig = !self.ends.iter().any(is_of_base);
        let is_shared = is_of_rig && self.ends.len() > 2;
        match &mut self.wire {
            Wire::Can(bus) => {
                let ends: Vec<EndId> = (0..self.ends.len()).map(EndId::of).collect();
                let mut strike = |name: &str, from, at| {
                    let fault = (number, kind, chances.of(name));
                    bus.begin_fault(now, fault, (from, at, only), &ends);
                };
                let of_bus = kind.makes_frames();
                if of_bus {
                    strike("bus", None, None);
                }
                if toward != Toward::Device && !of_bus {
                    strike("to host", Some(of), None);
                }
                let loses = matches!(
                    kind,
                    FaultKind::Drop { .. }
                        | FaultKind::BurstLoss { .. }
                        | FaultKind::Disconnect { .. }
                );
                if toward != Toward::Host && loses && is_of_rig && of.place() < ends.len() {
                    // What it loses was on the bus: others hear it, and it is judged.
                    strike("to device", None, Some(of));
                } else if toward != Toward::Host && !of_bus {
                    let others = ends.iter().filter(|end| **end != of);
                    for (count, other) in others.enumerate() {
                        strike(&to_device(count), Some(*other), None);
                    }
                }
            }
            Wire::Serial(ways) => {
                let is_plug = is_shared && matches!(kind, FaultKind::Disconnect { .. });
                let is_alone = is_plug && of.place() < ways.len();
                if is_alone && toward != Toward::Host {
                    self.unplugged.push((number, of));
                }
                let mut others = 0;
                for (place, way) in ways.iter_mut().enumerate() {
                    let is_its = EndId::of(place) == of;
                    let (direction, name) = match is_its {
                        true => (Toward::Host, "to host".to_owned()),
                        false => (Toward::Device, to_device(others)),
                    };
                    others += usize::from(!is_its);
                    let is_struck = toward == Toward::Both || toward == direction;
                    if is_struck && (is_its || !is_alone) {
                        way.begin_fault(now, number, kind, chances.of(&name));
                    }
                }
            }
            Wire::Direct(_) => {}
        }
        self.look_ahead();
    }

    /// Begins a fault that changes a message of the device at that end before it is on the line.
    pub(crate) fn tamper(
        &mut self,
        fault: (usize, &FaultKind, Chance),
        from: EndId,
        struck: Struck,
    ) {
        self.struck_last = fault.0;
        self.tampering.begin(fault, from, struck);
    }

    /// Ends the fault of this number; returns how often it acted.
    pub fn end_fault(&mut self, now: Timestamp, number: usize) -> u64 {
        let tampered = self.tampering.end(number);
        let plugs = self.unplugged.len();
        self.unplugged.retain(|(by, _)| *by != number);
        let plugged = (plugs - self.unplugged.len()) as u64;
        let acted = match &mut self.wire {
            Wire::Can(bus) => bus.end_fault(now, number),
            Wire::Serial(ways) => ways.iter_mut().map(|way| way.end_fault(number)).sum(),
            Wire::Direct(_) => 0,
        };
        self.look_ahead();
        tampered + plugged + acted
    }
}

/// The name of the random numbers of what this one of the other ends sends.
fn to_device(count: usize) -> String {
    match count {
        0 => "to device".to_owned(),
        more => format!("to device {more}"),
    }
}

#[cfg(test)]
mod tests {
    use super::{Chances, Device, End, EndId, FaultKind, Line, Timestamp, Toward};
    use plan::faults::{Fault, Target};
    use wire::can::{BitRates, CanFrame, StandardId};
    use wire::device::{PortId, Transmit};

    /// Found by a user: what an interface had delivered waited for its turn on a bus that was modelled once more, and was never
    /// judged.
    #[test]
    fn what_had_its_time_on_a_bus_arrives_at_once_unless_a_fault_strikes_it() {
        let end = |node| End { node, port: PortId(0), who: Device::Node(0), name: "n".into() };
        let mut line = Line::can(BitRates::USUAL, vec![end(0), end(1)]);
        let frame = |id: u16| CanFrame::new(StandardId::new(id).unwrap(), &[0; 8]).unwrap();
        let (now, from) = (Timestamp::ZERO, EndId::of(0));
        let arrived = |line: &mut Line| -> Vec<Transmit> {
            std::iter::from_fn(|| line.arrived(now).map(|(_, what)| what)).collect()
        };
        line.send(now, EndId::of(1), Transmit::Frame(frame(1)));
        for id in [3, 2] {
            line.carried(now, from, frame(id));
        }
        assert_eq!(line.next_arrival(), now);
        let expected = [3, 2].map(|id| Transmit::Frame(frame(id)));
        assert_eq!(arrived(&mut line), expected, "in the order of the bus outside");
        let drop = FaultKind::typical("disconnect").unwrap();
        let chances = Chances::new(1, &Fault::new(Target::Device, drop), 0);
        line.begin_fault(now, (0, &drop), (from, Toward::Both, None), &chances);
        line.carried(now, from, frame(4));
        assert_eq!(arrived(&mut line), []);
        assert!(line.end_fault(now, 0) == 0, "it is on the bus, for the fault to strike it there");
        line.carried(now, from, frame(5));
        assert_eq!(arrived(&mut line), [Transmit::Frame(frame(5))]);
    }
}
