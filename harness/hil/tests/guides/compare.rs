//! Compares the output of a command with the guide.

use regex::Regex;
use std::sync::LazyLock;

/// Parts that differ between machines, and between runs on one.
pub const CHANGING: [(&str, &str); 4] = [
    // Wall time.
    (r"\bin (about )?\d+(\.\d+)? (s|min|h)( \d+ (s|min))?", "in TIME"),
    (r"\d+(\.\d+)? times real time", "N times real time"),
    // Number of the pty.
    (r"/dev/pts/\d+", "/dev/pts/N"),
    // Versions of pytest, Python and so on, and pytest's rulers.
    (r"=+ (.*\S) =+", "== $1 =="),
];

static RULES: LazyLock<Vec<(Regex, &str)>> = LazyLock::new(|| {
    let rule = |(pattern, name)| (Regex::new(pattern).unwrap(), name);
    CHANGING.into_iter().map(rule).collect()
});

fn settled(line: &str) -> String {
    RULES.iter().fold(line.trim_end().to_owned(), |line, (pattern, name)| {
        pattern.replace_all(&line, *name).into_owned()
    })
}

/// Returns the first shown line that was not printed there, and what was printed instead.
pub fn compare(shown: &[String], printed: &str) -> Result<(), String> {
    let shown: Vec<String> = shown.iter().map(|line| settled(line)).collect();
    let lines: Vec<String> = printed.lines().map(settled).collect();
    if shown.is_empty() || is_shown(&shown, &lines) {
        return Ok(());
    }
    Err(format!("shown:\n{}\nprinted:\n{printed}", shown.join("\n")))
}

fn is_shown(shown: &[String], lines: &[String]) -> bool {
    match shown.split_first() {
        None => lines.is_empty(),
        Some((first, rest)) if first == "..." => {
            (0..=lines.len()).any(|skipped| is_shown(rest, &lines[skipped..]))
        }
        Some((first, rest)) => lines
            .split_first()
            .is_some_and(|(line, others)| is_line(first, line) && is_shown(rest, others)),
    }
}

/// `...` in a shown line stands for anything.
fn is_line(shown: &str, line: &str) -> bool {
    let parts: Vec<String> = shown.split("...").map(regex::escape).collect();
    Regex::new(&format!("^{}$", parts.join(".*"))).unwrap().is_match(line)
}
