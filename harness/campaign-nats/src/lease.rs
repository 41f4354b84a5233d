//! Leases with expiry, on a bench or a campaign. The lease of a holder that died expires by itself.

use super::connect::{News, Tell};
use super::error::NatsError;
use super::room::{LEASE, Room};
use async_nats::jetstream::kv::{CreateErrorKind, Store, UpdateErrorKind};
use std::fmt;
use std::time::Duration;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

const RENEWAL: Duration = Duration::from_millis(2_500);
/// Interval of attempts to take a lease that another process holds.
const ASK_AGAIN: Duration = Duration::from_millis(500);

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Holder(String);

impl Holder {
    pub fn this_process() -> Self {
        let host = rustix::system::uname();
        let host = host.nodename().to_string_lossy().into_owned();
        Self(format!("hil {} on {host}, process {}", crate::VERSION, std::process::id()))
    }

    pub fn named(name: impl Into<String>) -> Self {
        Self(name.into())
    }
}

impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Standing {
    Held,
    /// It was not renewed in time: another process may have taken it.
    Doubtful,
    /// Another process holds it.
    Lost(String),
}

/// A lease that is renewed until it is dropped.
pub(super) struct Lease {
    what: String,
    key: String,
    bucket: Store,
    /// Number of the message that created it, unique among leases.
    pub(super) number: u64,
    pub(super) standing: watch::Receiver<Standing>,
    renewing: JoinHandle<()>,
}

impl Lease {
    /// Takes the lease on `what`, stored under `key`; if another process holds it, waits for up to `patience`.
    ///
    /// # Errors
    ///
    /// When another process still holds it then, or the server does not answer.
    pub(super) async fn take(
        room: &Room,
        what: &str,
        key: &str,
        holder: &Holder,
        patience: Duration,
        tell: &Tell,
    ) -> Result<Self, NatsError> {
        let bucket = room.leases().await?;
        let mut asks = patience.as_millis() / ASK_AGAIN.as_millis();
        let mut told = false;
        let number = loop {
            match bucket.create(key, holder.0.clone().into()).await {
                Ok(number) => break number,
                Err(error) if error.kind() == CreateErrorKind::AlreadyExists => {}
                Err(error) => {
                    return Err(NatsError::server(format!("take the lease on {what}"), error));
                }
            }
            if asks == 0 {
                let (what, holder) = (what.to_owned(), held_by(&bucket, key).await);
                return Err(NatsError::Held { what, holder, seconds: LEASE.as_secs() });
            }
            asks -= 1;
            if !std::mem::replace(&mut told, true) {
                let holder = held_by(&bucket, key).await;
                tell(&News::Held { what: what.to_owned(), holder });
            }
            sleep(ASK_AGAIN).await;
        };
        let (says, standing) = watch::channel(Standing::Held);
        let renewal =
            Renewal { bucket: bucket.clone(), key: key.to_owned(), holder: holder.clone() };
        let renewing = tokio::spawn(renewal.go_on(number, says));
        let (what, key) = (what.to_owned(), key.to_owned());
        Ok(Self { what, key, bucket, number, standing, renewing })
    }

    /// Waits until another process holds it.
    pub(super) async fn lost(&self) -> NatsError {
        let mut standing = self.standing.clone();
        let lost = standing.wait_for(|standing| matches!(standing, Standing::Lost(_))).await;
        match lost.as_deref() {
            Ok(Standing::Lost(holder)) => {
                NatsError::Lost { what: self.what.clone(), holder: holder.clone() }
            }
            _ => std::future::pending().await,
        }
    }

    /// Releases it, so that the next holder need not wait for its expiry.
    pub(super) async fn release(self) {
        self.renewing.abort();
        if *self.standing.borrow() == Standing::Held {
            // A lease that cannot be returned expires by itself.
            let _ = timeout(RENEWAL, self.bucket.purge(&self.key)).await;
        }
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        self.renewing.abort();
    }
}

async fn held_by(bucket: &Store, key: &str) -> String {
    match bucket.get(key).await {
        Ok(Some(value)) => String::from_utf8_lossy(&value).into_owned(),
        _ => "somebody else".to_owned(),
    }
}

struct Renewal {
    bucket: Store,
    key: String,
    holder: Holder,
}

impl Renewal {
    async fn go_on(self, mut number: u64, says: watch::Sender<Standing>) {
        loop {
            sleep(RENEWAL).await;
            let renewed = timeout(LEASE - 2 * RENEWAL, self.renewed(number)).await;
            let renewed = match renewed {
                Ok(renewed) => renewed,
                Err(_) => {
                    says.send_replace(Standing::Doubtful);
                    self.renewed(number).await
                }
            };
            match renewed {
                Ok(next) => {
                    number = next;
                    says.send_replace(Standing::Held);
                }
                Err(holder) => {
                    says.send_replace(Standing::Lost(holder));
                    return;
                }
            }
        }
    }

    /// Tries until the server answers: returns the new number, or the name of the new holder.
    async fn renewed(&self, number: u64) -> Result<u64, String> {
        let value = || self.holder.0.clone().into();
        loop {
            match self.bucket.update(&self.key, value(), number).await {
                Ok(number) => return Ok(number),
                Err(error) if error.kind() == UpdateErrorKind::WrongLastRevision => {
                    // It expired, or the answer to an earlier renewal was lost.
                    match self.bucket.create(&self.key, value()).await {
                        Ok(number) => return Ok(number),
                        Err(error) if error.kind() == CreateErrorKind::AlreadyExists => {
                            match self.bucket.entry(&self.key).await {
                                Ok(Some(entry)) if entry.value == self.holder.0.as_bytes() => {
                                    return Ok(entry.revision);
                                }
                                Ok(Some(entry)) => {
                                    return Err(String::from_utf8_lossy(&entry.value).into_owned());
                                }
                                Ok(None) | Err(_) => {}
                            }
                        }
                        Err(_) => {}
                    }
                }
                Err(error) => tracing::debug!("the lease {} is not renewed: {error}", self.key),
            }
            sleep(ASK_AGAIN).await;
        }
    }
}
