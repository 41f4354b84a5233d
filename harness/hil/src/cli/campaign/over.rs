//! `hil campaign --nats`: a campaign over a NATS server.

use crate::cli::failure::Failure;
use crate::cli::interrupt::Interrupt;
use crate::cli::nats::{CredentialArguments, stop, teller};
use crate::cli::progress::Screen;
use campaign::{Campaign, Executor, WINDOW};
use campaign_nats::{Holder, Package, Place, Remote, RemoteSettings, Server, StoredFile};
use clap::Args;
use harness::operator::Answers;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use views::console::{self, Again};

/// All drawn cases are in progress at the same time.
pub(super) const AT_A_TIME: NonZeroUsize = NonZeroUsize::new(WINDOW as usize).unwrap();

/// Who carries the cases out, where this process does not.
#[derive(Debug, Args)]
pub(super) struct OverArguments {
    /// Run the cases on the workers (`hil worker`) of the NATS server at this address:
    /// nats://HOST:PORT or tls://HOST:PORT, with USER:PASSWORD@ or TOKEN@ before the host; separate
    /// several servers of a cluster by commas. With --clock real, on the worker with the same bench
    /// file.
    #[arg(long, value_name = "URL", value_delimiter = ',', conflicts_with_all = ["threads", "envelope", "envelopes"])]
    nats: Vec<String>,
    #[command(flatten)]
    credentials: CredentialArguments,
}

impl OverArguments {
    /// The server, if the campaign uses one.
    pub(super) fn server(&self) -> Result<Option<Server>, Failure> {
        if self.nats.is_empty() {
            return Ok(None);
        }
        Ok(Some(self.credentials.server(&self.nats)?))
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Order<'a> {
    pub(super) plan: &'a str,
    /// What determines the cases, as stated in the journal.
    pub(super) what: &'a str,
    pub(super) answers: &'a Answers,
}

impl Order<'_> {
    /// Cases in virtual time.
    pub(super) fn virtually(&self) -> Result<(Package, RemoteSettings), Failure> {
        Ok((Package::of(self.plan, self.answers)?, self.settings(Place::Virtual)))
    }

    fn settings(&self, place: Place) -> RemoteSettings {
        RemoteSettings { what: self.what.to_owned(), place, holder: Holder::this_process() }
    }
}

impl Order<'_> {
    /// Cases on the bench of this file, by this rule.
    pub(super) fn on_bench(
        &self,
        bench: &str,
        rule: campaign::Repetition,
    ) -> Result<(Package, RemoteSettings), Failure> {
        use plan::bench_file::BenchFile;
        let place = crate::cli::worker::bench_place(bench)?;
        let package =
            Package::of(self.plan, self.answers)?.on_bench(&BenchFile::text(bench)?, rule);
        Ok((package, self.settings(place)))
    }
}

/// Opens the campaign; `local` decides which cases can be carried out.
pub(super) fn open<E: Executor>(
    server: &Server,
    (package, settings): (Package, RemoteSettings),
    local: E,
    interrupt: &Interrupt,
    screen: &Screen,
) -> Result<Remote<E>, Failure> {
    let (tell, stop) = (teller(screen), stop(interrupt));
    let remote = Remote::open(server, &package, settings, local, tell, stop)?;
    screen.chat(&format!(
        "campaign {} waits for workers of version {}",
        remote.campaign(),
        campaign_nats::VERSION
    ));
    Ok(remote)
}

/// Stores the findings on the server.
pub(super) fn finish<E: Executor>(
    remote: &Remote<E>,
    done: &Campaign,
    saved: &[PathBuf],
    again: Option<&Again<'_>>,
) -> Result<(), Failure> {
    let result = console::campaign_json(done, saved, again);
    let mut files = vec![StoredFile { name: "result.json".to_owned(), text: result }];
    for path in saved {
        let text = std::fs::read_to_string(path).map_err(|source| Failure::file(path, source))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        files.push(StoredFile { name, text });
    }
    Ok(remote.finish(files)?)
}
