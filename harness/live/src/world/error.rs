//! Why a run in real time cannot begin.

use crate::attached::AttachError;
use crate::command::CommandError;
use crate::process::SpawnError;
use ports::PortError;
use std::path::PathBuf;

#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum StartError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Command(#[from] CommandError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Spawn(#[from] SpawnError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Port(#[from] PortError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Attach(#[from] AttachError),
    /// The emulated device is on a port whose other end is unknown.
    #[error("failed to find the other end of the {role}'s port, which the controller should open")]
    #[diagnostic(help(
        "give the command line of a controller that knows its port: [controller] command = \
         [\"./program\", \"--{role}\", \"/dev/ttyUSB1\"]"
    ))]
    NoFarSide { role: &'static str },
}

#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LiveError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Port(#[from] PortError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Start(#[from] StartError),
    /// The bench's own commands did not set it up.
    #[error("failed to set the bench up: {why}")]
    #[diagnostic(help("what its commands wrote is in {}", folder.display()))]
    Setup { why: String, folder: PathBuf },
    /// A stop was requested before the run began.
    #[error("stopped by request before the run began")]
    Stopped,
    #[error("failed to start the event loop")]
    #[diagnostic(help("are there file descriptors left? `ulimit -n` tells how many are allowed"))]
    Runtime(#[from] std::io::Error),
}
