//! `report.html` of a campaign: broken properties, margins of the others, and the faults tried.
//!
//! Drawn from the [`Account`] of the campaign and the cases of its journal, as far as they exist.

mod coverage;
mod found;
mod gather;
mod heading;
mod margins;
mod properties;
#[cfg(test)]
mod tests;

pub use gather::Gathered;

use super::page::{document, section};
use campaign::Account;
use maud::html;

/// Renders the page. The same arguments give the same bytes.
pub fn page(account: &Account, gathered: &Gathered) -> String {
    let body = html! {
        (heading::heading(account, gathered))
        (section("What broke", found::cards(account)))
        (section("Properties that must hold", properties::always(account, gathered)))
        (section("States that should come about", properties::sometimes(account, gathered)))
        (section("What was tried", Some(coverage::table(account, gathered))))
        (section("Margins", margins::plots(gathered)))
    };
    let title = format!("{}: campaign, {}", account.plan, heading::word(account, gathered));
    document(&title, &body).into_string()
}
