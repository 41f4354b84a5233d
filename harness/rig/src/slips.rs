//! A person who answers in another unit, or with the wrong sign.

use emulators::fault::Switches;
use plan::faults::Chance;
use plan::faults::FaultKind;
use record::Reply;

/// The active slips.
pub(crate) type Slips = Switches<FaultKind, Chance>;

/// Changes the number of a reply as the active slips do.
pub(crate) fn slip(slips: &mut Slips, reply: &mut Reply) {
    let Some(number) = &mut reply.number else { return };
    for slip in slips.iter_mut() {
        let factor = match slip.fault {
            FaultKind::WrongUnit { factor } => factor,
            FaultKind::WrongSign { wrong_percent }
                if slip.chance.happens(wrong_percent / 100.0) =>
            {
                -1.0
            }
            _ => continue,
        };
        number.value *= factor;
        slip.acted += 1;
    }
}
