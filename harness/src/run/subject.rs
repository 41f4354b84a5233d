//! What a plan is carried out on.

use crate::faults::BenchLines;
use crate::library::{Kind, Library, LibraryError, Source};
use crate::models::learned;
use crate::plan::{Plan, PlanError};
use crate::world::bench::{DevicesError, bench_lines, load_devices};
use described::{Description, DescriptionError, Files};
use emulators::device_file::Devices;
use emulators::gyro::terms::SensorErrors;
use identification::finding::SCHEMA;
use identification::model::Model;
use std::sync::Arc;

/// What a plan is carried out on.
#[derive(Debug, Clone)]
pub enum Subject {
    /// A gyro on a robot or a table, with a controller that is tested.
    Robot(Box<Devices>),
    /// A device of the user's own, which is tested.
    Device(Arc<Description>),
}

/// Why the description of a device cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum SubjectError {
    /// The device file is not right.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Devices(#[from] DevicesError),
    /// The description cannot be had.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Library(#[from] LibraryError),
    /// The description is not right.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Description(#[from] Box<DescriptionError>),
}

impl Subject {
    /// What `plan` names.
    ///
    /// # Errors
    ///
    /// When it is missing or not right.
    pub fn of(library: &Library, plan: &Plan) -> Result<Self, SubjectError> {
        if let Some(name) = &plan.device {
            return Ok(Self::Device(Arc::new(load_description(library, name.as_str())?)));
        }
        let name = plan.devices.as_ref().map_or("", |name| name.as_str());
        Ok(Self::Robot(Box::new(load_devices(library, name)?)))
    }

    /// Checks that it has what `plan` speaks of; `file` and `text` are those that the plan was read from.
    ///
    /// # Errors
    ///
    /// The first that it has not, with its place.
    pub fn check(&self, plan: &Plan, file: &str, text: &str) -> Result<(), PlanError> {
        match self {
            Self::Robot(devices) => plan.check_bench(file, text, self.lines(), devices.gyro.0),
            Self::Device(device) => plan.check_device(file, text, device),
        }
    }

    /// What there is for faults to strike.
    pub fn lines(&self) -> BenchLines {
        match self {
            Self::Robot(devices) => bench_lines(devices),
            Self::Device(description) => BenchLines::of_device(description),
        }
    }

    /// The robot or table, if it is one.
    pub const fn robot(&self) -> Option<&Devices> {
        match self {
            Self::Robot(devices) => Some(&**devices),
            Self::Device(_) => None,
        }
    }

    /// The device of the user's own, if it is one.
    pub const fn device(&self) -> Option<&Arc<Description>> {
        match self {
            Self::Robot(_) => None,
            Self::Device(description) => Some(description),
        }
    }
}

/// The description of that name or path. Files that it names are beside it.
///
/// # Errors
///
/// When it, or one of those, is missing or not right.
pub fn load_description(library: &Library, name: &str) -> Result<Description, SubjectError> {
    let source = library.open(Kind::Description, name)?;
    let Source { origin, text } = &source;
    let mut files = Beside { library, source: &source };
    Ok(Description::parse_with(origin, text, &mut files).map_err(Box::new)?)
}

/// The files beside a description.
struct Beside<'a> {
    library: &'a Library,
    source: &'a Source,
}

impl Files for Beside<'_> {
    fn text(&mut self, name: &str) -> Result<String, String> {
        let opened = self.library.open_beside(self.source, name);
        opened.map(|opened| opened.text).map_err(|error| error.to_string())
    }

    fn errors(&mut self, name: &str) -> Result<SensorErrors, String> {
        let text = self.text(name)?;
        let model = Model::from_toml(&text).map_err(|error| error.message().to_owned())?;
        if model.schema != SCHEMA {
            return Err(format!("schema {}, expected {SCHEMA}", model.schema));
        }
        SensorErrors::of(learned(&model).map_err(|refused| refused.to_string())?)
    }
}
