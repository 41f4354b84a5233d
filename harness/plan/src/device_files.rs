//! Device files: the gyro and its carrier, with the models that the file names.

use crate::library::{Kind, Library, LibraryError};
use crate::models::{self, ModelError};
use emulators::device_file::{
    BaseModel, DeviceFile, DeviceFileError, Devices, GyroModel, Learned, ModelSource, TableModel,
};

/// Why a device file cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum DevicesError {
    /// The file, or a file that it names, is missing or invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Library(#[from] LibraryError),
    /// The sections of the file do not fit together.
    #[error("{origin}: {message}")]
    Unfit {
        /// Path of the file.
        origin: String,
        /// What does not fit.
        message: String,
    },
}

struct Models<'a>(&'a Library);

impl ModelSource for Models<'_> {
    type Error = DevicesError;

    fn gyro(&mut self, name: &str) -> Result<GyroModel, DevicesError> {
        Ok(self.0.read(Kind::GyroModel, name)?.1)
    }

    fn base(&mut self, name: &str) -> Result<BaseModel, DevicesError> {
        Ok(self.0.read(Kind::BaseModel, name)?.1)
    }

    fn table(&mut self, name: &str) -> Result<TableModel, DevicesError> {
        Ok(self.0.read(Kind::TableModel, name)?.1)
    }

    fn learned(&mut self, name: &str) -> Result<Learned, DevicesError> {
        let unfit = |origin, message| DevicesError::Unfit { origin, message };
        let (origin, model) = models::read(self.0, name).map_err(|error| match error {
            ModelError::Library(error) => error.into(),
            error => unfit(name.to_owned(), error.to_string()),
        })?;
        models::learned(&model).map_err(|refused| unfit(origin, refused.to_string()))
    }
}

/// Returns the devices that a device file describes.
///
/// # Errors
/// When the file, or a model that it names, is missing or invalid.
pub fn load_devices(library: &Library, name: &str) -> Result<Devices, DevicesError> {
    let (origin, file): (String, DeviceFile) = library.read(Kind::Devices, name)?;
    file.resolve(&mut Models(library)).map_err(|error| match error {
        DeviceFileError::Model { source, .. } => source,
        error => DevicesError::Unfit { origin, message: error.to_string() },
    })
}
