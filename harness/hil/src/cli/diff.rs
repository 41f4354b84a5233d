//! `hil diff`: compares two runs.

use super::determinism::{Compared, Parted, difference};
use super::failure::Failure;
use super::own::may_replace;
use super::say;
use clap::Args;
use record::outcome::Outcome;
use record::run_folder::RunFolder;
use std::path::PathBuf;
use views::console::{Style, comparison};
use views::report::compared::{Run, render};

/// Compares two runs: verdicts and figures side by side, and the first event that differs.
///
/// Fails (exit status 1) if a verdict or the outcome differs, or a verdict exists in only one of
/// them. A damaged record is an error (3).
///
/// Records may differ without that: noise, or a program in real time.
#[derive(Debug, Args)]
pub(super) struct DiffArguments {
    /// A run folder.
    #[arg(value_name = "RUN")]
    one: PathBuf,
    /// Another.
    #[arg(value_name = "OTHER")]
    other: PathBuf,
    /// Also write an HTML page with the verdicts side by side and the figures of both runs over one another.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

impl DiffArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        let (one, other) = (RunFolder::open(&self.one)?, RunFolder::open(&self.other)?);
        let (table, differing) = comparison(&one.summary()?, &other.summary()?, Style::of_stdout());
        let Compared { parted: difference, in_part } = difference(&one, &other)?;
        if let Some(page) = &self.html {
            may_replace(page, "html")?;
            let text =
                self.page((&one, &other), difference.as_ref().map(|parted| &parted.sides))?;
            std::fs::write(page, text).map_err(|source| Failure::file(page, source))?;
        }
        let damaged = difference.as_ref().is_some_and(|parted| parted.damaged);
        let records = match difference {
            Some(Parted { sides: [first, second], .. }) => {
                format!("first difference of the records:\n  first   {first}\n  second  {second}\n")
            }
            None if in_part => "what both records hold is the same".to_owned(),
            None => "the records are the same".to_owned(),
        };
        let verdicts = match differing {
            0 => "no verdict differs".to_owned(),
            1 => "1 verdict differs".to_owned(),
            several => format!("{several} verdicts differ"),
        };
        let part = match in_part {
            true => "only one record is full: bytes, frames, truths and states were not compared\n",
            false => "",
        };
        let records_of = (one.records()?, other.records()?);
        let (pack, beside) = (&records_of.0.header().files, &records_of.1.header().files);
        let files = match pack.differing(beside).as_slice() {
            [] => String::new(),
            files => format!("files that differ: {}\n", files.join(", ")),
        };
        let damage = if damaged { "a record is damaged\n" } else { "" };
        say(&format!("{table}\n{records}\n{part}{files}{verdicts}\n{damage}"))?;
        Ok(match differing {
            _ if damaged => Outcome::Error,
            0 => Outcome::Passed,
            _ => Outcome::Failed,
        })
    }

    fn page(
        &self,
        (one, other): (&RunFolder, &RunFolder),
        difference: Option<&[String; 2]>,
    ) -> Result<String, Failure> {
        let names = [&self.one, &self.other].map(|path| path.display().to_string());
        let (summaries, records) =
            ([one.summary()?, other.summary()?], [one.records()?, other.records()?]);
        let headers = [records[0].header().clone(), records[1].header().clone()];
        let [first, second] = records;
        let run = |at: usize, records| Run {
            name: &names[at],
            summary: &summaries[at],
            header: &headers[at],
            records,
        };
        Ok(render(run(0, first), run(1, second), difference))
    }
}
