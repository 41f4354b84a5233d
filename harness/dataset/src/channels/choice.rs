//! Maps fields to the channels of a file.

use super::super::error::{DatasetError, Defect};
use super::super::package::{Field, Table};
use super::{Group, Wanted};
use identification::dataset::{Role, Unit};
use std::collections::BTreeMap;

/// Indices of fields, and their channels in a group.
pub(super) type Channels = Vec<(usize, Wanted)>;

/// The channels of the fields.
#[derive(Debug)]
pub(super) struct Choice {
    /// The group whose records are the rows.
    pub(super) group: usize,
    /// Channels of that group, in field order.
    pub(super) own: Channels,
    /// Channels of other groups, each list after the time of its group, which counts as the time field.
    pub(super) others: BTreeMap<usize, Channels>,
    /// The time field.
    pub(super) time: Option<usize>,
}

/// Chooses a channel for each field, by name.
pub(super) fn choose(
    groups: &[Group],
    fields: &[Field],
    table: &Table,
) -> Result<Choice, DatasetError> {
    let fail = |defect| DatasetError::new(&table.path, defect);
    let used: Vec<(usize, &Field)> =
        fields.iter().enumerate().filter(|(_, field)| field.role != Role::Ignore).collect();
    let group = match &table.group {
        Some(name) => named(groups, name).map_err(fail)?,
        None => {
            holding(groups, &used).map_err(|(defect, field)| fail(defect).in_field(&field.name))?
        }
    };
    let time = used.iter().find(|(_, field)| field.role == Role::Time).map(|(at, _)| *at);
    let (mut own, mut others) = (Channels::new(), BTreeMap::<usize, Channels>::new());
    for (at, field) in used {
        let inside = |defect| fail(defect).in_field(&field.name);
        let wanted = |channel| Wanted { channel, as_text: field.text };
        let of = |group: usize| groups.get(group).map_or(Vec::new(), |one| find(one, &field.name));
        match of(group)[..] {
            [channel] => {
                own.push((at, wanted(channel)));
                continue;
            }
            [] => {}
            ref several => return Err(inside(Defect::Channels(several.len()))),
        }
        let elsewhere = (0..groups.len())
            .flat_map(|other| of(other).into_iter().map(move |channel| (other, channel)));
        let (other, channel) = match elsewhere.collect::<Vec<_>>()[..] {
            [one] => one,
            [] => return Err(inside(Defect::NoChannel(names(groups)))),
            ref several => return Err(inside(Defect::Channels(several.len()))),
        };
        if let Some(why) = kept_out(field) {
            return Err(inside(Defect::OtherRaster(why)));
        }
        let clock = groups[other].channels.iter().position(|channel| channel.is_time);
        let (Some(clock), Some(time)) = (clock, time) else {
            let why = "it is in another group than the rows, expected both to have times";
            return Err(inside(Defect::OtherRaster(why)));
        };
        let all = others
            .entry(other)
            .or_insert_with(|| vec![(time, Wanted { channel: clock, as_text: false })]);
        all.push((at, wanted(channel)));
    }
    if !others.is_empty() && !has_clock(groups, fields, group, &own) {
        let why = "its channels are in several groups, expected the time to be the master of the rows, in s";
        return Err(fail(Defect::OtherRaster(why)));
    }
    Ok(Choice { group, own, others, time })
}

/// Whether the time field is the master channel of the rows, in seconds, as it must be for channels of other groups.
fn has_clock(groups: &[Group], fields: &[Field], group: usize, own: &Channels) -> bool {
    own.iter().any(|(at, wanted)| {
        let (field, channel) = (&fields[*at], &groups[group].channels[wanted.channel]);
        field.role == Role::Time && field.unit == Unit::Second && channel.is_time
    })
}

/// Why a field cannot be placed into rows with other times.
fn kept_out(field: &Field) -> Option<&'static str> {
    match field.role {
        Role::Time | Role::Run | Role::Direction => {
            Some("it is in another group than the rows, expected it in theirs")
        }
        Role::WheelLeft | Role::WheelRight | Role::GyroAngleIncrement
            if field.role == Role::GyroAngleIncrement || field.unit == Unit::Count =>
        {
            Some("it counts since the row before, and is in another group than the rows")
        }
        _ if field.text => Some("it is text, and is in another group than the rows"),
        _ => None,
    }
}

/// The names of all channels.
fn names(groups: &[Group]) -> Vec<String> {
    groups.iter().flat_map(|group| &group.channels).map(|channel| channel.name.clone()).collect()
}

/// Channels with this name, which may begin with the name of the group and `/`.
fn find(group: &Group, name: &str) -> Vec<usize> {
    let name = name.trim();
    let inside = name.strip_prefix(&group.name).and_then(|rest| rest.strip_prefix('/'));
    let inside = inside.filter(|_| !group.name.is_empty());
    let is_meant = |found: &str| found == name || inside == Some(found);
    let channels = group.channels.iter().enumerate();
    channels.filter(|(_, channel)| is_meant(&channel.name)).map(|(at, _)| at).collect()
}

fn named(groups: &[Group], name: &str) -> Result<usize, Defect> {
    let found: Vec<usize> = (0..groups.len()).filter(|at| groups[*at].name == name).collect();
    if let [one] = found[..] {
        return Ok(one);
    }
    let known = groups.iter().map(|group| group.name.clone()).filter(|name| !name.is_empty());
    Err(Defect::Group { name: name.to_owned(), count: found.len(), known: known.collect() })
}

/// The group with all fields, or otherwise the group with the measured ones.
fn holding<'a>(
    groups: &[Group],
    used: &[(usize, &'a Field)],
) -> Result<usize, (Defect, &'a Field)> {
    let has = |group: &Group, field: &Field| !find(group, &field.name).is_empty();
    let with = |is: &dyn Fn(&Group) -> bool| -> Vec<usize> {
        (0..groups.len()).filter(|at| is(&groups[*at])).collect()
    };
    let whole = with(&|group| used.iter().all(|(_, field)| has(group, field)));
    let measured = used.iter().map(|(_, field)| *field).find(|field| is_measured(field));
    let Some(measured) = measured.or(used.first().map(|(_, field)| *field)) else { return Ok(0) };
    let found = if whole.is_empty() { with(&|group| has(group, measured)) } else { whole };
    match found[..] {
        [one] => Ok(one),
        [] => Err((Defect::NoChannel(names(groups)), measured)),
        ref several => Err((Defect::Channels(several.len()), measured)),
    }
}

/// Whether a sensor measured it, as opposed to a reference or an influence.
fn is_measured(field: &Field) -> bool {
    let beside = matches!(
        field.role,
        Role::Time | Role::Run | Role::Auxiliary | Role::Temperature | Role::Heading
    );
    !beside && !field.role.is_reference()
}
