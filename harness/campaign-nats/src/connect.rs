//! The connection: its server, its credentials, and its current state.

use super::error::NatsError;
use super::message::Place;
use async_nats::{Client, ConnectErrorKind, ConnectOptions, Event, ServerAddr};
use percent_encoding::percent_decode_str;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;

/// Time limit for the first connection. Assumption: more than a round trip around the world and a TLS handshake.
const CONNECT: Duration = Duration::from_secs(10);
/// Longest pause between two attempts to reconnect.
const RECONNECT_MAX: Duration = Duration::from_secs(2);
/// Interval of the client's pings; after two without an answer the server counts as unreachable.
const PING: Duration = Duration::from_secs(5);
/// Number of messages queued while the server is unreachable.
const CAPACITY: usize = 1_024;

#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Credentials {
    /// File with a JWT and its key, as written by `nsc`.
    pub creds: Option<PathBuf>,
    pub nkey: Option<PathBuf>,
    /// CA certificates for the server, in addition to those of this machine, PEM.
    pub tls_ca: Option<PathBuf>,
    /// Certificate and key of this client, PEM.
    pub tls_client: Option<(PathBuf, PathBuf)>,
}

#[derive(Debug, Clone)]
pub struct Server {
    addresses: Vec<ServerAddr>,
    credentials: Credentials,
}

/// Notices during a campaign or a worker's run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum News {
    Away,
    /// The server answers again.
    Back,
    /// The server rejected something.
    Refuses(String),
    Waiting {
        place: Place,
        queued: u64,
        taken: u64,
        /// Number of workers that request a case.
        idle: u64,
    },
    /// A case was abandoned after it was handed out this often without a result.
    GivenUp {
        case: String,
        times: i64,
    },
    Campaign {
        campaign: String,
        plan: String,
    },
    /// A worker cannot carry out a campaign.
    Declines {
        campaign: String,
        cause: String,
    },
    /// Number of cases that a worker has carried out so far.
    CarriedOut(u64),
    /// Number of results that wait for the server.
    Unreported(usize),
    Holds(String),
    /// Another process holds the bench or the campaign; this one waits for it.
    Held {
        what: String,
        holder: String,
    },
}

impl fmt::Display for News {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Away => f.write_str(
                "the server is away; what is under way goes on, and is reported when it is back",
            ),
            Self::Back => f.write_str("the server is back"),
            Self::Refuses(what) => write!(f, "the server refuses: {what}"),
            Self::Waiting { place, queued, taken, idle } => write!(
                f,
                "waiting for results: {queued} cases wait for a worker ({place}), {taken} are being carried out, \
                 {idle} requests for more"
            ),
            Self::GivenUp { case, times } => {
                write!(f, "case {case} was handed out {times} times and never came back: given up")
            }
            Self::Campaign { campaign, plan } => write!(f, "campaign {campaign}: {plan}"),
            Self::Declines { campaign, cause } => {
                write!(f, "cannot carry out campaign {campaign}: {cause}")
            }
            Self::CarriedOut(count) => write!(f, "{count} cases carried out"),
            Self::Unreported(count) => {
                write!(f, "{count} cases are not reported yet; once more to leave without")
            }
            Self::Holds(what) => write!(f, "holds {what}"),
            Self::Held { what, holder } => write!(f, "{what} is held by {holder}; waiting for it"),
        }
    }
}

pub(super) type Tell = Arc<dyn Fn(&News) + Send + Sync>;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Up {
    /// The server answers.
    pub(super) now: bool,
    /// Number of connections made so far.
    pub(super) times: u64,
}

#[derive(Clone)]
pub(super) struct Link {
    pub(super) client: Client,
    pub(super) up: watch::Receiver<Up>,
    pub(super) server: String,
}

impl Link {
    /// Waits until the server is reachable.
    pub(super) async fn there(&self) {
        // The sender lives as long as the client.
        let _ = self.up.clone().wait_for(|up| up.now).await;
    }

    /// Waits until a new connection is made after the first `times`.
    pub(super) async fn connected_since(&self, times: u64) -> u64 {
        let mut up = self.up.clone();
        let connected = up.wait_for(|up| up.times > times).await.map(|up| up.times);
        match connected {
            Ok(times) => times,
            Err(_) => std::future::pending().await,
        }
    }
}

impl Server {
    /// A server at these addresses: `nats://HOST:PORT` or `tls://HOST:PORT`, with `USER:PASSWORD@` or `TOKEN@` before
    /// the host.
    ///
    /// # Errors
    ///
    /// When there is no address, or one is invalid.
    pub fn new(urls: &[String], credentials: Credentials) -> Result<Self, NatsError> {
        let parse = |url: &String| {
            url.parse::<ServerAddr>().map_err(|error| NatsError::Argument {
                message: format!("--nats {url}: {error}"),
                help: "such as nats://localhost:4222".to_owned(),
            })
        };
        let addresses: Vec<ServerAddr> = urls.iter().map(parse).collect::<Result<_, _>>()?;
        if addresses.is_empty() {
            return Err(NatsError::Argument {
                message: "which server?".to_owned(),
                help: "--nats nats://localhost:4222".to_owned(),
            });
        }
        Ok(Self { addresses, credentials })
    }

    /// Host and port of each address, without passwords.
    fn name(&self) -> String {
        let names: Vec<String> = self
            .addresses
            .iter()
            .map(|address| format!("{}://{}:{}", address.scheme(), address.host(), address.port()))
            .collect();
        names.join(",")
    }

    pub(super) async fn connect(&self, tell: &Tell) -> Result<Link, NatsError> {
        let (told, up) = watch::channel(Up::default());
        let (told, tell) = (Arc::new(told), Arc::clone(tell));
        let options = self.options().await?.event_callback(move |event| {
            let (told, tell) = (Arc::clone(&told), Arc::clone(&tell));
            async move { noticed(&event, &told, &tell) }
        });
        let failed = |cause: String, help| NatsError::Connect { server: self.name(), cause, help };
        let client = options.connect(self.addresses.clone()).await.map_err(|error| {
            let help = match error.kind() {
                ConnectErrorKind::Authentication | ConnectErrorKind::AuthorizationViolation => {
                    "give --creds or --nkey, or USER:PASSWORD@ before the host"
                }
                ConnectErrorKind::Tls => "give the server's authority by --tls-ca",
                _ => "is it running? `nats-server -js -sd FOLDER` starts one",
            };
            failed(error.to_string(), help)
        })?;
        Ok(Link { client, up, server: self.name() })
    }

    async fn options(&self) -> Result<ConnectOptions, NatsError> {
        let mut options = ConnectOptions::new()
            .name(format!("hil {}", crate::VERSION))
            .connection_timeout(CONNECT)
            .ping_interval(PING)
            .client_capacity(CAPACITY)
            .max_reconnects(None)
            .reconnect_delay_callback(|attempt| {
                Duration::from_millis(100).saturating_mul(attempt as u32).min(RECONNECT_MAX)
            });
        let Credentials { creds, nkey, tls_ca, tls_client } = &self.credentials;
        let unreadable = |path: &PathBuf, error: &dyn fmt::Display| NatsError::Argument {
            message: format!("failed to read {}: {error}", path.display()),
            help: "`nsc generate creds` writes credentials, `nsc generate nkey` a seed".to_owned(),
        };
        if let Some(path) = creds {
            options = options.credentials_file(path).await.map_err(|e| unreadable(path, &e))?;
        }
        if let Some(path) = nkey {
            let seed = std::fs::read_to_string(path).map_err(|error| unreadable(path, &error))?;
            options = options.nkey(seed.trim().to_owned());
        }
        if let Some(path) = tls_ca {
            // A certificate identifies the server; plain text would not.
            options = options.add_root_certificates(path.clone()).require_tls(true);
        }
        if let Some((certificate, key)) = tls_client {
            options = options.add_client_certificate(certificate.clone(), key.clone());
        }
        let text = |part: &str| percent_decode_str(part).decode_utf8_lossy().into_owned();
        // The library parses them from the address but does not use them.
        let with_name = self.addresses.iter().find(|address| address.has_user_pass());
        Ok(match with_name.map(|address| (address.username(), address.password())) {
            Some((Some(user), Some(password))) => {
                options.user_and_password(text(user), text(password))
            }
            Some((Some(token), None)) => options.token(text(token)),
            _ => options,
        })
    }
}

fn noticed(event: &Event, up: &watch::Sender<Up>, tell: &Tell) {
    match event {
        Event::Connected => {
            let times = up.borrow().times + 1;
            let before = up.send_replace(Up { now: true, times });
            if before.times > 0 && !before.now {
                tell(&News::Back);
            }
        }
        Event::Disconnected | Event::Closed => {
            let times = up.borrow().times;
            if up.send_replace(Up { now: false, times }).now {
                tell(&News::Away);
            }
        }
        Event::ServerError(error) => tell(&News::Refuses(error.to_string())),
        _ => tracing::debug!("{event}"),
    }
}

#[cfg(test)]
mod tests {
    use super::{Credentials, Server};

    #[test]
    fn a_server_is_named_without_its_password() {
        let urls = ["nats://me:secret@there:4333".to_owned(), "here".to_owned()];
        let server = Server::new(&urls, Credentials::default()).unwrap();
        assert_eq!(server.name(), "nats://there:4333,nats://here:4222");
        let error = Server::new(&["http://there".to_owned()], Credentials::default()).unwrap_err();
        assert!(error.to_string().starts_with("--nats http://there: "), "{error}");
        assert!(Server::new(&[], Credentials::default()).is_err());
    }
}
