//! Electronic data sheets (CiA 306): INI files that describe the object dictionary of a device. A DCF is one with the
//! values of a configured device.
//!
//! A registry crate for INI files would lose the positions of keys, without which no mistake has a place.

use super::dictionary::{APPLICATION, Dictionary, Entry, Kind};
use super::objects::ERROR_HISTORY;
use crate::error::FileError;
use crate::expression::is_reserved;
use crate::layout::{Coding, Note, Scale};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Types of objects with sub-indices: ARRAY and RECORD (CiA 301, table 42).
const WITH_SUBS: [i128; 2] = [8, 9];
/// Definitions of types, which have no values: DEFTYPE and DEFSTRUCT.
const TYPES: [i128; 2] = [5, 6];
/// Type of an object of any bytes.
const DOMAIN: i128 = 2;
/// `DataType` of an object of any bytes.
const DOMAIN_TYPE: i128 = 0x0F;

struct Section<'a> {
    at: Range<usize>,
    keys: BTreeMap<String, (&'a str, Range<usize>)>,
}

struct Reader<'a> {
    file: &'a str,
    text: &'a str,
    node_id: u8,
    /// By name in lower case.
    sections: BTreeMap<String, Section<'a>>,
    entries: Vec<Entry>,
    notes: Vec<Note>,
}

/// The node identifier of a DCF.
pub(super) fn commissioned(text: &str) -> Option<u8> {
    let sections = sections("", text).ok()?;
    // So misspelt in the standard.
    let (value, _) = sections.get("devicecomissioning")?.keys.get("nodeid")?;
    number(value, 0).and_then(|id| u8::try_from(id).ok())
}

/// Reads the dictionary of the device with this node identifier.
///
/// # Errors
/// With the place of the first mistake.
pub(super) fn dictionary(file: &str, text: &str, node_id: u8) -> Result<Dictionary, FileError> {
    let sections = sections(file, text)?;
    let mut reader =
        Reader { file, text, node_id, sections, entries: Vec::new(), notes: Vec::new() };
    reader.check_lists()?;
    let indices: BTreeSet<u16> = reader.sections.keys().filter_map(|name| index(name)).collect();
    for index in indices {
        reader.object(index)?;
    }
    if reader.entries.is_empty() {
        return Err(reader.mistake(0..text.len().min(1), "the file describes no objects"));
    }
    reader.entries.sort_by_key(|entry| (entry.index, entry.sub));
    let mut names = BTreeSet::new();
    for entry in &mut reader.entries {
        let is_free = !is_reserved(&entry.name) && names.insert(entry.name.clone());
        if entry.index >= APPLICATION && !is_free {
            entry.name = format!("{}_{:04x}sub{:x}", entry.name, entry.index, entry.sub);
            names.insert(entry.name.clone());
        }
    }
    Ok(Dictionary { node_id, entries: reader.entries, notes: reader.notes })
}

fn sections<'a>(file: &str, text: &'a str) -> Result<BTreeMap<String, Section<'a>>, FileError> {
    let mut sections: BTreeMap<String, Section<'a>> = BTreeMap::new();
    let (mut current, mut begin) = (None, 0);
    for line in text.split_inclusive('\n') {
        let at = begin..begin + line.trim_end().len();
        begin += line.len();
        let line = line.trim().trim_start_matches('\u{feff}');
        let wrong = |message: &str| FileError::new(file, text, at.clone(), message.to_owned());
        if line.is_empty() || line.starts_with([';', '#']) {
            continue;
        }
        if let Some(name) = line.strip_prefix('[') {
            let name = name.strip_suffix(']').ok_or_else(|| wrong("a section without its `]`"))?;
            let name = name.trim().to_ascii_lowercase();
            let section = Section { at: at.clone(), keys: BTreeMap::new() };
            if sections.insert(name.clone(), section).is_some() {
                return Err(wrong("the file has this section twice"));
            }
            current = Some(name);
            continue;
        }
        let section = current.as_ref().and_then(|name| sections.get_mut(name));
        let section = section.ok_or_else(|| wrong("expected a `[section]` first"))?;
        let (key, value) = line.split_once('=').ok_or_else(|| wrong("expected `key=value`"))?;
        section.keys.insert(key.trim().to_ascii_lowercase(), (without_comment(value), at.clone()));
    }
    Ok(sections)
}

/// The value of a key without the comment that some tools write behind it: ` ; UNSIGNED8`.
fn without_comment(value: &str) -> &str {
    let comment = value.match_indices(';').map(|(at, _)| &value[..at]);
    let mut before = comment.filter(|before| before.is_empty() || before.ends_with([' ', '\t']));
    before.next().unwrap_or(value).trim()
}

/// The index of an object whose section has this name.
fn index(section: &str) -> Option<u16> {
    let is_index = section.len() == 4 && section.bytes().all(|byte| byte.is_ascii_hexdigit());
    is_index.then(|| u16::from_str_radix(section, 16).ok()).flatten()
}

/// The sub-index in the name of a section, `1018sub1`.
fn sub_index(section: &str, index: u16) -> Option<u8> {
    u8::from_str_radix(section.strip_prefix(&format!("{index:04x}sub"))?, 16).ok()
}

/// A number in the notation of C, or a sum with `$NODEID`.
fn number(text: &str, node_id: u8) -> Option<i128> {
    let term = |term: &str| {
        let term = term.trim();
        if term.eq_ignore_ascii_case("$nodeid") {
            return Some(i128::from(node_id));
        }
        let (sign, digits) = match term.strip_prefix('-') {
            Some(digits) => (-1, digits),
            None => (1, term),
        };
        let lower = digits.to_ascii_lowercase();
        let parsed = match (lower.strip_prefix("0x"), lower.strip_prefix('0')) {
            (Some(hex), _) => u64::from_str_radix(hex, 16),
            (None, Some(octal)) if !octal.is_empty() => u64::from_str_radix(octal, 8),
            _ => lower.parse(),
        };
        parsed.ok().map(|parsed| sign * i128::from(parsed))
    };
    text.split('+').map(term).sum()
}

/// A name for expressions: lower case, and `_` for everything but letters and digits.
fn identifier(title: &str) -> String {
    let letters = title.to_ascii_lowercase();
    let words = letters.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let name = words.collect::<Vec<_>>().join("_");
    match name.chars().next() {
        Some(first) if first.is_ascii_alphabetic() => name,
        _ => format!("object_{name}"),
    }
}

impl<'a> Reader<'a> {
    fn mistake(&self, at: Range<usize>, message: impl Into<String>) -> FileError {
        FileError::new(self.file, self.text, at, message.into())
    }

    fn value(&self, section: &str, key: &str) -> Option<(&'a str, Range<usize>)> {
        let (value, at) = self.sections.get(section)?.keys.get(key)?;
        (!value.is_empty()).then(|| (*value, at.clone()))
    }

    /// The number of a key; `None` if the section has no such key or it is empty.
    fn number(&self, section: &str, key: &str) -> Result<Option<i128>, FileError> {
        let Some((text, at)) = self.value(section, key) else { return Ok(None) };
        let number = number(text, self.node_id);
        let wrong = || self.mistake(at, format!("`{text}` is not a number"));
        number.map(Some).ok_or_else(wrong)
    }

    /// Checks that each listed object has a section: a file that was cut short lacks one.
    fn check_lists(&self) -> Result<(), FileError> {
        for list in ["mandatoryobjects", "optionalobjects", "manufacturerobjects"] {
            let count = self.number(list, "supportedobjects")?.unwrap_or(0);
            let at = || self.value(list, "supportedobjects").map_or(0..0, |(_, at)| at);
            for place in 1..=count {
                let Some(listed) = self.number(list, &place.to_string())? else {
                    let message = format!("object {place} of the list of {count} is missing");
                    return Err(self.mistake(at(), message));
                };
                if !self.sections.contains_key(&format!("{listed:04x}")) {
                    let at = self.value(list, &place.to_string()).map_or(0..0, |(_, at)| at);
                    let message = format!("the file has no section [{listed:04X}]");
                    let help = "it is listed here: is the file cut short?".to_owned();
                    return Err(self.mistake(at, message).with_help(Some(help)));
                }
            }
        }
        Ok(())
    }

    /// Notes what is done about a defect of a section.
    fn note(&mut self, section: &str, at: &Range<usize>, what: String) {
        self.notes.push(Note {
            file: self.file.to_owned(),
            line: self.text[..at.start].matches('\n').count() + 1,
            message: format!("[{section}]"),
            signal: None,
            is_left_out: false,
            what,
        });
    }

    fn object(&mut self, index: u16) -> Result<(), FileError> {
        let section = format!("{index:04x}");
        let kind = self.number(&section, "objecttype")?.unwrap_or(7);
        if TYPES.contains(&kind) {
            return Ok(());
        }
        if !WITH_SUBS.contains(&kind) {
            return self.entry(index, 0, &section, None);
        }
        let title = self.value(&section, "parametername").map_or("", |(title, _)| title).to_owned();
        let compact = self.number(&section, "compactsubobj")?.unwrap_or(0);
        if let Some(compact) = u8::try_from(compact).ok().filter(|compact| *compact > 0) {
            return self.compact(index, &section, &title, compact);
        }
        let subs: Vec<(String, u8)> = (self.sections.keys())
            .filter_map(|name| Some((name.clone(), sub_index(name, index)?)))
            .collect();
        let said = self.number(&section, "subnumber")?;
        // Files of makers have the wrong number: what counts is what is there.
        if said.is_none_or(|said| said != subs.len() as i128) {
            let at = self.value(&section, "subnumber").map(|(_, at)| at);
            let at = at.unwrap_or_else(|| self.sections[&section].at.clone());
            let said = said.map_or("nothing".to_owned(), |said| said.to_string());
            let what = format!(
                "its SubNumber says {said}, and the file has {} sub-indices: these are used",
                subs.len()
            );
            self.note(&format!("{index:04X}"), &at, what);
        }
        subs.iter().try_for_each(|(name, sub)| self.entry(index, *sub, name, Some(&title)))
    }

    /// An array whose elements are alike (CIA 306, 4.6.3.6 "CompactSubObj").
    fn compact(
        &mut self,
        index: u16,
        section: &str,
        title: &str,
        count: u8,
    ) -> Result<(), FileError> {
        self.entry(index, 1, section, Some(title))?;
        let Some(first) = self.entries.pop() else { return Ok(()) };
        let limits = (0.0, f64::from(u8::MAX));
        let kind = Kind::Number(Coding::Unsigned, 8);
        // That of the history is the number of errors so far, and a master clears it (CiA 301, 7.5.2.4).
        let is_history = index == ERROR_HISTORY;
        let number =
            Entry { sub: 0, kind, writable: is_history, mappable: false, limits, ..first.clone() };
        self.entries.push(Entry {
            start: vec![if is_history { 0 } else { count }],
            name: format!("{}_0", first.name),
            ..number
        });
        for sub in 1..=count {
            let named = self.value(&format!("{section}name"), &sub.to_string());
            let value = self.value(&format!("{section}value"), &sub.to_string());
            let own = named.map_or_else(|| format!("{title} {sub}"), |(own, _)| own.to_owned());
            let mut entry = Entry { sub, name: identifier(&own), title: own, ..first.clone() };
            if let Some((text, at)) = value {
                (entry.start, entry.at) = (self.bytes(entry.kind, text, &at)?, at);
            }
            self.entries.push(entry);
        }
        Ok(())
    }

    /// The object of a section; `of` is the name of the record or array that it belongs to.
    fn entry(
        &mut self,
        index: u16,
        sub: u8,
        section: &str,
        of: Option<&str>,
    ) -> Result<(), FileError> {
        let whole = self.sections[section].at.clone();
        let wrong = |message: String| self.mistake(whole.clone(), message);
        let is_domain = self.number(section, "objecttype")? == Some(DOMAIN);
        let fallback = if is_domain { Some(DOMAIN_TYPE) } else { None };
        let data_type = self.number(section, "datatype")?.or(fallback);
        let data_type = data_type.and_then(|number| u64::try_from(number).ok());
        let data_type = data_type.ok_or_else(|| wrong("the section has no DataType".to_owned()))?;
        // A type of the manufacturer: its bytes can be transferred all the same.
        let kind = Kind::of(data_type).unwrap_or(Kind::Bytes);
        let access = self.value(section, "accesstype");
        let access = access.ok_or_else(|| wrong("the section has no AccessType".to_owned()))?;
        let (readable, writable) = match access.0.to_ascii_lowercase().as_str() {
            "ro" | "const" => (true, false),
            "wo" => (false, true),
            "rw" | "rwr" | "rww" => (true, true),
            other => {
                let message = format!("`{other}` is no AccessType");
                let help = "one of ro, wo, rw, rwr, rww and const".to_owned();
                return Err(self.mistake(access.1, message).with_help(Some(help)));
            }
        };
        let title = self.value(section, "parametername").map_or("", |(title, _)| title).to_owned();
        let value = self.value(section, "parametervalue").or(self.value(section, "defaultvalue"));
        let (start, at) = match value {
            Some((text, at)) => (self.bytes(kind, text, &at)?, at),
            None => (vec![0; kind.bytes()], whole.clone()),
        };
        let full = of.map_or_else(|| title.clone(), |of| format!("{of} {title}"));
        let limits = self.limits(section, kind)?;
        let mappable = self.number(section, "pdomapping")? == Some(1);
        let (unit, scale) = (String::new(), Scale::ONE);
        let name = identifier(&full);
        self.entries.push(Entry {
            index,
            sub,
            name,
            title,
            kind,
            readable,
            writable,
            mappable,
            limits,
            start,
            unit,
            scale,
            at,
        });
        Ok(())
    }

    /// The limits of a number, within those of its type. Limits that contradict each other are noted and not used.
    fn limits(&mut self, section: &str, kind: Kind) -> Result<(f64, f64), FileError> {
        let Kind::Number(coding, bits) = kind else { return Ok((f64::MIN, f64::MAX)) };
        let (least, greatest) = coding.limits(bits);
        let limit = |key: &str| -> Result<Option<f64>, FileError> {
            let Some((text, at)) = self.value(section, key) else { return Ok(None) };
            let bytes = self.bytes(kind, text, &at)?;
            Ok(Some(coding.number(super::dictionary::unsigned(&bytes), bits)))
        };
        let ends = (limit("lowlimit")?.unwrap_or(least), limit("highlimit")?.unwrap_or(greatest));
        if ends.0 <= ends.1 {
            return Ok(ends);
        }
        let at = self.value(section, "highlimit").map_or(0..0, |(_, at)| at);
        let (low, high) = ends;
        let what = format!("its HighLimit {high} is below its LowLimit {low}: neither is used");
        self.note(section, &at, what);
        Ok((least, greatest))
    }

    /// The bytes of a value. Hexadecimal numbers of signed types may be their two's complement.
    fn bytes(&self, kind: Kind, text: &str, at: &Range<usize>) -> Result<Vec<u8>, FileError> {
        let Kind::Number(coding, bits) = kind else { return Ok(text.as_bytes().to_vec()) };
        let bytes = kind.bytes();
        let number = number(text, self.node_id);
        let raw = match coding {
            Coding::Float32 | Coding::Float64 => {
                let number = text.parse().ok().or(number.map(|number| number as f64));
                number.filter(|number: &f64| number.is_finite()).map(|number| match coding {
                    Coding::Float32 => u64::from((number as f32).to_bits()),
                    _ => number.to_bits(),
                })
            }
            _ => number
                .filter(|number| (-(1i128 << (bits - 1))..1i128 << bits).contains(number))
                .filter(|number| *number >= 0 || coding == Coding::Signed)
                .map(|number| number as u64),
        };
        let message = || format!("`{text}` is no number of {bits} bits");
        let raw = raw.ok_or_else(|| self.mistake(at.clone(), message()))?;
        Ok(raw.to_le_bytes()[..bytes].to_vec())
    }
}
