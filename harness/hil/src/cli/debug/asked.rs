//! Commands for a stopped run.

use described::hint;
use wire::time::Timestamp;

pub(super) const MOMENT: &str = "give the time in seconds from the start of the run";

const WORDS: [&str; 8] = ["step", "next", "to", "find", "show", "end", "quit", "help"];

/// Answer to `help`.
pub(super) const HELP: &str = "\
step [N]     on by N records, which are printed (an empty line: by one)
next         on to the next begin or end of a step of the plan
to SECONDS   on to a moment
find TEXT    on to the next record whose line holds the text
show         what stands now
end          on to the end
quit         leave";

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Asked {
    Go(Until),
    Show,
    /// Print the available commands.
    Help,
    Quit,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Until {
    /// After this many records, which are printed.
    Records(u64),
    /// At the begin or end of a plan step.
    Step,
    /// Before the first record after this moment.
    Moment(Timestamp),
    /// At a record whose line contains this text.
    Line(String),
    End,
}

/// Parses the command in a line, or explains why it is not one.
pub(super) fn asked(line: &str) -> Result<Asked, String> {
    let line = line.trim();
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim();
    let alone =
        |asked| if rest.is_empty() { Ok(asked) } else { Err(format!("`{word}` takes nothing")) };
    match word {
        "" => Ok(Asked::Go(Until::Records(1))),
        "step" => match rest {
            "" => Ok(Asked::Go(Until::Records(1))),
            _ => match rest.parse() {
                Ok(count @ 1..) => Ok(Asked::Go(Until::Records(count))),
                _ => Err(format!("`step` takes a number of records, not `{rest}`")),
            },
        },
        "next" => alone(Asked::Go(Until::Step)),
        "to" => {
            let at = rest.parse().map_err(|_| format!("`to` takes seconds, not `{rest}`"))?;
            Ok(Asked::Go(Until::Moment(moment(at)?)))
        }
        "find" if rest.is_empty() => Err("`find` takes a text".to_owned()),
        "find" => Ok(Asked::Go(Until::Line(rest.to_owned()))),
        "show" => alone(Asked::Show),
        "end" => alone(Asked::Go(Until::End)),
        "quit" => alone(Asked::Quit),
        "help" => alone(Asked::Help),
        other => Err(format!("no order `{other}`: {}", hint::proposal(other, &WORDS))),
    }
}

/// Converts seconds since the begin to a moment.
pub(super) fn moment(at_s: f64) -> Result<Timestamp, String> {
    if at_s.is_nan() || at_s < 0.0 {
        return Err(format!("{at_s} s is before the run began"));
    }
    Ok(Timestamp::from_secs_f64(at_s))
}

#[cfg(test)]
mod tests {
    use super::{Asked, Until, asked};
    use wire::time::Timestamp;

    #[test]
    fn orders_are_words_and_what_they_take() {
        let go = |until| Ok(Asked::Go(until));
        assert_eq!(asked(""), go(Until::Records(1)));
        assert_eq!(asked(" step 12 "), go(Until::Records(12)));
        assert_eq!(asked("to 1.5"), go(Until::Moment(Timestamp::from_secs_f64(1.5))));
        assert_eq!(asked("find fault 0 begins"), go(Until::Line("fault 0 begins".to_owned())));
        assert_eq!(asked("quit"), Ok(Asked::Quit));
    }

    #[test]
    fn what_is_none_says_why() {
        for (line, expected) in [
            ("step 0", "`step` takes a number of records, not `0`"),
            ("to then", "`to` takes seconds, not `then`"),
            ("to -1", "-1 s is before the run began"),
            ("find", "`find` takes a text"),
            ("end now", "`end` takes nothing"),
            ("stop", "no order `stop`: did you mean `step`?"),
        ] {
            assert_eq!(asked(line), Err(expected.to_owned()));
        }
    }
}
