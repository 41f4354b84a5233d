//! Bench files: which port plays which role, and which program is the device under test.
//!
//! ```toml
//! title = "The bench by the window"
//!
//! [gyro]
//! port = "/dev/ttyUSB0"       # without this table the gyro is emulated, on a pty
//!
//! [base]
//! port = "/dev/ttyUSB1"
//!
//! [controller]
//! command = ["./my-controller", "--gyro", "{gyro}", "--base", "serial:{base}"]
//! ```

use crate::library::{Kind, Library, LibraryError};
use serde::Deserialize;
use std::collections::BTreeMap;

/// A bench.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BenchFile {
    /// What it is, in a line.
    #[serde(default)]
    pub title: String,
    /// The gyro's port; emulated where it is absent.
    pub gyro: Option<PortSection>,
    /// The base's port; emulated where it is absent.
    pub base: Option<PortSection>,
    /// The device under test; our controller where it is absent.
    pub controller: Option<ControllerSection>,
}

/// A role that a real port plays.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PortSection {
    /// As the device under test is told: a path such as `/dev/ttyUSB0`.
    pub port: String,
}

/// A program that is the device under test.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerSection {
    /// Its command line; `{gyro}` and `{base}` stand for the ports.
    pub command: Vec<String>,
}

impl BenchFile {
    /// Reads the bench of that name or path.
    ///
    /// # Errors
    ///
    /// When it is missing or not right.
    pub fn load(name: &str) -> Result<Self, LibraryError> {
        Ok(Library::shipped().read(Kind::Bench, name)?.1)
    }

    /// Real ports by role.
    pub fn ports(&self) -> BTreeMap<String, String> {
        [("gyro", &self.gyro), ("base", &self.base)]
            .into_iter()
            .filter_map(|(role, section)| Some((role.to_owned(), section.as_ref()?.port.clone())))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::BenchFile;

    #[test]
    fn a_role_without_a_port_is_emulated() {
        let bench: BenchFile = toml::from_str("[gyro]\nport = \"/dev/ttyUSB0\"").unwrap();
        assert_eq!(
            bench.ports().into_iter().collect::<Vec<_>>(),
            [("gyro".to_owned(), "/dev/ttyUSB0".to_owned())]
        );
        assert!(toml::from_str::<BenchFile>("[gyro]\nprot = \"x\"").is_err());
    }
}
