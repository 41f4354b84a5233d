//! The paper's figures, drawn again from what was observed here.
//!
//! A figure is chosen by what was observed, and under which conditions: any plan that observes the same gets it. What
//! the paper gives is drawn broken and in a colour of its own, the plan's band is drawn as everywhere.

mod drift;
mod lap_error;
mod returns;
mod scale_factor;
mod static_bias;
mod table_error;
#[cfg(test)]
mod tests;

use super::collect::Collected;
use super::observed::Sample;
use maud::{Markup, html};
use record::header::{Band, Header};
use std::collections::BTreeSet;

/// Figures, and whose observations they show as a whole.
#[derive(Debug, Default)]
pub(super) struct Figures {
    all: Vec<Markup>,
    shown: BTreeSet<String>,
}

/// What figures are drawn from.
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

    /// The observations that were made under such conditions.
    fn only(self, quantity: &str, keep: impl Fn(&Sample) -> bool) -> Vec<Sample> {
        self.samples(quantity).iter().filter(|sample| keep(sample)).copied().collect()
    }
}

impl Figures {
    /// All that can be drawn.
    pub(super) fn of(header: &Header, collected: &Collected) -> Self {
        let source = Source { header, collected };
        let mut figures = Self::default();
        drift::draw(source, &mut figures);
        static_bias::draw(source, &mut figures);
        scale_factor::draw(source, &mut figures);
        lap_error::draw(source, &mut figures);
        table_error::draw(source, &mut figures);
        returns::draw(source, &mut figures);
        figures
    }

    /// One more.
    fn add(&mut self, figure: Option<Markup>) {
        self.all.extend(figure);
    }

    /// These are shown as a whole.
    fn shows(&mut self, quantities: &[&str]) {
        self.shown.extend(quantities.iter().map(|&name| name.to_owned()));
    }

    /// Need it not be drawn once more?
    pub(super) fn show(&self, quantity: &str) -> bool {
        self.shown.contains(quantity)
    }

    /// Nothing was observed that the paper draws.
    pub(super) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Those that there are.
    pub(super) fn plots(&self) -> Option<Markup> {
        (!self.is_empty()).then(|| html! { div.plots { @for figure in &self.all { (figure) } } })
    }
}
