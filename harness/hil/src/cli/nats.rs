//! Connection to a NATS server, shared by `hil campaign --nats` and `hil worker`.

use super::failure::Failure;
use super::interrupt::Interrupt;
use super::progress::Screen;
use campaign_nats::{Credentials, News, Server};
use clap::Args;
use std::path::PathBuf;
use std::sync::Arc;

/// By what right, and whom to trust.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct CredentialArguments {
    /// Credentials file (JWT and key) for the server.
    #[arg(long, value_name = "FILE", requires = "nats")]
    creds: Option<PathBuf>,
    /// File that holds the seed of an nkey.
    #[arg(long, value_name = "FILE", requires = "nats", conflicts_with = "creds")]
    nkey: Option<PathBuf>,
    /// CA certificates (PEM) to trust for the server, in addition to those of this machine.
    #[arg(long, value_name = "FILE", requires = "nats")]
    tls_ca: Option<PathBuf>,
    /// Certificate (PEM) of this client.
    #[arg(long, value_name = "FILE", requires_all = ["nats", "tls_key"])]
    tls_cert: Option<PathBuf>,
    /// Its key (PEM).
    #[arg(long, value_name = "FILE", requires_all = ["nats", "tls_cert"])]
    tls_key: Option<PathBuf>,
}

impl CredentialArguments {
    pub(super) fn server(&self, urls: &[String]) -> Result<Server, Failure> {
        let credentials = Credentials {
            creds: self.creds.clone(),
            nkey: self.nkey.clone(),
            tls_ca: self.tls_ca.clone(),
            tls_client: self.tls_cert.clone().zip(self.tls_key.clone()),
        };
        Ok(Server::new(urls, credentials)?)
    }
}

/// Prints news to the standard error.
pub(super) fn teller(screen: &Screen) -> Arc<dyn Fn(&News) + Send + Sync> {
    let screen = screen.clone();
    Arc::new(move |news: &News| match news {
        // With `--quiet` only obstacles are shown.
        News::CarriedOut(_) | News::Campaign { .. } => screen.chat(&news.to_string()),
        _ => screen.note(&news.to_string()),
    })
}

/// Returns a function that tells whether the user wants the campaign to end.
pub(super) fn stop(interrupt: &Interrupt) -> impl Fn() -> bool + Send + 'static {
    let interrupt = interrupt.clone();
    move || interrupt.requested()
}
