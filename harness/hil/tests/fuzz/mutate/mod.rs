//! Input that is almost good.

mod bytes;
mod sealed;
mod text;

use crate::random::Random;
use std::collections::BTreeMap;

/// Longer files are read for longer than a run is waited for.
const BYTES_MAX: usize = 2_000_000;

/// What files say: where a mutation takes something from elsewhere.
#[derive(Debug, Default)]
pub struct Words {
    /// Words, numbers and quoted texts.
    pub tokens: Vec<String>,
    /// What stands behind each key.
    pub values: BTreeMap<String, Vec<String>>,
    /// Whole files that are text.
    pub texts: Vec<String>,
}

impl Words {
    /// Those of these files.
    pub fn of<'a>(files: impl Iterator<Item = &'a [u8]>) -> Self {
        let mut words = Self::default();
        for text in files.filter_map(|file| std::str::from_utf8(file).ok()) {
            // Data repeat themselves; a program's text is no input.
            let head: String = text.chars().take(6_000).collect();
            let tokens = text::tokens(&head);
            for (key, value) in text::values(&head, &tokens) {
                words.values.entry(key.to_owned()).or_default().push(head[value].to_owned());
            }
            words.tokens.extend(tokens.into_iter().map(|token| head[token].to_owned()));
            words.texts.push(head);
        }
        words.tokens.retain(|token| !token.trim().is_empty());
        words.tokens.sort();
        words.tokens.dedup();
        words
    }
}

/// The file with one to eight mistakes in it, mostly one.
pub fn mutated(random: &mut Random, path: &str, file: &[u8], words: &Words) -> Vec<u8> {
    let mut file = file.to_vec();
    loop {
        let next = once(random, path, &file, words);
        if next.len() <= BYTES_MAX {
            file = next;
        }
        if !random.once_in(3) {
            return file;
        }
    }
}

fn once(random: &mut Random, path: &str, file: &[u8], words: &Words) -> Vec<u8> {
    if path.ends_with(".hilrec") && !random.once_in(4) {
        // A check would stop every other mistake at the door.
        if let Some(file) = sealed::mutated(random, file, words) {
            return file;
        }
    }
    match std::str::from_utf8(file) {
        Ok(content) if !random.once_in(6) => text::mutated(random, path, content, words),
        _ => bytes::mutated(random, file, words),
    }
}
