//! Almost valid input.

mod bytes;
mod sealed;
mod text;

use crate::random::Random;
use std::collections::BTreeMap;

/// Longer files take longer to read than a run's time limit.
const BYTES_MAX: usize = 2_000_000;

/// Content of the files, as material for mutations.
#[derive(Debug, Default)]
pub struct Words {
    /// Words, numbers and quoted texts.
    pub tokens: Vec<String>,
    /// Values of each key.
    pub values: BTreeMap<String, Vec<String>>,
    /// Whole text files.
    pub texts: Vec<String>,
}

impl Words {
    /// Collects the content of these files.
    pub fn of<'a>(files: impl Iterator<Item = &'a [u8]>) -> Self {
        let mut words = Self::default();
        for text in files.filter_map(|file| std::str::from_utf8(file).ok()) {
            // The head suffices: data repeat, and the source text of a program is no input.
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

/// Returns the file with one or more mutations, mostly one.
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
        // Otherwise a checksum would reject every mutation.
        if let Some(file) = sealed::mutated(random, file, words) {
            return file;
        }
    }
    match std::str::from_utf8(file) {
        Ok(content) if !random.once_in(6) => text::mutated(random, path, content, words),
        _ => bytes::mutated(random, file, words),
    }
}
