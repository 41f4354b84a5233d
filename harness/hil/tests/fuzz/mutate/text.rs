//! Mutations of lines, words and numbers, and shapes that no person writes.

use super::Words;
use super::bytes::mutated as mutated_bytes;
use crate::random::Random;
use std::ops::Range;

const NUMBERS: [&str; 30] = [
    "0",
    "-1",
    "1",
    "2",
    "-0.0",
    "0.1",
    "1e-9",
    "1e-308",
    "1e9",
    "1e12",
    "1e40",
    "1e308",
    "-1e308",
    "1e309",
    "nan",
    "inf",
    "-inf",
    "127",
    "128",
    "255",
    "256",
    "65536",
    "2147483648",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "9223372036854775808",
    "18446744073709551616",
    "1_000_000",
    "10000000000000000000000000000000000000000",
];

/// Texts that lead out of a folder, or that a terminal interprets as commands.
const TEXTS: [&str; 20] = [
    "../elsewhere/x",
    "@ELSEWHERE@/x",
    "../../x",
    "..",
    ".",
    "/",
    "",
    " ",
    "\u{1b}[2J",
    "\\u001b[2J",
    "\u{0}",
    "a\\u0000b",
    "\u{202e}\u{e9}\u{1f600}",
    "e\u{301}",
    "*",
    "a/b",
    "a\\\\b",
    "\\\"",
    "<script>",
    "/dev/null",
];

/// Depths, lengths and counts.
const COUNTS: [usize; 6] = [10, 100, 1_000, 3_000, 10_000, 100_000];

const BRACKETS: [(&str, &str); 8] = [
    ("[", "]"),
    ("{a=", "}"),
    ("(", ")"),
    ("{\"a\":", "}"),
    ("-", ""),
    ("not ", ""),
    ("if(1,", ",0)"),
    ("{ repeat = { times = 2, steps = [", "] } }"),
];

pub fn mutated(random: &mut Random, path: &str, text: &str, words: &Words) -> Vec<u8> {
    match random.below(20) {
        0..=3 => lines(random, text, words),
        16.. => other_value(random, text, words),
        4..=11 => tokens_changed(random, text, words),
        12 => deep(random, text),
        13 if path.ends_with(".toml") => many_tables(random, text),
        14 => {
            let other = &words.texts[random.below(words.texts.len())];
            spliced(random, text, other)
        }
        _ => return mutated_bytes(random, text.as_bytes(), words),
    }
    .into_bytes()
}

fn lines(random: &mut Random, text: &str, words: &Words) -> String {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    let (at, other) = (random.below(lines.len()), random.below(lines.len()));
    match random.below(6) {
        _ if lines.is_empty() => {}
        0 => drop(lines.drain(random.range(lines.len()))),
        1 => lines.insert(at, lines[other]),
        2 => lines.swap(at, other),
        3 => {
            let times = COUNTS[random.below(3)];
            lines.splice(at..at, std::iter::repeat_n(lines[at], times));
        }
        4 => lines.truncate(at),
        _ => {
            let strangers = &words.texts[random.below(words.texts.len())];
            let strangers: Vec<&str> = strangers.split_inclusive('\n').collect();
            lines.insert(at, strangers[random.below(strangers.len())]);
        }
    }
    lines.concat()
}

fn tokens_changed(random: &mut Random, text: &str, words: &Words) -> String {
    let tokens = tokens(text);
    // Few tokens are numbers, but most judged ones are.
    let numbers: Vec<_> =
        tokens.iter().filter(|token| is_number(&text[(*token).clone()])).collect();
    let is_of_numbers = !numbers.is_empty() && !random.once_in(3);
    let chosen = match (is_of_numbers, tokens.is_empty()) {
        (true, _) => numbers[random.below(numbers.len())].clone(),
        (_, false) => tokens[random.below(tokens.len())].clone(),
        _ => return text.to_owned(),
    };
    let old = &text[chosen.clone()];
    let new = match random.below(if is_of_numbers { 20 } else { 12 }) {
        0..=1 => NUMBERS[random.below(NUMBERS.len())].to_owned(),
        2..=5 => words.tokens[random.below(words.tokens.len())].clone(),
        6 => text[tokens[random.below(tokens.len())].clone()].to_owned(),
        7 => String::new(),
        8 => old.repeat(2),
        9 => within(old, &"a".repeat(COUNTS[random.below(COUNTS.len())])),
        10..=11 => within(old, TEXTS[random.below(TEXTS.len())]),
        12..=15 => NUMBERS[random.below(NUMBERS.len())].to_owned(),
        _ => nearby(random, old),
    };
    let mut out = text.to_owned();
    out.replace_range(chosen, &new);
    out
}

/// A value that the same key has elsewhere, or a nearby one: many of these are accepted.
fn other_value(random: &mut Random, text: &str, words: &Words) -> String {
    let tokens = tokens(text);
    let values = values(text, &tokens);
    let Some((key, chosen)) = values.get(random.below(values.len())).cloned() else {
        return tokens_changed(random, text, words);
    };
    let old = &text[chosen.clone()];
    let known = words.values.get(key).map_or(&[][..], Vec::as_slice);
    let new = match known.get(random.below(known.len())) {
        Some(other) if other != old => other.clone(),
        _ if is_number(old) => nearby(random, old),
        _ => words.tokens[random.below(words.tokens.len())].clone(),
    };
    let mut out = text.to_owned();
    out.replace_range(chosen, &new);
    out
}

/// Returns keys and their values: the tokens after `=` in TOML, after `:` in JSON.
pub fn values<'a>(text: &'a str, tokens: &[Range<usize>]) -> Vec<(&'a str, Range<usize>)> {
    let of = |token: &Range<usize>| &text[token.clone()];
    let is_value = |parts: &&[Range<usize>]| matches!(of(&parts[1]), "=" | ":");
    let found = tokens.windows(3).filter(is_value);
    found.map(|parts| (of(&parts[0]).trim_matches('"'), parts[2].clone())).collect()
}

/// A number that may be accepted: most others are refused at once.
fn nearby(random: &mut Random, old: &str) -> String {
    let Ok(number) = old.parse::<f64>() else { return old.to_owned() };
    let scaled = match random.below(8) {
        0 => number + 1.0,
        1 => number - 1.0,
        2 => number * 10.0,
        3 => number / 10.0,
        4 => number * 2.0,
        5 => -number,
        6 => number * 1000.0,
        _ => random.below(64) as f64,
    };
    scaled.to_string()
}

/// Quotes the new value if the old one was quoted.
fn within(old: &str, new: &str) -> String {
    if old.starts_with('"') { format!("\"{new}\"") } else { new.to_owned() }
}

fn is_number(token: &str) -> bool {
    token.trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit())
}

fn deep(random: &mut Random, text: &str) -> String {
    let tokens = tokens(text);
    let (open, close) = BRACKETS[random.below(BRACKETS.len())];
    let times = COUNTS[random.below(COUNTS.len())];
    let Some(chosen) = tokens.get(random.below(tokens.len())).cloned() else {
        return open.repeat(times);
    };
    let old = &text[chosen.clone()];
    // An expression nests within its quotes.
    let (quote, inner) = match old.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')) {
        Some(inner) if random.once_in(2) => ("\"", inner),
        _ => ("", old),
    };
    let close = if random.once_in(4) { "" } else { close };
    let new = format!("{quote}{}{inner}{}{quote}", open.repeat(times), close.repeat(times));
    let mut out = text.to_owned();
    out.replace_range(chosen, &new);
    out
}

/// Repeats one table of the file, mostly with different names.
fn many_tables(random: &mut Random, text: &str) -> String {
    let starts: Vec<usize> = text.match_indices("\n[").map(|(at, _)| at + 1).collect();
    let Some(&start) = starts.get(random.below(starts.len())) else { return text.to_owned() };
    let end = starts.iter().copied().find(|next| *next > start).unwrap_or(text.len());
    let table = &text[start..end];
    let own_names = !random.once_in(4);
    let mut out = text.to_owned();
    for number in 0..COUNTS[random.below(4)] {
        out.push('\n');
        match own_names {
            true if table.starts_with("[[") => {
                out += &table.replacen("name = \"", &format!("name = \"n{number}"), 1);
            }
            true => out += &table.replacen(']', &format!("{number}]"), 1),
            false => out += table,
        }
    }
    out
}

/// Joins the head of one text and the tail of another.
fn spliced(random: &mut Random, text: &str, other: &str) -> String {
    let cut = |random: &mut Random, text: &str| {
        let ends: Vec<usize> = text.match_indices('\n').map(|(at, _)| at + 1).collect();
        ends.get(random.below(ends.len())).copied().unwrap_or(0)
    };
    let (head, tail) = (cut(random, text), cut(random, other));
    format!("{}{}", &text[..head], &other[tail..])
}

/// Words, numbers and quoted texts.
pub fn tokens(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut chars = text.char_indices().peekable();
    while let Some((start, first)) = chars.next() {
        let mut end = start + first.len_utf8();
        if first == '"' {
            for (at, c) in chars.by_ref() {
                end = at + c.len_utf8();
                if c == '"' || c == '\n' {
                    break;
                }
            }
        } else if is_of_word(first) {
            while let Some((at, c)) = chars.next_if(|(_, c)| is_of_word(*c)) {
                end = at + c.len_utf8();
            }
        } else if first.is_whitespace() {
            continue;
        }
        found.push(start..end);
    }
    found
}

fn is_of_word(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '.' | '-' | '+')
}
