//! A first pass over a record, so that the columns are known before the first row.

use record::header::Header;
use record::reader::RecordError;
use record::{Device, Record, RecordKind};
use std::collections::{BTreeMap, BTreeSet};
use wire::time::Timestamp;

/// Most quantities that are distinguished; a plan has a few dozen.
pub const QUANTITIES_MAX: usize = 1_024;

/// Most tags of one quantity: each is a column.
pub const TAGS_MAX: usize = 256;

#[derive(Debug, Default)]
pub struct Survey {
    pub header: Header,
    /// The tags with which each quantity was observed.
    pub quantities: BTreeMap<String, BTreeSet<String>>,
    /// Number of observations and tags beyond [`QUANTITIES_MAX`] and [`TAGS_MAX`], which have no column.
    pub left_out: u64,
    pub records: u64,
    /// Time of the last record.
    pub end: Timestamp,
    /// Whether it holds records of the user's own device.
    pub of_device: bool,
    pub cut: Option<RecordError>,
}

impl Survey {
    /// Reads records until the end or the first error.
    pub fn of(
        header: &Header,
        records: impl IntoIterator<Item = Result<Record, RecordError>>,
    ) -> Self {
        let mut survey = Self { header: header.clone(), ..Self::default() };
        for record in records {
            match record {
                Ok(record) => survey.take(&record),
                Err(error) => {
                    survey.cut = Some(error);
                    break;
                }
            }
        }
        survey
    }

    fn take(&mut self, record: &Record) {
        self.records += 1;
        self.end = self.end.max(record.at);
        self.of_device |= record.device == Device::Device;
        let RecordKind::Observation(observation) = &record.kind else { return };
        if !self.quantities.contains_key(&observation.quantity) {
            if self.quantities.len() >= QUANTITIES_MAX {
                self.left_out += 1;
                return;
            }
            self.quantities.insert(observation.quantity.clone(), BTreeSet::new());
        }
        let Some(tags) = self.quantities.get_mut(&observation.quantity) else { return };
        for tag in observation.tags.keys() {
            if tags.contains(tag) {
                continue;
            }
            if tags.len() >= TAGS_MAX {
                self.left_out += 1;
            } else {
                tags.insert(tag.clone());
            }
        }
    }

    /// "whole", or why it could not be read to its end.
    pub fn wholeness(&self) -> String {
        self.cut.as_ref().map_or_else(|| "whole".to_owned(), ToString::to_string)
    }

    /// The tags of all quantities, at most [`TAGS_MAX`] of them.
    pub fn tags(&self) -> Vec<&str> {
        let all: BTreeSet<&str> = self.quantities.values().flatten().map(String::as_str).collect();
        all.into_iter().take(TAGS_MAX).collect()
    }

    /// Unit of a quantity: as declared by the record's plan, else the standard one; empty if unknown.
    pub fn unit(&self, quantity: &str) -> &str {
        let declared = self.header.quantities.iter().find(|declared| declared.name == quantity);
        let known = || plan::quantities::find(quantity).map(|known| known.unit);
        declared
            .map(|declared| declared.unit.as_str())
            .filter(|unit| !unit.is_empty())
            .or_else(known)
            .filter(|unit| *unit != "1")
            .unwrap_or("")
    }

    /// Meaning of a quantity; empty if unknown.
    pub fn title(&self, quantity: &str) -> &str {
        let declared = self.header.quantities.iter().find(|declared| declared.name == quantity);
        match plan::quantities::find(quantity) {
            Some(known) => known.doc.trim_end_matches('.'),
            None => declared.map_or("", |declared| &declared.title),
        }
    }
}
