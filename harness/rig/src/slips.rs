//! A person who answers in another unit, or with the wrong sign.

use plan::faults::Chance;
use plan::faults::FaultKind;
use record::Reply;

#[derive(Debug, Clone, Default)]
pub(crate) struct Slips {
    on: Vec<Slip>,
}

#[derive(Debug, Clone)]
struct Slip {
    number: usize,
    kind: FaultKind,
    chance: Chance,
    acted: u64,
}

impl Slips {
    pub fn begin(&mut self, number: usize, kind: FaultKind, chance: Chance) {
        self.on.push(Slip { number, kind, chance, acted: 0 });
    }

    /// Ends a slip; returns how many answers it changed.
    pub fn end(&mut self, number: usize) -> u64 {
        let acted = self.acted(number);
        self.on.retain(|slip| slip.number != number);
        acted
    }

    pub fn acted(&self, number: usize) -> u64 {
        let found = self.on.iter().find(|slip| slip.number == number);
        found.map_or(0, |slip| slip.acted)
    }

    /// Changes the number of a reply as the active slips do.
    pub fn change(&mut self, reply: &mut Reply) {
        let Some(number) = &mut reply.number else { return };
        for slip in &mut self.on {
            let factor = match slip.kind {
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
}
