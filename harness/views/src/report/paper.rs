//! The paper's figures, drawn again from the observations of this run.
//!
//! The observations and their conditions select the figures: any plan with the same observations gets them. Values of
//! the paper are dashed and in a colour of their own; the plan's bands are drawn as everywhere.

mod gyro;
mod laps;
#[cfg(test)]
mod tests;

use super::collect::Collected;
use super::observed::Sample;
use maud::{Markup, html};
use record::header::{Band, Header};
use std::collections::BTreeSet;

/// Figures, and the quantities that they show completely.
#[derive(Debug, Default)]
pub(super) struct Figures {
    all: Vec<Markup>,
    shown: BTreeSet<String>,
}

#[derive(Debug, Clone, Copy)]
struct Source<'a> {
    header: &'a Header,
    collected: &'a Collected,
}

impl<'a> Source<'a> {
    fn samples(self, quantity: &str) -> &'a [Sample] {
        self.collected.samples(quantity)
    }

    fn bands(self, quantity: &str) -> &'a [Band] {
        let found = self.header.quantities.iter().find(|known| known.name == quantity);
        found.map_or(&[], |quantity| &quantity.bands)
    }

    fn only(self, quantity: &str, keep: impl Fn(&Sample) -> bool) -> Vec<Sample> {
        self.samples(quantity).iter().filter(|sample| keep(sample)).copied().collect()
    }
}

impl Figures {
    pub(super) fn of(header: &Header, collected: &Collected) -> Self {
        let source = Source { header, collected };
        let mut figures = Self::default();
        gyro::drift(source, &mut figures);
        gyro::static_bias(source, &mut figures);
        gyro::scale_factor(source, &mut figures);
        laps::lap_error(source, &mut figures);
        gyro::table_error(source, &mut figures);
        laps::returns(source, &mut figures);
        figures
    }

    fn add(&mut self, figure: Option<Markup>) {
        self.all.extend(figure);
    }

    /// Marks these quantities as shown completely.
    fn shows(&mut self, quantities: &[&str]) {
        self.shown.extend(quantities.iter().map(|&name| name.to_owned()));
    }

    pub(super) fn show(&self, quantity: &str) -> bool {
        self.shown.contains(quantity)
    }

    /// Whether there were no observations for the paper's figures.
    pub(super) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    pub(super) fn plots(&self) -> Option<Markup> {
        (!self.is_empty()).then(|| html! { div.plots { @for figure in &self.all { (figure) } } })
    }
}
