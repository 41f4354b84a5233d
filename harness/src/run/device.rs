//! Runs a plan of a device of the user's own in virtual time.

use super::{Prepared, Simulated, finish};
use crate::made::Made;
use crate::operator::Answers;
use crate::plan::device::unit_of;
use crate::plan::{OfDevice, QuantityName};
use crate::record::Device;
use crate::record::Progress;
use crate::record::header::{Header, Line};
use crate::record::sink::RecordSink;
use crate::world::described::DescribedWorld;
use described::{Description, Medium};
use std::sync::Arc;

/// Runs the plan on the emulated device.
pub(super) fn simulate(
    prepared: &Prepared,
    device: &Arc<Description>,
    seed: u64,
    answers: &Answers,
    sink: &mut impl RecordSink,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Simulated {
    let plan = Arc::clone(&prepared.plan);
    let mut world = DescribedWorld::new(plan, device, answers.clone(), seed);
    let mut ending = world.run(sink, pulse);
    finish(sink, &mut ending);
    Simulated {
        ending,
        end: world.now(),
        events: world.events(),
        observations: world.engine().observations().values().flatten().cloned().collect(),
        made: Made::default(),
        dropped: world.dropped(),
        faults: world.faults().to_vec(),
        properties: Vec::new(),
        unjudged: Vec::new(),
    }
}

/// The units and meanings of the device's signals, as its layout has them, and its line.
pub(super) fn name(header: &mut Header, device: &Description) {
    let layout = device.layout();
    if let Medium::Serial(settings) = layout.medium() {
        let (baud, bits_per_byte) = (settings.baud, settings.bits_per_byte());
        header.lines = vec![Line { device: Device::Device, baud, bits_per_byte }];
    }
    for quantity in &mut header.quantities {
        let Some(name) = QuantityName::new(&quantity.name) else { continue };
        match name.of_device() {
            Some(OfDevice::Signal(signal)) => {
                let Some((message, signal)) = layout.signal(signal) else { continue };
                let signal = &layout.messages()[message].signals[signal];
                quantity.unit = unit_of(signal);
                quantity.title.clone_from(&signal.doc);
            }
            Some(OfDevice::Period(_)) => {
                "s".clone_into(&mut quantity.unit);
                "Time from one message to the next.".clone_into(&mut quantity.title);
            }
            None => {}
        }
    }
}
