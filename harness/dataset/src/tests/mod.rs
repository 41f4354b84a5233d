//! Packages from other sources, mistakes in them, and corrections.

mod defects;
#[cfg(feature = "files")]
mod mdf;
mod measured;
mod mended;
#[cfg(feature = "files")]
mod ros;
#[cfg(feature = "files")]
mod rosbags;
mod round_trip;
#[cfg(feature = "files")]
mod sqlite;

use super::{Dataset, DatasetError, read};
use std::fs;
use std::io::Write;
use std::path::Path;
use tempfile::TempDir;

/// A package in its own folder.
struct Package {
    folder: TempDir,
}

/// One field of a descriptor: name, role, unit and further properties.
type FieldText<'a> = (&'a str, &'a str, &'a str, &'a str);

impl Package {
    /// A package with one table, `data.csv`.
    fn new(kind: &str, fields: &[FieldText<'_>], csv: &str) -> Self {
        let package = Self { folder: tempfile::tempdir().unwrap() };
        package.put("datapackage.json", descriptor(kind, fields, &["data.csv"]).as_bytes());
        package.put("data.csv", csv.as_bytes());
        package
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path().join(name), bytes).unwrap();
    }

    fn read(&self) -> Result<Dataset, DatasetError> {
        read(self.path())
    }
}

fn descriptor(kind: &str, fields: &[FieldText<'_>], paths: &[&str]) -> String {
    let field = |(name, role, unit, more): &FieldText<'_>| {
        format!(r#"{{"name": "{name}", "role": "{role}", "unit": "{unit}"{more}}}"#)
    };
    let fields = fields.iter().map(field).collect::<Vec<_>>().join(",\n     ");
    let resource = |path: &&str| {
        format!(
            r#"{{"path": "{path}", "schema": {{"fields": [
     {fields}]}}}}"#
        )
    };
    let resources = paths.iter().map(resource).collect::<Vec<_>>().join(",\n  ");
    format!(
        r#"{{"name": "set", "hil": {{"kind": "{kind}"}},
 "resources": [
  {resources}]}}
"#
    )
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

const SERIES: &[FieldText<'static>] = &[
    ("t", "time", "s", ""),
    ("w", "gyro_rate", "deg/s", ""),
    ("ref", "reference_rate", "deg/s", ""),
];

const SERIES_CSV: &str = "t,w,ref\n0,0.1,0\n1,0.2,0\n2,0.3,0\n";
