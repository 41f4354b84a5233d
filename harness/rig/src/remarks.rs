//! Counts of a run that no measurement covers. They appear at the end of the run, so that no value is out of range
//! unnoticed.

use super::Rig;
use super::node::Part;
use super::rig::Ear;
use described::Clipped;
use record::figures;
use wire::can::{Hex, Id};

impl Rig {
    /// One line for each count that is not zero.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        // Every message of a device with known messages should be one of them.
        let judged = || self.ears.iter().filter(|ear| ear.judged);
        let short = judged().flat_map(|ear| ear.decoder.short()).map(|(_, count)| count);
        let damaged: u64 = judged().map(|ear| ear.decoder.damaged()).sum();
        let outside = damaged - short.sum::<u64>();
        if outside > 0 {
            remarks.push(format!("bytes or frames outside of any message: {outside}"));
        }
        for ear in judged() {
            let node = self.lines[ear.line].name(ear.end);
            remarks.extend(ear.decoder.short().map(|(message, count)| {
                let frames = figures::counted(count, "frame", "frames");
                format!("{node} sent {frames} of {} with too few bytes", message.name)
            }));
            remarks.extend(ear.decoder.long().map(|(message, count)| {
                let frames = figures::counted(count, "frame", "frames");
                format!("{node} sent {frames} of {} with more bytes than it has", message.name)
            }));
            remarks.extend(ear.decoder.alone().map(|(message, count)| {
                let (frames, name) = (figures::counted(count, "frame", "frames"), &message.name);
                format!(
                    "{node} sent {frames} of {name} with a part of its bytes: what is beyond kept its values, and \
                     fast packets of NMEA 2000 are not put together"
                )
            }));
            remarks.extend(ear.decoder.spoilt().map(|(message, count)| {
                let times = figures::times(count);
                format!("{times} {node}.{} had a wrong checksum, and did not count", message.name)
            }));
        }
        remarks.extend(self.unexpected());
        remarks.extend(self.doubled());
        remarks.extend(self.requested());
        for ear in &self.ears {
            let node = self.lines[ear.line].name(ear.end);
            for (message, count) in &ear.oddities.wrong_checksums {
                let name = &ear.decoder.layout().messages()[*message].name;
                remarks.push(format!(
                    "{} {node}.{name} had a wrong checksum, and its values did not count",
                    figures::times(*count)
                ));
            }
            for ((message, signal), count) in &ear.oddities.out_of_range {
                let message = &ear.decoder.layout().messages()[*message];
                let signal = &message.signals[*signal];
                remarks.push(format!(
                    "{} {node}.{}.{} was out of its range, {}",
                    figures::times(*count),
                    message.name,
                    signal.name,
                    from_to((signal.minimum, signal.maximum), &signal.unit)
                ));
            }
        }
        for (name, line) in self.line_names.iter().zip(&self.lines) {
            let lost = line.no_room();
            if lost > 0 {
                remarks.push(format!("{lost} messages lost on {name}: too many waited for it"));
            }
            if line.collisions() > 0 {
                let times = figures::times(line.collisions());
                remarks.push(format!("{times} two nodes sent at the same time on {name}"));
            }
        }
        for node in &self.nodes {
            let Part::Described(described) = &node.part else { continue };
            let device = described;
            let clipped = device.clipped().map(|Clipped { name, range, unit, count, farthest }| {
                format!(
                    "{} {}.{name} was clipped to its range, {}; the farthest value was {}",
                    figures::times(count),
                    node.name,
                    from_to(range, unit),
                    figures::quantity_alone(farthest, 0.0, unit)
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

impl Rig {
    /// Asks the programs under test to end. One line for each that does not end in order.
    pub fn stop(&mut self) -> Vec<String> {
        let told = self.nodes.iter_mut().filter_map(|node| match &mut node.part {
            Part::Own(own) => own.guest.stop().map(|how| format!("`{}` {how}", node.name)),
            _ => None,
        });
        told.collect()
    }

    /// A sentence about each identifier of a node of this run that somebody at the port uses as well.
    fn doubled(&self) -> impl Iterator<Item = String> + '_ {
        self.ears.iter().flat_map(|ear| {
            let (line, node) = (&self.line_names[ear.line], self.lines[ear.line].name(ear.end));
            let told = move |(id, count): (Id, u64)| {
                let (frames, id) = (figures::counted(count, "frame", "frames"), Hex(id));
                format!(
                    "somebody at the port of {line} sent {frames} with the identifier {id} of {node}, which this run \
                     sends itself: they were ignored"
                )
            };
            ear.oddities.doubled.each().map(told)
        })
    }

    /// A sentence about each message of a node that remote requests asked for.
    fn requested(&self) -> impl Iterator<Item = String> + '_ {
        self.ears.iter().flat_map(|ear| {
            let (line, line_name) = (&self.lines[ear.line], &self.line_names[ear.line]);
            let node = line.ends().get(ear.end.place()).map(|end| &self.nodes[end.node]);
            let is_played =
                node.is_some_and(|node| matches!(node.part, Part::Described(_) | Part::Tester(_)));
            let answer = if is_played { ", which does not answer them" } else { "" };
            let told = move |(id, count): (Id, u64)| {
                let node = line.name(ear.end);
                let requests = figures::counted(count, "remote request", "remote requests");
                format!("{requests} on {line_name} for {} of {node}{answer}", Hex(id))
            };
            ear.oddities.requested.each().map(told)
        })
    }

    /// A sentence about each identifier that an end sent and that is another node's, and one about those of nobody.
    fn unexpected(&self) -> impl Iterator<Item = String> + '_ {
        let odd = |ear: &&Ear| ear.judged && !ear.oddities.unexpected.is_empty();
        self.ears.iter().filter(odd).flat_map(|ear| {
            let mut rest = ear.oddities.unexpected.clone();
            let another = |id: Id| {
                let is_it = |other: &&Ear| other.line == ear.line && other.decoder.takes(id);
                self.ears.iter().find(is_it)
            };
            let who = match self.is_away(ear.line, ear.end) {
                // Others may be on that line as well.
                true => format!("somebody on {}", self.line_names[ear.line]),
                false => self.lines[ear.line].name(ear.end).to_owned(),
            };
            let mut told: Vec<String> = rest
                .take(|id| another(id).is_some())
                .into_iter()
                .filter_map(|(id, count)| {
                    let other = another(id)?;
                    let (node, id) = (self.lines[other.line].name(other.end), Hex(id));
                    let frames = figures::counted(count, "frame", "frames");
                    Some(format!("{who} sent {frames} with the identifier {id} of {node}"))
                })
                .collect();
            if !rest.is_empty() {
                // It may be one of another line.
                let line = &self.line_names[ear.line];
                told.push(format!("{who} sent frames that are no message of {line}: {rest}"));
            }
            told
        })
    }
}

fn from_to((least, greatest): (f64, f64), unit: &str) -> String {
    figures::with_unit(format!("{least} to {greatest}"), unit)
}
