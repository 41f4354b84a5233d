//! Functional mock-up units for co-simulation, FMI 2.0 and 3.0, as the physics of described devices.
//!
//! An FMU is a zip file with a description in XML and a shared library. Everything that can be known before it runs is
//! checked when it is opened: the archive with its checksums, the description, the library for this platform and its
//! functions. The library runs in this process: a crash of it is a crash of the process.

mod archive;
mod model;
mod native;
#[cfg(feature = "samples")]
pub mod samples;
mod write;

pub use archive::library_path;
pub use write::write;

use archive::Unpacked;
use described::{Fmu, FmuInstance, FmuVariable};
use model::Model;
use native::{Instance, Library};
use std::path::Path;
use std::sync::Arc;

/// A unit that has been read.
#[derive(Debug)]
pub struct Unit {
    model: Arc<Model>,
    variables: Vec<FmuVariable>,
    /// Absent if only its description is known.
    loaded: Option<Arc<Loaded>>,
}

#[derive(Debug)]
struct Loaded {
    library: Library,
    files: Unpacked,
}

impl Unit {
    /// Opens and loads the FMU in this file. Returns the text of its description too: all that a record keeps of it.
    ///
    /// # Errors
    /// With a readable reason.
    pub fn open(path: &Path) -> Result<(Self, String), String> {
        let mut archive = archive::open(path)?;
        let description = archive.description()?;
        let model = Model::parse(&description)?;
        let files = archive.unpack(&model)?;
        let library = Library::load(&files.library, model.version)?;
        let loaded = Some(Arc::new(Loaded { library, files }));
        Ok((Self { variables: model.variables(), model: Arc::new(model), loaded }, description))
    }

    /// A unit of which only the description is known. It cannot be started.
    ///
    /// # Errors
    /// With a readable reason.
    pub fn described(description: &str) -> Result<Self, String> {
        let model = Model::parse(description)?;
        Ok(Self { variables: model.variables(), model: Arc::new(model), loaded: None })
    }
}

impl Fmu for Unit {
    fn variables(&self) -> &[FmuVariable] {
        &self.variables
    }

    fn step_s(&self) -> Option<f64> {
        self.model.step_s
    }

    fn start(&self, parameters: &[(usize, f64)]) -> Result<Box<dyn FmuInstance>, String> {
        let Some(loaded) = &self.loaded else {
            return Err("only the description of the FMU is here, and not its library".to_owned());
        };
        Ok(Box::new(Instance::start(&self.model, loaded, parameters)?))
    }
}
