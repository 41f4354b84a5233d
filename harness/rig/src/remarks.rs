//! Counts of a run that no measurement covers. They appear at the end of the run, so that no value is out of range
//! unnoticed.

use super::Rig;
use super::node::Part;
use described::{Clipped, Signal};
use record::figures;

impl Rig {
    /// One line for each count that is not zero.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        // Every message of a device with known messages should be one of them.
        let judged = self.ears.iter().filter(|ear| ear.judged);
        let damaged: u64 = judged.map(|ear| ear.decoder.damaged()).sum();
        if damaged > 0 {
            remarks.push(format!("bytes or frames outside of any message: {damaged}"));
        }
        for ear in &self.ears {
            let node = self.lines[ear.line].name(ear.end);
            for ((message, signal), count) in &ear.out_of_range {
                let message = &ear.decoder.layout().messages()[*message];
                let signal = &message.signals[*signal];
                remarks.push(format!(
                    "{} {node}.{}.{} was out of its range, {}",
                    figures::times(*count),
                    message.name,
                    signal.name,
                    range(signal)
                ));
            }
        }
        for (name, line) in self.line_names.iter().zip(&self.lines) {
            let lost = line.no_room();
            if lost > 0 {
                remarks.push(format!("{lost} messages lost on {name}: too many waited for it"));
            }
        }
        for node in &self.nodes {
            let Part::Described(described) = &node.part else { continue };
            let device = &described.device;
            let clipped = device.clipped().map(|Clipped { message, signal, count, farthest }| {
                let farthest = figures::quantity_alone(farthest, 0.0, &signal.unit);
                format!(
                    "{} {}.{message}.{} was clipped to its range, {}; the farthest value was {farthest}",
                    figures::times(count), node.name, signal.name, range(signal)
                )
            });
            remarks.extend(clipped);
            let counted = [
                (device.not_finite(), "had a value that is no number, and kept the one before"),
                (
                    device.refused_messages(),
                    "did not use a message with a wrong counter or checksum",
                ),
                (device.refused_busy(), "refused a question while it answered another"),
            ];
            for (count, what) in counted.into_iter().filter(|(count, _)| *count > 0) {
                remarks.push(format!("{} {} {what}", figures::times(count), node.name));
            }
        }
        remarks
    }
}

fn range(signal: &Signal) -> String {
    figures::with_unit(format!("{} to {}", signal.minimum, signal.maximum), &signal.unit)
}
