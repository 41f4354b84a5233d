//! Selects how a program gets virtual time: by the preloaded shim, or by the tracer that stops its system calls.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

/// Most interpreters in a row: a script's interpreter may be a script. Same limit as the kernel's.
const INTERPRETERS_MAX: usize = 5;
/// The kernel reads no more of a script's first line.
const LINE_BYTES: usize = 256;
const SET_UID: u32 = 0o4000;
const SET_GID: u32 = 0o2000;
/// Most program headers that are read.
const SEGMENTS_MAX: u16 = 1_024;
/// Longest loader name that is read.
const NAME_BYTES_MAX: u64 = 4_096;
/// `PT_INTERP`: names the loader of the program and the shim.
const INTERPRETER: u32 = 3;
/// `PT_NOTE`: what the program says of itself.
const NOTES: u32 = 4;
/// Most bytes of notes that are read.
const NOTES_BYTES_MAX: u64 = 16_384;
/// Name and kind of the note with the build ID of Go.
const GO: (&[u8], u32) = (b"Go\0\0", 4);
const SEGMENT_BYTES: u64 = 56;

/// Why a program cannot run in virtual time.
#[derive(Debug, thiserror::Error)]
pub enum BinaryError {
    /// The program does not exist.
    #[error("no program {0:?}; is it built, spelt right, and in PATH or given as a path?")]
    Missing(String),
    /// The program cannot be read.
    #[error("failed to read {}", path.display())]
    Unreadable {
        /// The program.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is linked statically, is in Go or loads musl: the shim cannot be preloaded or is not asked, and there is no
    /// tracer for this machine.
    #[error(
        "{} does not make its system calls through glibc: on this machine virtual time needs a program that does, and none \
         in Go",
        .0.display()
    )]
    NoShim(PathBuf),
    /// It runs with the rights of another user, so the loader preloads nothing.
    #[error("{} is set-uid or set-gid: the shim is not loaded into such a program", .0.display())]
    Privileged(PathBuf),
    /// It is for another machine, or not a program.
    #[error("{} is no 64-bit ELF program or script of this machine", .0.display())]
    Foreign(PathBuf),
}

/// How a program gets virtual time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    /// The loader preloads the shim.
    Shim,
    /// It is linked statically, loads musl, or is in Go, whose runtime makes its own system calls even if it loads glibc:
    /// the tracer runs it. The tracer is for x86-64 only.
    Tracer,
}

/// Finds a program like `execvp`.
pub(crate) fn find(program: &str, search: Option<&str>) -> Result<PathBuf, BinaryError> {
    let missing = || BinaryError::Missing(program.to_owned());
    if program.contains('/') {
        let path = PathBuf::from(program);
        return if path.is_file() { Ok(path) } else { Err(missing()) };
    }
    let folders = search.unwrap_or("/usr/local/bin:/usr/bin:/bin").split(':');
    folders.map(|folder| Path::new(folder).join(program)).find(|p| p.is_file()).ok_or_else(missing)
}

/// Returns how the program at `path` gets virtual time.
pub(crate) fn check(path: &Path) -> Result<Way, BinaryError> {
    let mut path = path.to_owned();
    for _ in 0..INTERPRETERS_MAX {
        let unreadable = |source| BinaryError::Unreadable { path: path.clone(), source };
        let mut file = File::open(&path).map_err(unreadable)?;
        let data = file.metadata().map_err(unreadable)?;
        let own = (rustix::process::geteuid().as_raw(), rustix::process::getegid().as_raw());
        if is_privileged(data.mode(), (data.uid(), data.gid()), own) {
            return Err(BinaryError::Privileged(path));
        }
        let mut head = Vec::new();
        file.by_ref().take(LINE_BYTES as u64).read_to_end(&mut head).map_err(unreadable)?;
        match script_interpreter(&head) {
            Some(interpreter) => path = interpreter,
            None => return check_elf(path, &head, file),
        }
    }
    Err(BinaryError::Foreign(path))
}

/// Whether the program has rights that its caller does not have.
fn is_privileged(mode: u32, owner: (u32, u32), own: (u32, u32)) -> bool {
    (mode & SET_UID != 0 && owner.0 != own.0) || (mode & SET_GID != 0 && owner.1 != own.1)
}

fn script_interpreter(head: &[u8]) -> Option<PathBuf> {
    let line = head.strip_prefix(b"#!")?.split(|byte| *byte == b'\n').next()?;
    let words = std::str::from_utf8(line).ok()?;
    words.split_ascii_whitespace().next().map(PathBuf::from)
}

fn check_elf(path: PathBuf, head: &[u8], mut file: File) -> Result<Way, BinaryError> {
    let half = |at: usize| Some(u16::from_ne_bytes(head.get(at..at + 2)?.try_into().ok()?));
    let is_64_bit = head.starts_with(b"\x7fELF\x02");
    let layout = || Some((u64::from_ne_bytes(head.get(32..40)?.try_into().ok()?), half(56)?));
    let Some((start, count)) = layout().filter(|_| is_64_bit) else {
        return Err(BinaryError::Foreign(path));
    };
    if half(18) != Some(MACHINE) {
        return Err(BinaryError::Foreign(path));
    }
    let way = match described(&mut file, start, count) {
        Ok(Described { loader: Some(loader), is_go: false }) if loads_our_library(&loader) => {
            Way::Shim
        }
        Ok(_) => Way::Tracer,
        Err(source) => return Err(BinaryError::Unreadable { path, source }),
    };
    match way {
        Way::Tracer if !cfg!(target_arch = "x86_64") => Err(BinaryError::NoShim(path)),
        way => Ok(way),
    }
}

/// What the program's headers say.
#[derive(Debug, Default)]
struct Described {
    /// `None` if it needs no loader.
    loader: Option<String>,
    is_go: bool,
}

fn described(file: &mut File, start: u64, count: u16) -> io::Result<Described> {
    let mut described = Described::default();
    for number in 0..u64::from(count.min(SEGMENTS_MAX)) {
        file.seek(SeekFrom::Start(start + number * SEGMENT_BYTES))?;
        let mut segment = [0; SEGMENT_BYTES as usize];
        file.read_exact(&mut segment)?;
        let word = |at: usize| u64::from_ne_bytes(std::array::from_fn(|byte| segment[at + byte]));
        let mut contents = |bytes_max: u64| -> io::Result<Vec<u8>> {
            let mut contents = Vec::new();
            file.seek(SeekFrom::Start(word(8)))?;
            file.take(word(32).min(bytes_max)).read_to_end(&mut contents)?;
            Ok(contents)
        };
        if segment[..4] == INTERPRETER.to_ne_bytes() {
            let name = contents(NAME_BYTES_MAX)?;
            let name = String::from_utf8_lossy(&name);
            described.loader = Some(name.trim_end_matches('\0').to_owned());
        }
        if segment[..4] == NOTES.to_ne_bytes() {
            described.is_go |= has_note(&contents(NOTES_BYTES_MAX)?, GO);
        }
    }
    Ok(described)
}

/// Whether one of these notes has this name and kind. Notes of eight-byte alignment are of others, and end the search.
fn has_note(mut notes: &[u8], (name, kind): (&[u8], u32)) -> bool {
    loop {
        let word = |at: usize| notes.get(at..at + 4)?.try_into().ok().map(u32::from_ne_bytes);
        let (Some(name_bytes), Some(bytes), Some(found)) = (word(0), word(4), word(8)) else {
            return false;
        };
        let aligned = |bytes: u32| (bytes as usize).next_multiple_of(4);
        let named = notes.get(12..).and_then(|rest| rest.get(..name_bytes as usize));
        if named == Some(name) && found == kind {
            return true;
        }
        let Some(rest) = notes.get(12 + aligned(name_bytes) + aligned(bytes)..) else {
            return false;
        };
        notes = rest;
    }
}

/// Whether a loader can load the shim, which is built for glibc: musl's cannot.
fn loads_our_library(loader: &str) -> bool {
    !loader.rsplit('/').next().is_some_and(|name| name.starts_with("ld-musl-"))
}

/// `e_machine` of this machine: EM_X86_64, EM_AARCH64, EM_RISCV.
const MACHINE: u16 = if cfg!(target_arch = "x86_64") {
    62
} else if cfg!(target_arch = "aarch64") {
    183
} else {
    243
};

#[cfg(test)]
mod tests {
    use super::{GO, has_note, is_privileged, loads_our_library, script_interpreter};
    use std::path::PathBuf;

    #[test]
    fn the_shim_is_for_the_loader_of_glibc() {
        assert!(loads_our_library("/lib64/ld-linux-x86-64.so.2"));
        assert!(!loads_our_library("/lib/ld-musl-x86_64.so.1"));
    }

    #[test]
    fn a_program_in_go_says_so() {
        let note = |name: &[u8], kind: u32, bytes: &[u8]| {
            let sizes = [name.len() as u32, bytes.len() as u32, kind];
            let mut note: Vec<u8> = sizes.into_iter().flat_map(u32::to_ne_bytes).collect();
            note.extend(name);
            note.extend(bytes);
            note.resize(note.len().next_multiple_of(4), 0);
            note
        };
        let (gnu, go) = (note(b"GNU\0", 4, b"12345"), note(b"Go\0\0", 4, b"r0joBZ"));
        assert!(has_note(&go, GO));
        assert!(has_note(&[gnu.clone(), go.clone()].concat(), GO));
        assert!(!has_note(&gnu, GO));
        assert!(!has_note(&go[..13], GO));
        assert!(!has_note(&note(b"GNU\0", u32::MAX, &[]), GO));
        assert!(!has_note(&[0xFF; 40], GO));
    }

    #[test]
    fn rights_that_one_has_oneself_are_no_privilege() {
        assert!(!is_privileged(0o755, (0, 0), (1_000, 1_000)));
        assert!(is_privileged(0o4755, (0, 0), (1_000, 1_000)));
        assert!(is_privileged(0o2755, (1_000, 0), (1_000, 1_000)));
        assert!(!is_privileged(0o6755, (1_000, 1_000), (1_000, 1_000)));
    }

    #[test]
    fn a_script_names_who_reads_it() {
        let python = Some(PathBuf::from("/usr/bin/env"));
        assert_eq!(script_interpreter(b"#! /usr/bin/env python3\nimport can"), python);
        assert_eq!(script_interpreter(b"\x7fELF"), None);
    }
}
