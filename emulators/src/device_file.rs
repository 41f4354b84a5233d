//! Device files: the devices of a run and their imperfections.
//!
//! A **model file** describes one kind of device (`gyros/navigator.toml`); a **device file** combines models
//! (`paper.toml`) and may change single parameters. This module does not read from disk: the caller deserialises the
//! files and passes a [`ModelSource`] that finds models by name.
//!
//! ```toml
//! title = "The paper's robot"
//! mount = "base"
//!
//! [gyro]
//! model = "navigator"
//! parameters = { ambient_celsius = 24 }
//!
//! [base]
//! model = "k2a"
//! transport = "can"
//! ```
//!
//! A gyro may have error terms of its own (`[[gyro.terms]]`, see [`Term`]) and those of an identified model
//! (`learned = "name"`).

use crate::absolute::AbsoluteParameters;
use crate::base::{BaseParameters, Transport};
use crate::gyro::GyroParameters;
use crate::gyro::terms::Term;
use crate::parameters::{self, ParameterError, Parameters};
use crate::table::TableParameters;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use thiserror::Error;
use wire::gyro::{GyroStream, OutputMode};

/// What carries the gyro.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mount {
    /// The turret of the base.
    Base,
    /// The rotary table.
    Table,
}

/// A device file: the combination of a gyro, a base, a table and an absolute measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DeviceFile {
    /// Title in one line.
    pub title: String,
    /// Where its numbers come from.
    #[serde(default)]
    pub source: String,
    /// What carries the gyro.
    pub mount: Mount,
    /// The gyro.
    pub gyro: GyroSection,
    /// The base, needed where it carries the gyro.
    pub base: Option<BaseSection>,
    /// The table, needed where it carries the gyro.
    pub table: Option<TableSection>,
    /// The absolute measurement; without it, one without errors.
    #[serde(default)]
    pub absolute: AbsoluteParameters,
}

/// The gyro of a [`DeviceFile`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GyroSection {
    /// Name of a [`GyroModel`].
    pub model: String,
    /// Another output mode than the model's.
    #[serde(default)]
    #[schemars(schema_with = "mode_schema")]
    pub mode: Option<OutputMode>,
    /// Mounted the other way round than the model says: axis down, or up.
    #[serde(default)]
    pub upside_down: bool,
    /// Parameters that differ from the model's.
    #[serde(default)]
    #[schemars(schema_with = "changes_schema::<GyroParameters>")]
    pub parameters: BTreeMap<String, f64>,
    /// Name of a model that was identified: the gyro errs as it says, on top of everything else.
    pub learned: Option<String>,
    /// Further error terms.
    #[serde(default)]
    pub terms: Vec<Term>,
}

/// An identified model of a gyro.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Learned {
    /// Error terms.
    pub terms: Vec<Term>,
    /// Named parameters.
    pub parameters: BTreeMap<String, f64>,
}

/// The base of a [`DeviceFile`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaseSection {
    /// Name of a [`BaseModel`].
    pub model: String,
    /// How it is connected.
    pub transport: Transport,
    /// Parameters that differ from the model's.
    #[serde(default)]
    #[schemars(schema_with = "changes_schema::<BaseParameters>")]
    pub parameters: BTreeMap<String, f64>,
}

/// The table of a [`DeviceFile`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableSection {
    /// Name of a [`TableModel`].
    pub model: String,
    /// Parameters that differ from the model's.
    #[serde(default)]
    #[schemars(schema_with = "changes_schema::<TableParameters>")]
    pub parameters: BTreeMap<String, f64>,
}

/// A kind of gyro.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GyroModel {
    /// Title in one line.
    pub title: String,
    /// Where its numbers come from.
    #[serde(default)]
    pub source: String,
    /// Its stream.
    #[schemars(schema_with = "stream_schema")]
    pub stream: GyroStream,
    /// Its imperfections.
    #[serde(default)]
    pub parameters: GyroParameters,
}

/// A kind of base.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaseModel {
    /// Title in one line.
    pub title: String,
    /// Where its numbers come from.
    #[serde(default)]
    pub source: String,
    /// Its limits and imperfections.
    #[serde(default)]
    pub parameters: BaseParameters,
}

/// A kind of table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableModel {
    /// Title in one line.
    pub title: String,
    /// Where its numbers come from.
    #[serde(default)]
    pub source: String,
    /// Its limits and imperfections.
    #[serde(default)]
    pub parameters: TableParameters,
}

/// Single parameters of a device; those of a term by its index, as in `terms.0.slope`.
fn changes_schema<P: Parameters>(_: &mut SchemaGenerator) -> Schema {
    let mut schema = parameters::schema::changes(P::TABLE);
    let terms = json_schema!({ "type": "number" });
    schema.insert(
        "patternProperties".to_owned(),
        json_schema!({ r"^terms\.\d+\.\w+$": terms }).into(),
    );
    schema
}

/// [`OutputMode`] in its serialised form.
fn mode_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": ["rate", "increment", "integrated"] })
}

/// [`GyroStream`] in its serialised form.
fn stream_schema(generator: &mut SchemaGenerator) -> Schema {
    let mut mode = mode_schema(generator);
    mode.insert("default".to_owned(), "rate".into());
    json_schema!({
        "type": "object",
        "properties": {
            "format": {
                "enum": ["navigator", "ecore2000", "dsp3000-ascii", "dsp3000-binary"],
                "description": "The format on the wire."
            },
            "mode": mode,
            "reversed": {
                "type": "boolean",
                "default": false,
                "description": "The maker's positive direction is clockwise, or the axis points down."
            }
        },
        "required": ["format"],
        "additionalProperties": false
    })
}

/// Finds models by name, in files or embedded in a program.
pub trait ModelSource {
    /// Reason why a model was not found or not understood.
    type Error;

    /// The gyro model `name`.
    fn gyro(&mut self, name: &str) -> Result<GyroModel, Self::Error>;
    /// The base model `name`.
    fn base(&mut self, name: &str) -> Result<BaseModel, Self::Error>;
    /// The table model `name`.
    fn table(&mut self, name: &str) -> Result<TableModel, Self::Error>;
    /// The identified gyro model `name`.
    fn learned(&mut self, name: &str) -> Result<Learned, Self::Error>;
}

/// Specification of all devices of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Devices {
    /// The carrier of the gyro.
    pub mount: Mount,
    /// The gyro's stream, and its imperfections.
    pub gyro: (GyroStream, GyroParameters),
    /// The base.
    pub base: Option<(Transport, BaseParameters)>,
    /// The table.
    pub table: Option<TableParameters>,
    /// The absolute measurement.
    pub absolute: AbsoluteParameters,
}

impl Devices {
    /// Sets a parameter of a device, as a plan step does; `None` if the bench has no such device.
    ///
    /// # Errors
    /// If the device has no parameter of that name, or the value is out of range.
    pub fn set(
        &mut self,
        device: &str,
        name: &str,
        value: f64,
    ) -> Option<Result<(), ParameterError>> {
        let carried_by_base = self.mount == Mount::Base;
        match (device, &mut self.base, &mut self.table) {
            ("gyro", ..) => Some(self.gyro.1.set(name, value)),
            ("absolute", ..) => Some(self.absolute.set(name, value)),
            ("base", Some((_, base)), _) if carried_by_base => Some(base.set(name, value)),
            ("table", _, Some(table)) if !carried_by_base => Some(table.set(name, value)),
            _ => None,
        }
    }
}

/// Reason why a device file is invalid.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DeviceFileError<E> {
    /// A model was not found or not understood.
    #[error("failed to load the model of [{section}]")]
    Model {
        /// The section that names it.
        section: &'static str,
        /// The reason.
        source: E,
    },
    /// A parameter does not exist or its value is out of range.
    #[error("[{section}]: {error}")]
    Parameter {
        /// The section that sets it, or names the model that sets it.
        section: &'static str,
        /// The error.
        error: ParameterError,
    },
    /// The gyro is mounted on a device that the file lacks.
    #[error("the gyro is mounted on the {0:?}, which the file does not have")]
    NoCarrier(Mount),
}

impl DeviceFile {
    /// Loads the models and applies the changes of the file; checks every value.
    pub fn resolve<S: ModelSource>(
        &self,
        models: &mut S,
    ) -> Result<Devices, DeviceFileError<S::Error>> {
        let failed = |section| move |source| DeviceFileError::Model { section, source };
        let carried = match self.mount {
            Mount::Base => self.base.is_some(),
            Mount::Table => self.table.is_some(),
        };
        if !carried {
            return Err(DeviceFileError::NoCarrier(self.mount));
        }

        let model = models.gyro(&self.gyro.model).map_err(failed("gyro"))?;
        let mut stream = model.stream;
        stream.mode = self.gyro.mode.unwrap_or(stream.mode);
        stream.reversed ^= self.gyro.upside_down;
        let mut parameters = model.parameters;
        if let Some(name) = &self.gyro.learned {
            let learned = models.learned(name).map_err(failed("gyro"))?;
            parameters.terms.extend(learned.terms);
            parameters = adjusted("gyro", parameters, &learned.parameters)?;
        }
        parameters.terms.extend(self.gyro.terms.iter().cloned());
        let gyro = (stream, adjusted("gyro", parameters, &self.gyro.parameters)?);

        let mut base = None;
        if let Some(section) = &self.base {
            let model = models.base(&section.model).map_err(failed("base"))?;
            let parameters = adjusted("base", model.parameters, &section.parameters)?;
            base = Some((section.transport, parameters));
        }
        let mut table = None;
        if let Some(section) = &self.table {
            let model = models.table(&section.model).map_err(failed("table"))?;
            table = Some(adjusted("table", model.parameters, &section.parameters)?);
        }
        let absolute = adjusted("absolute", self.absolute.clone(), &BTreeMap::new())?;
        Ok(Devices { mount: self.mount, gyro, base, table, absolute })
    }
}

fn adjusted<P: Parameters, E>(
    section: &'static str,
    mut parameters: P,
    changes: &BTreeMap<String, f64>,
) -> Result<P, DeviceFileError<E>> {
    parameters
        .check()
        .and_then(|()| changes.iter().try_for_each(|(name, value)| parameters.set(name, *value)))
        .map_err(|error| DeviceFileError::Parameter { section, error })?;
    Ok(parameters)
}
