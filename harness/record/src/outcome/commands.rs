//! What the bench did by commands of its own.

use serde::{Deserialize, Serialize};

/// A command of the bench that the plan asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CommandSummary {
    /// Its name in the bench file.
    pub name: String,
    /// How often it was run. Never in virtual time, where there is no bench.
    pub times: u64,
    /// The longest that it took, s.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub longest_s: Option<f64>,
    /// How it ended the last time.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub ended: Option<String>,
}

impl CommandSummary {
    /// The one of that name in `all`, where it is added if need be. Says whether it is new.
    fn named<'a>(all: &'a mut Vec<Self>, name: &str) -> (&'a mut Self, bool) {
        let known = all.iter().position(|one| one.name == name);
        let place = known.unwrap_or(all.len());
        if known.is_none() {
            all.push(Self { name: name.to_owned(), times: 0, longest_s: None, ended: None });
        }
        (&mut all[place], known.is_none())
    }

    /// It was asked for where there is no bench; true the first time.
    pub fn passed_over(all: &mut Vec<Self>, name: &str) -> bool {
        Self::named(all, name).1
    }

    /// It was run.
    pub fn ran(all: &mut Vec<Self>, name: &str, took_s: f64, ended: &str) {
        let (one, _) = Self::named(all, name);
        one.times += 1;
        one.longest_s = Some(one.longest_s.map_or(took_s, |longest| longest.max(took_s)));
        one.ended = Some(ended.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::CommandSummary;

    #[test]
    fn a_command_is_told_once_with_the_longest_and_the_last() {
        let mut all = Vec::new();
        assert!(CommandSummary::passed_over(&mut all, "flash"));
        assert!(!CommandSummary::passed_over(&mut all, "flash"));
        for (took_s, ended) in
            [(1.0, "exit status: 0"), (3.0, "exit status: 0"), (2.0, "exit status: 1")]
        {
            CommandSummary::ran(&mut all, "power-on", took_s, ended);
        }
        let told = serde_json::to_string(&all).unwrap();
        assert_eq!(
            told,
            r#"[{"name":"flash","times":0},{"name":"power-on","times":3,"longest_s":3.0,"ended":"exit status: 1"}]"#
        );
    }
}
