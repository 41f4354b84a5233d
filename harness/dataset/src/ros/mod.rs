//! A table in a ROS bag: topics are groups, and fields of their messages are channels.

mod bag;
mod content;
mod decode;
mod definition;
mod input;
mod mcap;
mod packed;
mod ros1;
mod sqlite;
mod standard;
mod topics;

use super::channels::{Cell, Channel, Each, Group, Source, Wanted, take};
use super::error::{DatasetError, Defect};
use super::package::{Field, Table};
use super::table::Rows;
use bag::Container;
use content::{Place, Stop, Visitor};
use decode::{Want, decode};
use definition::Kind;
use input::{Fault, Input};
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
use topics::{Topic, Topics};

/// Name of the channel with the time of the recording, in seconds since the first message of the bag.
const TIME: &str = "time";

/// Appends the content of `table`, which has this `index`.
pub(super) fn read(
    rows: &mut Rows,
    fields: &[Field],
    table: &Table,
    index: usize,
    notices: &mut Vec<String>,
) -> Result<(), DatasetError> {
    let mut bag = Bag::open(&table.path)?;
    bag.find(fields, table)?;
    take(&mut bag, rows, fields, table, index, notices)
}

struct Bag {
    path: PathBuf,
    container: Container<BufReader<File>>,
    is_finished: bool,
    topics: Topics,
    groups: Vec<Group>,
    /// The ways to the channels of each group; none to its time.
    paths: Vec<Vec<Option<Vec<u32>>>>,
}

impl Bag {
    fn open(path: &std::path::Path) -> Result<Self, DatasetError> {
        let unreadable = |error| DatasetError::new(path, Defect::Unreadable(error));
        let file = File::open(path).map_err(unreadable)?;
        let input = Input::new(BufReader::new(file)).map_err(unreadable)?;
        let opened = Container::open(path, input);
        let (container, is_finished) = opened.map_err(|fault| match fault {
            Fault::Unreadable(error) => unreadable(error),
            Fault::Cut => malformed(path, "the file ends within its first record".to_owned()),
            Fault::Bad(why) => malformed(path, why),
        })?;
        let (topics, groups, paths) = (Topics::default(), Vec::new(), Vec::new());
        let path = path.to_owned();
        let mut bag = Self { path, container, is_finished, topics, groups, paths };
        let found = bag.container.visit(&mut bag.topics);
        let count = bag.container.indexed_min();
        let is_indexed = bag.topics.are_indexed(count);
        // A fault before the index says nothing about the index.
        if found.is_ok() && !is_indexed && count > 0 {
            bag.is_finished = false;
        }
        if !bag.is_finished || !is_indexed || found.is_err() {
            bag.topics = Topics::of_all_chunks();
            let found = bag.container.visit(&mut bag.topics);
            let ended = bag.ended(found)?;
            if let Some(ended) = ended.filter(|_| bag.topics.is_empty()) {
                return Err(malformed(&bag.path, ended));
            }
        }
        bag.topics.understand().map_err(|why| malformed(&bag.path, why))?;
        Ok(bag)
    }

    /// Makes a channel of each field that a topic has.
    fn find(&mut self, fields: &[Field], table: &Table) -> Result<(), DatasetError> {
        for topic in &self.topics.all {
            let inside = |name: &str| {
                let inside = name.strip_prefix(&topic.name).and_then(|name| name.strip_prefix('/'));
                inside.map(str::to_owned)
            };
            let mut names = Vec::new();
            for field in fields.iter().map(|field| field.name.trim()) {
                names.extend(inside(field));
                names.push(field.to_owned());
            }
            names.sort();
            names.dedup();
            let definition = match &topic.messages {
                Ok((definition, _)) => definition,
                Err(why) => {
                    let group = table.group.as_deref();
                    let named = fields.iter().any(|field| inside(field.name.trim()).is_some());
                    if named || group == Some(&topic.name) {
                        return Err(malformed(&self.path, format!("topic {}: {why}", topic.name)));
                    }
                    continue;
                }
            };
            let time = Channel { name: TIME.to_owned(), unit: "s".to_owned(), is_time: true };
            let (mut channels, mut paths) = (vec![time], vec![None]);
            for name in names.into_iter().filter(|name| name != TIME) {
                let Some((path, kind)) = definition.path(&name) else { continue };
                let unit = if matches!(kind, Kind::Stamp(..)) { "s" } else { "" };
                channels.push(Channel { name, unit: unit.to_owned(), is_time: false });
                paths.push(Some(path));
            }
            self.groups.push(Group { name: topic.name.clone(), channels });
            self.paths.push(paths);
        }
        Ok(())
    }

    /// Why the reading ended early, if this is no error.
    fn ended(&self, found: Result<(), Stop>) -> Result<Option<String>, DatasetError> {
        match found {
            Ok(()) => Ok(None),
            Err(Stop::Told(error)) => Err(error),
            Err(Stop::Fault(_, Fault::Unreadable(error))) => {
                Err(DatasetError::new(&self.path, Defect::Unreadable(error)))
            }
            Err(Stop::Fault(place, Fault::Cut)) => {
                Ok(Some(format!("{place}: the file ends within a record")))
            }
            Err(Stop::Fault(place, Fault::Bad(why))) if self.is_finished => {
                Err(malformed(&self.path, format!("{place}: {why}")))
            }
            Err(Stop::Fault(place, Fault::Bad(why))) => Ok(Some(format!("{place}: {why}"))),
        }
    }
}

impl Source for Bag {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn read(
        &mut self,
        group: usize,
        wanted: &[Wanted],
        each: Each<'_>,
    ) -> Result<Option<(String, Option<String>)>, DatasetError> {
        let name = &self.groups[group].name;
        let Some((number, topic)) = self.topics.named(name) else { return Ok(None) };
        let path = |slot: usize, wanted: &Wanted| {
            let path = self.paths[group].get(wanted.channel)?.clone()?;
            Some(Want { path, slot })
        };
        let mut wants: Vec<Want> =
            wanted.iter().enumerate().filter_map(|(slot, wanted)| path(slot, wanted)).collect();
        wants.sort();
        let times = wanted.iter().map(|wanted| self.paths[group][wanted.channel].is_none());
        let mut values = Values {
            path: &self.path,
            topics: &self.topics,
            number,
            topic,
            wants,
            times: times.collect(),
            each,
            count: 0,
        };
        let found = self.container.visit(&mut values);
        let count = values.count;
        let ended = self.ended(found)?;
        if ended.is_none() && self.is_finished {
            return Ok(None);
        }
        let ended = ended.or_else(|| self.container.unread());
        let topic = &self.groups[group].name;
        Ok(Some((format!("{count} messages of {topic}"), ended)))
    }
}

/// Takes the values of one topic.
struct Values<'a, 'b> {
    path: &'a std::path::Path,
    topics: &'a Topics,
    number: usize,
    topic: &'a Topic,
    wants: Vec<Want>,
    /// Whether a cell is the time.
    times: Vec<bool>,
    each: Each<'b>,
    count: u64,
}

impl Visitor for Values<'_, '_> {
    fn wants_messages_of(&self, connection: u32) -> bool {
        self.topics.of_connection(connection) == Some(self.number)
    }

    fn message(
        &mut self,
        place: Place,
        _: u32,
        time: u64,
        data: &[u8],
    ) -> Result<(), DatasetError> {
        let time = Cell::Number(self.topics.seconds(time));
        let cell = |is_time: &bool| if *is_time { time.clone() } else { Cell::Missing };
        let mut cells: Vec<Cell> = self.times.iter().map(cell).collect();
        if let Ok((definition, encoding)) = &self.topic.messages {
            decode(definition, *encoding, data, &self.wants, &mut cells).map_err(|why| {
                malformed(self.path, format!("{place}, topic {}: {why}", self.topic.name))
            })?;
        }
        self.count += 1;
        (self.each)(&cells)
    }
}

fn malformed(path: &std::path::Path, why: String) -> DatasetError {
    DatasetError::new(path, Defect::Malformed(why))
}
