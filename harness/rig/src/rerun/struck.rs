//! What a plan and its faults did to the devices under test is done to them again.

use super::{Again, Clock, RerunError};
use plan::faults::{Reach, Toward};
use record::{FaultEvent, FaultRecord};

impl Again {
    /// Switches a node off, if the step of that title does.
    pub(super) fn cycle(&mut self, title: &str) -> Result<(), RerunError> {
        let Some((node, off)) = self.cycles.get(title).cloned() else { return Ok(()) };
        let Some(place) = self.rig.find(&node).filter(|place| self.tested.contains(place)) else {
            return Ok(());
        };
        if self.clock == Clock::Real {
            return Err(RerunError::SwitchedOff { at_s: self.now.as_secs_f64() });
        }
        self.settle();
        self.rig.nodes[place].cut_for(self.now, off);
        Ok(())
    }

    /// Begins or ends a fault of a line or a supply. What it did to the inputs is in the record, its own frames included.
    pub(super) fn strike(&mut self, record: &FaultRecord) -> Result<(), RerunError> {
        let number = record.index as usize;
        let Some((fault, chances)) = self.faults.get(number) else { return Ok(()) };
        let is_real = self.clock == Clock::Real;
        if fault.what.holds_up() && !is_real && matches!(record.event, FaultEvent::Began) {
            for (line, _) in self.rig.lines_of(fault.target) {
                let line = &self.rig.lines[line];
                // A serial line of two ends carries what each of them sends by itself.
                let shared = line.ends().iter().filter(|_| line.is_can() || line.ends().len() > 2);
                for end in shared {
                    self.held_up.entry(end.who).or_insert(self.now);
                }
            }
        }
        let (reach, part) = (fault.what.info().reach, fault.target.part());
        let is_met = reach.is_line() || reach == Reach::Powered || part.is_some();
        if !is_met || fault.what.makes_frames() {
            return Ok(());
        }
        let struck = (fault.target, fault.toward, &fault.what);
        match record.event {
            FaultEvent::Began if is_real && fault.toward != Toward::Device => {
                return Err(RerunError::LineFault { at_s: self.now.as_secs_f64() });
            }
            FaultEvent::Began => _ = self.rig.begin_fault(self.now, number, struck, chances),
            FaultEvent::Ended { .. } => {
                _ = self.rig.end_fault(self.now, number, (fault.target, &fault.what));
            }
            FaultEvent::NeverHappened { .. } | FaultEvent::Confinement { .. } => {}
        }
        Ok(())
    }
}
