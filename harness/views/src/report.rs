//! `report.html`: a run on one page, a [`campaign`], two runs [`compared`], or an [`identification`], for a person.
//!
//! The page is self-contained: no script, no request, light or dark like the reader's system, and printable. It is
//! computed from the summary and the record only, so that it can be drawn again later.
//!
//! The page judges nothing: it shows the verdicts of the summary.

mod against;
mod bus_load;
pub mod campaign;
mod collect;
pub mod compared;
mod decided;
mod download;
pub mod envelopes;
mod failures;
mod fault_spans;
mod frame;
mod group;
mod heading;
pub mod identification;
mod listed;
mod marks;
mod measurements;
mod median;
mod observations;
mod observed;
mod page;
mod palette;
mod panel;
mod paper;
mod path;
mod phases;
mod plain;
mod properties;
#[cfg(test)]
mod samples;
mod scatter;
mod steps;
mod stimuli;
#[cfg(test)]
mod tests;
mod thin;
mod timeline;
mod trouble;

use collect::Collected;
use record::Record;
use record::header::Header;
use record::outcome::Summary;
use record::reader::RecordError;

/// Renders the page of a run from its summary, the header of its record, and its records, which are read once and not
/// kept. A record that ends early is drawn as far as it goes, and the page states that.
pub fn render(
    summary: &Summary,
    header: &Header,
    records: impl IntoIterator<Item = Result<Record, RecordError>>,
) -> String {
    let collected = Collected::of(header, records);
    page::page(summary, header, &collected).into_string()
}
