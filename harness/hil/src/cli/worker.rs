//! `hil worker`: carries out cases of campaigns that run on other machines.

mod bench;

use super::failure::Failure;
use super::interrupt::Interrupt;
use super::lease;
use super::nats::{CredentialArguments, stop, teller};
use super::progress::Screen;
use crate::choices::threads;
use bench::BenchHand;
use campaign::Executor;
use campaign_nats::{Holder, Maker, Package, Place, Stopping, WorkerSettings, work};
use clap::Args;
use harness::executors::Simulated;
use plan::bench_file::BenchFile;
use record::figures;
use record::outcome::Outcome;
use std::num::NonZeroUsize;
use std::path::Path;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::available_parallelism;
use std::time::Duration;

const WORKER_STATUSES: &str = "\
Exit status:
  0  ended by Ctrl-C or a request to terminate; what was under way is reported, on a bench broken off, the rest handed back
  2  bad input: no server there, a bench that another worker holds, a campaign of another version
  3  the bench did not come up, and its case is handed back; or the server broke";

/// Runs cases of campaigns (`hil campaign --nats`) until you stop it.
///
/// It needs only the server, which sends everything that a case needs. If the server goes away, the
/// worker waits, and reports its results when the server is back.
///
/// With --bench it runs the cases of campaigns that use --clock real and the same bench file, one
/// at a time, and repeats those that break a property.
#[derive(Debug, Args)]
#[command(after_help = WORKER_STATUSES)]
pub(super) struct WorkerArguments {
    /// Address of the NATS server: nats://HOST:PORT or tls://HOST:PORT, with USER:PASSWORD@ or
    /// TOKEN@ before the host; separate several servers of a cluster by commas.
    #[arg(long, value_name = "URL", value_delimiter = ',', required = true)]
    nats: Vec<String>,
    #[command(flatten)]
    credentials: CredentialArguments,
    /// Cases at a time. [default: one per processor; on a bench one]
    #[arg(long, visible_alias = "jobs", value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
    /// Bench file, a name (see `hil list benches`) or a path: takes only cases for the bench of
    /// that name, and holds its lease.
    #[arg(long, value_name = "FILE", conflicts_with = "threads")]
    bench: Option<String>,
    /// Folder for the standard error of the bench's device under test. [default: runs/worker-BENCH]
    #[arg(long, value_name = "DIR", requires = "bench")]
    out: Option<PathBuf>,
    /// How long to wait for a bench that somebody else uses, s.
    #[arg(long, value_name = "S", requires = "bench", default_value_t = 0)]
    wait: u32,
    /// Show only errors.
    #[arg(long)]
    pub(super) quiet: bool,
}

impl WorkerArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let server = self.credentials.server(&self.nats)?;
        let bench = self.bench.as_deref().map(|name| BenchHand::new(name, self.out.as_deref()));
        let bench = bench.transpose()?;
        let place = bench.as_ref().map_or(Place::Virtual, |bench| bench.place().clone());
        let threads = match (&place, self.threads) {
            (Place::Bench(_), _) => NonZeroUsize::MIN,
            (Place::Virtual, Some(threads)) => threads,
            (Place::Virtual, None) => available_parallelism().unwrap_or(NonZeroUsize::MIN),
        };
        let saying = match &place {
            Place::Virtual => "stopping: what is under way is reported; once more to leave at once",
            Place::Bench(_) => {
                "stopping in order: the case is handed back; once more to leave at once"
            }
        };
        let interrupt = Interrupt::install_saying(screen, saying)?;
        let settings = WorkerSettings {
            threads,
            holder: Holder::this_process(),
            version: campaign_nats::VERSION.to_owned(),
            patience: Duration::from_secs(self.wait.into()),
            place,
        };
        screen.chat(&format!(
            "worker of version {} ({}), {threads} at a time",
            settings.version, settings.place
        ));
        let maker: Maker = match &bench {
            None => Arc::new(virtually),
            Some(bench) => bench.maker(),
        };
        let stopped = || interrupt.requested();
        let lease = |name: &String| {
            lease::take((name, &BenchFile::load(name)?), self.wait, &stopped, screen)
        };
        let _lease = self.bench.as_ref().map(lease).transpose()?;
        let worked = work(&server, &settings, maker, teller(screen), stop(&interrupt));
        // The error that stopped the case says more than its interruption.
        bench.map_or(Ok(()), |bench| bench.came_up())?;
        let cases = figures::counted(worked?, "case", "cases");
        screen.chat(&format!("{cases} carried out"));
        Ok(Outcome::Passed)
    }
}

/// Names a bench after its file, so that the same bench has the same name everywhere.
pub(super) fn bench_place(name: &str) -> Result<Place, Failure> {
    let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    stem.unwrap_or_default()
        .parse()
        .map_err(|message: String| Failure::arguments(message, "rename the bench file"))
}

/// Executor for the cases of a package in virtual time.
fn virtually(
    package: &Package,
    _: Stopping,
) -> Result<(String, Arc<dyn Executor + Send + Sync>), String> {
    let (prepared, answers) = package.prepare().map_err(|error| error.to_string())?;
    let plan = prepared.plan.name.to_string();
    Ok((plan, Arc::new(Simulated::new(prepared, answers))))
}
