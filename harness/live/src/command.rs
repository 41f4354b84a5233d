//! The command line of a device under test.

pub use plan::command::{CommandError, fill};

use rustix::fs::{Access, access};
use std::path::{Path, PathBuf};

/// The program that a shell would start for that name or path; `None` if it cannot be started.
pub fn find(program: &Path) -> Option<PathBuf> {
    let can_run = |path: &PathBuf| path.is_file() && access(path, Access::EXEC_OK).is_ok();
    if program.components().count() > 1 {
        return Some(program.to_owned()).filter(can_run);
    }
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders).map(|folder| folder.join(program)).find(can_run)
}

/// Interpreters whose first argument is a script; a version may follow the name.
const INTERPRETERS: [&str; 5] = ["python", "sh", "bash", "perl", "ruby"];

/// The script that an interpreter is to run, if it certainly is not there: a shell also looks for a plain name on its
/// PATH.
pub fn missing_script(words: &[String]) -> Option<&str> {
    let (program, script) = (words.first()?, words.get(1)?);
    let name = Path::new(program).file_name()?.to_str()?;
    let name = name.trim_end_matches(|one: char| one.is_ascii_digit() || one == '.');
    let is_script = INTERPRETERS.contains(&name) && !script.starts_with('-');
    let is_path = name == "python" || script.contains('/');
    (is_script && is_path && !script.contains('{') && !Path::new(script).exists()).then_some(script)
}

/// The words of a command that somebody wrote as one: `python3 manager.py`.
fn written_as_one(words: &[String]) -> Option<Vec<&str>> {
    let [program] = words else { return None };
    let words: Vec<&str> = program.split_whitespace().collect();
    (words.len() > 1 && !Path::new(program).exists()).then_some(words)
}

/// Checks what can be known of a command before it starts.
///
/// # Errors
/// A reason why it does not start: program and arguments are one word, or the script is not there.
pub(crate) fn can_start(words: &[String]) -> Result<(), String> {
    if let Some(apart) = written_as_one(words) {
        let program = words.first().map_or("", String::as_str);
        return Err(format!(
            "`{program}` is no program: the program and each argument are strings of their own, \
             command = {apart:?}"
        ));
    }
    match missing_script(words) {
        None => Ok(()),
        Some(script) => {
            let folder = std::env::current_dir().unwrap_or_default();
            let folder = folder.display();
            Err(format!("its script `{script}` is not in {folder}, where hil was called"))
        }
    }
}
