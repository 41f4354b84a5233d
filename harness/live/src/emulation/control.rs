//! Requests from outside: lines on the standard input and on an optional socket.

use super::request::LINE_BYTES_MAX;
use ports::unix_socket;
use std::io::{self, Read as _, Write as _};
use std::os::unix::net::UnixStream as StdUnixStream;
use std::path::{Path, PathBuf};
use std::thread;
use tokio::io::{
    AsyncBufRead, AsyncBufReadExt as _, AsyncReadExt as _, AsyncWriteExt as _, BufReader,
};
use tokio::net::{UnixListener, UnixStream};
use tokio::sync::{mpsc, oneshot};

/// Most requests that wait to be carried out; beyond that the client waits.
pub const REQUESTS_MAX: usize = 64;
/// Bytes per read of the standard input.
const READ_BYTES: usize = 4_096;
/// Most clients of the socket at a time; further ones wait for one to leave.
pub const CLIENTS_MAX: usize = 16;

#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ControlError {
    #[error("failed to listen on the socket {}", path.display())]
    #[diagnostic(help(
        "does its folder exist, and is nobody else listening there (`ss -xl`)? If what is there is \
         left over: `rm {}`", path.display()
    ))]
    Listen { path: PathBuf, source: io::Error },
    /// A file of the user has that name.
    #[error(transparent)]
    #[diagnostic(help("give the socket another name"))]
    NoSocket(io::Error),
    #[error("failed to read the standard input")]
    Stdin(#[source] io::Error),
}

/// A request line, and the destination of its answer.
#[derive(Debug)]
pub struct Asked {
    /// The line, cut one byte after [`LINE_BYTES_MAX`].
    pub line: Vec<u8>,
    /// The client; `None` for the standard input, which the standard output answers.
    pub client: Option<oneshot::Sender<String>>,
}

/// Collects requests. Dropping it removes the socket.
#[derive(Debug)]
pub struct Control {
    requests: mpsc::Receiver<Asked>,
    socket: Option<PathBuf>,
}

impl Control {
    /// Listens on the standard input and on `socket`, if given. Needs a tokio runtime with IO enabled.
    ///
    /// # Errors
    /// When the socket cannot be made, or the standard input cannot be watched.
    pub fn open(socket: Option<&Path>) -> Result<Self, ControlError> {
        let (sender, requests) = mpsc::channel(REQUESTS_MAX);
        let mut control = Self { requests, socket: None };
        if let Some(path) = socket {
            let error = |source: io::Error| match source.kind() {
                io::ErrorKind::AlreadyExists => ControlError::NoSocket(source),
                _ => ControlError::Listen { path: path.to_owned(), source },
            };
            let listener = unix_socket::listen(path).map_err(error)?;
            control.socket = Some(path.to_owned());
            tokio::spawn(accept(listener, sender.clone()));
        }
        let stdin = stdin().map_err(ControlError::Stdin)?;
        tokio::spawn(async move {
            let mut stdin = BufReader::new(stdin);
            while let Some(line) = next_line(&mut stdin).await {
                if sender.send(Asked { line, client: None }).await.is_err() {
                    return;
                }
            }
            // The end of the input ends nothing: a program without one still has its ports.
            sender.closed().await;
        });
        Ok(control)
    }

    /// Waits for the next request. Cancel-safe.
    pub async fn next(&mut self) -> Asked {
        match self.requests.recv().await {
            Some(asked) => asked,
            None => std::future::pending().await,
        }
    }
}

impl Drop for Control {
    fn drop(&mut self) {
        self.socket.as_deref().into_iter().for_each(unix_socket::remove);
    }
}

async fn accept(listener: UnixListener, requests: mpsc::Sender<Asked>) {
    let room = std::sync::Arc::new(tokio::sync::Semaphore::new(CLIENTS_MAX));
    while let Ok(place) = std::sync::Arc::clone(&room).acquire_owned().await {
        // A client that left before it was accepted, or a lack of descriptors, does not end the loop.
        let Ok((client, _)) = listener.accept().await else { continue };
        let requests = requests.clone();
        tokio::spawn(async move {
            serve(client, &requests).await;
            drop(place);
        });
    }
}

async fn serve(client: UnixStream, requests: &mpsc::Sender<Asked>) {
    let (reader, mut writer) = client.into_split();
    let mut reader = BufReader::new(reader);
    while let Some(line) = next_line(&mut reader).await {
        let (sender, answer) = oneshot::channel();
        if requests.send(Asked { line, client: Some(sender) }).await.is_err() {
            return;
        }
        let Ok(mut answer) = answer.await else { return };
        answer.push('\n');
        if writer.write_all(answer.as_bytes()).await.is_err() {
            return;
        }
    }
}

/// Returns the next line that is not blank; an overlong line is cut one byte after the limit.
async fn next_line(reader: &mut (impl AsyncBufRead + Unpin)) -> Option<Vec<u8>> {
    loop {
        let mut line = Vec::new();
        let mut limited = (&mut *reader).take(LINE_BYTES_MAX as u64 + 1);
        if limited.read_until(b'\n', &mut line).await.ok()? == 0 {
            return None;
        }
        if !line.ends_with(b"\n") && line.len() > LINE_BYTES_MAX {
            pass_over(reader).await?;
            return Some(line);
        }
        if !line.trim_ascii().is_empty() {
            return Some(line.trim_ascii().to_vec());
        }
    }
}

async fn pass_over(reader: &mut (impl AsyncBufRead + Unpin)) -> Option<()> {
    loop {
        let bytes = reader.fill_buf().await.ok()?;
        let (end, count) = match bytes.iter().position(|byte| *byte == b'\n') {
            Some(at) => (true, at + 1),
            None => (bytes.is_empty(), bytes.len()),
        };
        reader.consume(count);
        if end {
            return Some(());
        }
    }
}

/// The standard input as a socket that can be awaited: a thread blocks on it, and ends with the process.
fn stdin() -> io::Result<UnixStream> {
    let (mut here, there) = StdUnixStream::pair()?;
    thread::Builder::new().name("requests".to_owned()).spawn(move || {
        // Not `io::copy`: it would splice, and the writer of the pipe would wait while this end waits.
        let mut buffer = [0; READ_BYTES];
        let mut stdin = io::stdin().lock();
        // Whatever ends the input, the reader sees its end.
        while let Ok(count @ 1..) = stdin.read(&mut buffer) {
            if here.write_all(buffer.get(..count).unwrap_or_default()).is_err() {
                return;
            }
        }
    })?;
    there.set_nonblocking(true)?;
    UnixStream::from_std(there)
}

#[cfg(test)]
mod tests {
    use super::{Control, LINE_BYTES_MAX, next_line};
    use tokio::io::BufReader;

    fn within<T>(what: impl FnOnce() -> T) -> T {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let _entered = runtime.enter();
        what()
    }

    #[test]
    fn a_file_in_the_place_of_a_socket_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notes.txt");
        std::fs::write(&path, "mine").unwrap();
        let error = within(|| Control::open(Some(&path))).unwrap_err();
        assert!(error.to_string().contains("notes.txt"), "{error}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    }

    #[test]
    fn lines_blank_lines_and_one_that_never_ends() {
        let mut bytes = b"{\"a\":1}\r\n\n  \n".to_vec();
        bytes.extend(vec![b'x'; 3 * LINE_BYTES_MAX]);
        bytes.extend(b"\nlast");
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        runtime.block_on(async {
            let mut reader = BufReader::new(bytes.as_slice());
            assert_eq!(next_line(&mut reader).await.unwrap(), b"{\"a\":1}");
            assert_eq!(next_line(&mut reader).await.unwrap().len(), LINE_BYTES_MAX + 1);
            assert_eq!(next_line(&mut reader).await.unwrap(), b"last");
            assert_eq!(next_line(&mut reader).await, None);
        });
    }
}
