//! Names of topics and fields that Foxglove's message paths accept: letters, digits, `_` and, in topics, `/`.

use std::collections::{BTreeMap, BTreeSet};

/// `lap.gyro_error` as the end of a topic: `lap/gyro_error`.
pub(super) fn of_topic(name: &str) -> String {
    let plain = |character: char| match character {
        '.' => '/',
        other => plain(other),
    };
    name.chars().map(plain).collect()
}

/// Replaces any other character than a letter, digit or `_` with `_`.
fn plain(character: char) -> char {
    if character.is_ascii_alphanumeric() { character } else { '_' }
}

#[derive(Debug, Default)]
pub(crate) struct Names(BTreeSet<String>);

impl Names {
    /// A field of that name, with `_` appended until it is unique.
    pub(crate) fn field(&mut self, name: &str) -> String {
        self.once(name.chars().map(plain).collect())
    }

    fn once(&mut self, mut name: String) -> String {
        while !self.0.insert(name.clone()) {
            name.push('_');
        }
        name
    }
}

#[derive(Debug, Default)]
pub(super) struct Topics {
    taken: Names,
    known: BTreeMap<String, String>,
}

impl Topics {
    /// The topic of that name in the folder; always the same for the same name.
    pub(super) fn of(&mut self, folder: &str, name: &str) -> &str {
        let key = format!("{folder}/{name}");
        let taken = &mut self.taken;
        let topic = || taken.once(format!("{folder}/{}", of_topic(name)));
        self.known.entry(key).or_insert_with(topic)
    }
}

#[cfg(test)]
mod tests {
    use super::{Names, Topics};

    #[test]
    fn whatever_a_name_holds_its_topic_is_its_own() {
        let mut topics = Topics::default();
        let names = ["lap.gyro_error", "a b", "a\"b", "a b", "\n"];
        let found = names.map(|name| topics.of("/observations", name).to_owned());
        let expected = [
            "/observations/lap/gyro_error",
            "/observations/a_b",
            "/observations/a_b_",
            "/observations/a_b",
            "/observations/_",
        ];
        assert_eq!(found, expected);
        let mut names = Names::default();
        assert_eq!(["x.y", "x_y"].map(|name| names.field(name)), ["x_y", "x_y_"]);
    }
}
