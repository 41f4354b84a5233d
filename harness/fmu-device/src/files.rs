//! The files of a device among the resources of a unit.

use described::{Description, FileError, Files, Steps};
use percent_encoding::{AsciiSet, CONTROLS, utf8_percent_encode};
use std::path::Path;

/// The device file among the resources.
pub const DEVICE: &str = "device.toml";

/// No other folder, and nothing that decoding would change.
const NAME: &AsciiSet = &CONTROLS.add(b'/').add(b'%');

/// The name among the resources of a file that the device file calls `name`.
pub fn packed(name: &str) -> String {
    format!("file-{}", utf8_percent_encode(name, NAME))
}

struct Resources<'a>(&'a Path);

impl Files for Resources<'_> {
    fn text(&mut self, name: &str) -> Result<String, String> {
        std::fs::read_to_string(self.0.join(packed(name))).map_err(|error| error.to_string())
    }

    fn errors(&mut self, _: &str, _: &str) -> Result<Steps, String> {
        Err("an exported device has no identified models".to_owned())
    }
}

/// Reads the device from the resources.
pub fn read(resources: &Path) -> Result<Description, String> {
    let text = std::fs::read_to_string(resources.join(DEVICE));
    let text = text.map_err(|error| format!("failed to read {DEVICE}: {error}"))?;
    let said = |error: FileError| error.message().to_owned();
    Description::parse_with(DEVICE, &text, &mut Resources(resources)).map_err(said)
}
