//! Objects and errors of a CANopen device.

use super::formula::formula;
use super::scope::Local;
use super::source::{Source, source};
use super::variables::Variables;
use crate::canopen::Dictionary;
use crate::error::{Mistake, Read};
use crate::expression::Expression;
use crate::file::File;
use crate::files::Files;
use crate::place::Place;
use std::collections::BTreeMap;
use std::sync::Arc;

#[derive(Debug, Clone)]
pub(crate) struct Canopen {
    pub(crate) dictionary: Arc<Dictionary>,
    /// Objects with a value of the application, by their place in the dictionary.
    pub(crate) objects: BTreeMap<usize, Object>,
    pub(crate) errors: Vec<(u16, Expression)>,
}

#[derive(Debug, Clone)]
pub(crate) enum Object {
    /// In a variable, which masters and machines set.
    Variable(usize),
    /// In what computes it.
    Computed(Box<Source>),
}

/// The objects and the errors of the file.
pub(super) fn canopen(
    said: &File,
    dictionary: &Arc<Dictionary>,
    variables: &Variables,
    files: &mut dyn Files,
) -> Read<Canopen> {
    let scope = Local { scope: variables, index: None, has_parts: false };
    let mut objects = BTreeMap::new();
    for (place, entry) in dictionary.application() {
        let table = said.object.get(entry.name()).filter(|table| table.is_computed());
        let object = match table {
            Some(table) => {
                let at = Place::file().key("object").key(entry.name());
                if !entry.readable {
                    let message = format!("`{}` can only be written", entry.name());
                    let help = "it is a name in expressions, with what the master wrote";
                    return Err(Mistake::new(at.name(), message).help(help));
                }
                let said = source(&table.source(), &entry.unit, &scope, &at, files)?;
                Object::Computed(Box::new(said.source))
            }
            None => match variables.inner(entry.name()) {
                Some(slot) => Object::Variable(slot),
                None => continue,
            },
        };
        objects.insert(place, object);
    }
    let mut errors = Vec::new();
    for (name, table) in &said.emergency {
        let at = Place::file().key("emergency").key(name);
        if table.code < 0x1000 {
            let message = format!("{:#06x} is no error code", table.code);
            let help = "from 0x1000 to 0xFFFF, by CiA 301 and the profile of the device";
            return Err(Mistake::new(at.key("code"), message).help(help));
        }
        errors.push((table.code, formula(&table.when, &scope, &at.key("when"))?));
    }
    Ok(Canopen { dictionary: Arc::clone(dictionary), objects, errors })
}
