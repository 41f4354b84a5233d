//! Reads files of which the size is judged first: one of gigabytes is refused before it fills the memory.

use crate::FILE_LEN_MAX;
use described::dbc_text;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Largest file that is not TOML, in bytes: DBC files have a few million, a series of values in CSV has tens of them.
const OF_TOOLS_LEN_MAX: usize = 64 << 20;

/// The content of a file, of a size up to what its kind can have.
///
/// # Errors
/// When it cannot be read or is larger.
pub fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    let most = if is_of(path, &["toml"]) { FILE_LEN_MAX } else { OF_TOOLS_LEN_MAX };
    let file = File::open(path)?;
    let mut bytes = Vec::new();
    // The length of a pipe is unknown.
    let told = usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX);
    if told <= most {
        file.take(most as u64 + 1).read_to_end(&mut bytes)?;
    }
    if told.max(bytes.len()) > most {
        let found = format!("{} bytes, expected at most {most}", told.max(bytes.len()));
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, found));
    }
    Ok(bytes)
}

/// The text of a file. Tools write DBC and EDS files in UTF-8 or in Windows-1252; all others must be UTF-8.
pub(super) fn text(path: &Path) -> io::Result<String> {
    let bytes = bytes(path)?;
    if is_of(path, &["dbc", "eds", "dcf"]) {
        return Ok(dbc_text(&bytes).into_owned());
    }
    String::from_utf8(bytes).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = good.iter().filter(|byte| **byte == b'\n').count() + 1;
        let what = format!("line {line} is not UTF-8: save the file as UTF-8");
        io::Error::new(io::ErrorKind::InvalidData, what)
    })
}

fn is_of(path: &Path, ends: &[&str]) -> bool {
    let end = path.extension().unwrap_or_default();
    ends.iter().any(|one| end.eq_ignore_ascii_case(one))
}

#[cfg(test)]
mod tests {
    use super::{FILE_LEN_MAX, OF_TOOLS_LEN_MAX, bytes, text};
    use std::fs::File;

    #[test]
    fn a_file_of_gigabytes_is_refused_before_it_is_read() {
        let folder = tempfile::tempdir().unwrap();
        for (name, most) in [
            ("plan.toml", FILE_LEN_MAX),
            ("car.dbc", OF_TOOLS_LEN_MAX),
            ("x.eds", OF_TOOLS_LEN_MAX),
        ] {
            let path = folder.path().join(name);
            // A hole, which takes no space. No machine for tests has as much memory.
            File::create(&path).unwrap().set_len(1 << 40).unwrap();
            let told = bytes(&path).unwrap_err().to_string();
            assert_eq!(told, format!("1099511627776 bytes, expected at most {most}"));
            File::create(&path).unwrap().set_len(most as u64).unwrap();
            assert_eq!(bytes(&path).unwrap().len(), most);
        }
        let endless = bytes("/dev/zero".as_ref()).unwrap_err().to_string();
        assert!(endless.ends_with(&format!("expected at most {OF_TOOLS_LEN_MAX}")), "{endless}");
    }

    #[test]
    fn a_text_that_is_not_utf_8_has_a_line() {
        let folder = tempfile::tempdir().unwrap();
        let latin = folder.path().join("series.csv");
        std::fs::write(&latin, b"time,value\n0,1\n1,2 \xb0C\n").unwrap();
        assert!(text(&latin).unwrap_err().to_string().starts_with("line 3 is not UTF-8"));
        let dbc = folder.path().join("car.dbc");
        std::fs::write(&dbc, b"\xb0C").unwrap();
        assert_eq!(text(&dbc).unwrap(), "\u{b0}C");
    }
}
