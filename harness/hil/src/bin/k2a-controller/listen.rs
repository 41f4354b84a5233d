//! Missions and reports over a socket, in place of stdin and stdout: for a controller that is started once, under a
//! debugger or on another machine, and that one test after the other attaches to.
//!
//! It serves one client at a time; others wait until that client has left.

use crate::orders::{self, Orders};
use crate::outlet::Outlet;
use ports::unix_socket;
use rustix::net::Shutdown;
use std::io::{self, BufReader, Read, Write};
use std::os::fd::OwnedFd;
use std::str::FromStr;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::net::UnixListener;
use tracing::warn;

/// Delay after a client could not be accepted. Assumption: other processes soon free their descriptors.
const RETRY: Duration = Duration::from_millis(100);
/// Time limit for a leaving client to take the remaining reports.
const FLUSH_MAX: Duration = Duration::from_millis(500);

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ListenPlace {
    /// `unix:PATH`.
    Unix(std::path::PathBuf),
    /// `tcp:ADDRESS:PORT`.
    Tcp(String),
}

impl FromStr for ListenPlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            Some(("unix", path)) if !path.is_empty() => Ok(Self::Unix(path.into())),
            Some(("tcp", address)) if address.contains(':') => Ok(Self::Tcp(address.to_owned())),
            _ => Err("expected unix:PATH or tcp:ADDRESS:PORT".to_owned()),
        }
    }
}

pub(crate) enum Listener {
    Unix(UnixListener, std::path::PathBuf),
    Tcp(TcpListener),
}

impl Listener {
    /// Listens at `place`. Must be called within the runtime.
    ///
    /// # Errors
    /// When the system refuses.
    pub(crate) async fn bind(place: ListenPlace) -> io::Result<Self> {
        Ok(match place {
            ListenPlace::Unix(path) => Self::Unix(unix_socket::listen(&path)?, path),
            ListenPlace::Tcp(address) => Self::Tcp(TcpListener::bind(address).await?),
        })
    }

    /// Waits for the next client. Cancel-safe.
    pub(crate) async fn client(&self) -> Client {
        loop {
            match self.try_client().await {
                Ok(client) => return client,
                Err(cause) => warn!(%cause, "a client could not be let in"),
            }
            tokio::time::sleep(RETRY).await;
        }
    }

    async fn try_client(&self) -> io::Result<Client> {
        match self {
            Self::Unix(listener, _) => {
                let stream = listener.accept().await?.0.into_std()?;
                stream.set_nonblocking(false)?;
                Client::new(stream.try_clone()?, stream.try_clone()?, stream.into())
            }
            Self::Tcp(listener) => {
                let stream = listener.accept().await?.0.into_std()?;
                stream.set_nonblocking(false)?;
                stream.set_nodelay(true)?;
                Client::new(stream.try_clone()?, stream.try_clone()?, stream.into())
            }
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        if let Self::Unix(_, path) = self {
            unix_socket::remove(path);
        }
    }
}

pub(crate) struct Client {
    pub(crate) orders: Orders,
    pub(crate) connection: Connection,
}

pub(crate) struct Connection {
    pub(crate) reports: Outlet,
    /// Kept for shutdown: the threads that read and write it may be blocked.
    stream: OwnedFd,
}

impl Client {
    fn new(
        source: impl Read + Send + 'static,
        sink: impl Write + Send + 'static,
        stream: OwnedFd,
    ) -> io::Result<Self> {
        let orders = orders::read(BufReader::new(source))?;
        let reports = Outlet::spawn("client", sink)?;
        Ok(Self { orders, connection: Connection { reports, stream } })
    }
}

impl Connection {
    /// Sends the queued reports and closes the connection.
    pub(crate) fn close(self) {
        self.reports.finish(FLUSH_MAX);
        // A client that has left is no longer connected.
        let _ = rustix::net::shutdown(self.stream, Shutdown::Both);
    }
}

#[cfg(test)]
mod tests {
    use super::ListenPlace;

    #[test]
    fn a_file_in_the_place_of_a_socket_stays() {
        let path = std::env::temp_dir().join(format!("k2a-controller-{}", std::process::id()));
        std::fs::write(&path, "mine").unwrap();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let bound = runtime.block_on(super::Listener::bind(ListenPlace::Unix(path.clone())));
        assert!(bound.is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn a_place_is_a_path_or_an_address() {
        assert_eq!("unix:./x".parse(), Ok(ListenPlace::Unix("./x".into())));
        assert_eq!("tcp:127.0.0.1:7000".parse(), Ok(ListenPlace::Tcp("127.0.0.1:7000".to_owned())));
        for text in ["", "unix:", "tcp:7000", "./x"] {
            assert!(text.parse::<ListenPlace>().is_err(), "{text}");
        }
    }
}
