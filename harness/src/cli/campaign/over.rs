//! A campaign over a NATS server: `hil campaign --nats`.

use super::super::failure::Failure;
use super::super::interrupt::Interrupt;
use super::super::nats::{CredentialArguments, stop, teller};
use super::super::progress::Screen;
use crate::campaign::nats::{Holder, Package, Place, Remote, RemoteSettings, StoredFile};
use crate::campaign::{Campaign, Simulated, WINDOW};
use crate::console;
use clap::Args;
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// All that are drawn are out at a time.
pub(super) const AT_A_TIME: NonZeroUsize = NonZeroUsize::new(WINDOW as usize).unwrap();

/// Who carries the cases out, where this process does not.
#[derive(Debug, Args)]
pub(super) struct OverArguments {
    /// Has the cases carried out by the workers (`hil worker`) of the NATS server at this address: nats://HOST:PORT or
    /// tls://HOST:PORT, with USER:PASSWORD@ or TOKEN@ before the host; several of one cluster with commas between.
    #[arg(long, value_name = "URL", value_delimiter = ',', conflicts_with_all = ["threads", "envelope", "envelopes"])]
    nats: Vec<String>,
    #[command(flatten)]
    credentials: CredentialArguments,
    /// Has them carried out on the bench of this name, by the worker that was given its file.
    #[arg(long, value_name = "NAME", requires = "nats")]
    on_bench: Option<Place>,
}

impl OverArguments {
    /// That the cases stay here.
    pub(super) fn none(&self) -> Result<(), Failure> {
        if self.nats.is_empty() {
            return Ok(());
        }
        Err(Failure::arguments(
            "a bench of this machine carries its cases out here, not over a server",
            "leave out --nats, or --clock and --bench",
        ))
    }

    /// Opens the campaign, where it goes over a server.
    pub(super) fn remote(
        &self,
        plan: &str,
        what: &str,
        executor: &Simulated,
        interrupt: &Interrupt,
        screen: &Screen,
    ) -> Result<Option<Remote<Simulated>>, Failure> {
        if self.nats.is_empty() {
            return Ok(None);
        }
        let server = self.credentials.server(&self.nats)?;
        let package = Package::of(plan, executor.answers())?;
        let settings = RemoteSettings {
            what: what.to_owned(),
            place: self.on_bench.clone().unwrap_or(Place::Virtual),
            holder: Holder::this_process(),
        };
        let (tell, stop) = (teller(screen), stop(interrupt));
        let remote = Remote::open(&server, &package, settings, executor.clone(), tell, stop)?;
        screen.chat(&format!("campaign {} waits for workers", remote.campaign()));
        Ok(Some(remote))
    }
}

/// Leaves what was found on the server.
pub(super) fn finish(
    remote: &Remote<Simulated>,
    done: &Campaign,
    saved: &[PathBuf],
) -> Result<(), Failure> {
    let result = console::campaign_json(done, saved, None);
    let mut files = vec![StoredFile { name: "result.json".to_owned(), text: result }];
    for path in saved {
        let text = std::fs::read_to_string(path).map_err(|source| Failure::file(path, source))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        files.push(StoredFile { name, text });
    }
    Ok(remote.finish(files)?)
}
