//! Data of a journal for the page, collected in one pass.

use super::super::thin::Point;
use campaign::{Account, Line, Struck, Tally};
use plan::confidence::{Interval, Z_95, wilson};
use plan::faults::{Fault, When};
use std::collections::{BTreeMap, BTreeSet};

const MARGINS_MAX: usize = 1_000_000;

/// Column of a table: when a fault began.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Column {
    Always,
    At,
    Phase(String),
}

impl Column {
    /// A step with a label has one column, whether the fault names its label or its key.
    fn of(fault: &Fault, labels: &BTreeMap<String, Vec<String>>) -> Self {
        match &fault.when {
            When::Always => Self::Always,
            When::At(_) => Self::At,
            When::Step { phase, number, .. } | When::During { phase, number } => {
                let place = (*number as usize).saturating_sub(1);
                let label = labels.get(phase.as_str()).and_then(|labels| labels.get(place));
                Self::Phase(label.map_or(phase.as_str(), String::as_str).to_owned())
            }
        }
    }

    pub(super) fn name(&self) -> &str {
        match self {
            Self::Always => "from the beginning",
            Self::At => "at a time",
            Self::Phase(name) => name,
        }
    }
}

/// In how many cases a fault of this combination acted, and in how many of them a property broke.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Tried {
    pub cases: u64,
    pub broke: u64,
}

impl Tried {
    /// 95 % interval of the share in which a property breaks; `None` without a case.
    pub(super) fn interval(self) -> Option<Interval> {
        wilson(self.broke, self.cases, Z_95)
    }

    fn count(&mut self, broke: bool) {
        self.cases += 1;
        self.broke += u64::from(broke);
    }
}

/// The margins of one property over the cases.
#[derive(Debug, Clone, Default)]
pub(super) struct Margins {
    pub held: Vec<Point>,
    /// Of cases that broke it: of some formulas the margin of these is zero.
    pub broke: Vec<Point>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Drawn {
    pub faults: u64,
    /// Those that never began, or changed nothing.
    pub idle: u64,
}

/// Everything of a journal that the page draws.
#[derive(Debug, Clone, Default)]
pub struct Gathered {
    pub(super) tally: Tally,
    pub(super) margins: BTreeMap<String, Margins>,
    pub(super) drawn: Drawn,
    pub(super) tried: BTreeMap<(Struck, Column), Tried>,
    /// Number of cases with margins beyond [`MARGINS_MAX`].
    pub(super) margins_not_kept: u64,
    /// Number of cases asked for: an earlier campaign in the folder may have gone on for longer.
    asked: u64,
    labels: BTreeMap<String, Vec<String>>,
}

impl Gathered {
    /// Nothing yet of this campaign.
    pub fn of(account: &Account) -> Self {
        Self { asked: account.asked, labels: account.labels.clone(), ..Self::default() }
    }

    pub fn add(&mut self, line: &Line) {
        if line.number >= self.asked {
            return;
        }
        self.tally.count(line.number, &line.result);
        let broke = !line.result.violated.is_empty();
        let faults = &line.case.schedule.faults;
        // A fault that did nothing was not tried. Where that is not known, it counts.
        let acted = |(place, _): &(usize, _)| line.result.has_acted(*place).unwrap_or(true);
        let acting: Vec<&Fault> =
            faults.iter().enumerate().filter(acted).map(|(_, fault)| fault).collect();
        self.drawn.faults += faults.len() as u64;
        self.drawn.idle += (faults.len() - acting.len()) as u64;
        let what: BTreeSet<(Struck, Column)> = acting
            .into_iter()
            .map(|fault| (Struck::of(fault.what, &fault.target), Column::of(fault, &self.labels)))
            .collect();
        for key in what {
            self.tried.entry(key).or_default().count(broke);
        }
        if self.tally.cases > MARGINS_MAX as u64 {
            self.margins_not_kept += 1;
            return;
        }
        for (property, margin) in
            line.result.margins.iter().filter(|(_, margin)| margin.is_finite())
        {
            let margins = self.margins.entry(property.clone()).or_default();
            let broke = line.result.breaks(property) || *margin < 0.0;
            let points = if broke { &mut margins.broke } else { &mut margins.held };
            points.push((line.number as f64, *margin));
        }
    }
}
