//! `hil draw`: the rig of a plan as a picture.

use super::completions;
use super::failure::Failure;
use super::own::may_replace;
use super::say;
use clap::Args;
use harness::run::Prepared;
use plan::bench_file::BenchFile;
use plan::made::Made;
use record::outcome::Outcome;
use std::fs;
use std::path::PathBuf;
use views::drawing;

/// Draws the rig of a plan: its lines, the nodes on them, and which of these are real. Prints SVG.
#[derive(Debug, Args)]
pub(super) struct DrawArguments {
    /// The plan: a name from `hil list plans`, or a path.
    #[arg(add = completions::plan())]
    plan: String,
    /// Show which nodes this bench file puts at ports.
    #[arg(long, value_name = "FILE")]
    bench: Option<String>,
    /// Write the SVG to this file instead of the standard output.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl DrawArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        let bench = self.bench.as_deref().map(BenchFile::load).transpose()?;
        let real = bench.as_ref().map(BenchFile::real_nodes).unwrap_or_default();
        let prepared = Prepared::load(&self.plan, &Made::default())?.with_real(&real)?;
        let svg = drawing::svg(&prepared.plan.title, &prepared.rig, bench.as_ref()) + "\n";
        match &self.out {
            Some(path) => {
                may_replace(path, "svg")?;
                fs::write(path, svg).map_err(|source| Failure::file(path, source))?;
            }
            None => say(&svg)?,
        }
        Ok(Outcome::Passed)
    }
}
