//! What keeps a campaign from going over a server.

use super::message::FORMAT;

/// Why a campaign cannot go over a server, or no longer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum NatsError {
    /// An argument is wrong.
    #[error("{message}")]
    Argument {
        /// What is wrong.
        message: String,
        /// What to do.
        #[help]
        help: String,
    },
    /// There is no server there, or it lets nobody in.
    #[error("failed to connect to {server}: {cause}")]
    Connect {
        /// Its address, without a password.
        server: String,
        /// Why.
        cause: String,
        /// What to do.
        #[help]
        help: &'static str,
    },
    /// The server keeps no streams.
    #[error("the server {server} has no JetStream: {cause}")]
    #[diagnostic(help("start it with `nats-server -js -sd FOLDER`"))]
    NoJetStream {
        /// Its address, without a password.
        server: String,
        /// What it says.
        cause: String,
    },
    /// The server did not do what was asked of it.
    #[error("failed to {what}: {cause}")]
    #[diagnostic(help("`nats stream report` shows what the server holds"))]
    Server {
        /// What was asked for.
        what: String,
        /// Why.
        cause: String,
    },
    /// A stream is of another version of this program, or of another program.
    #[error("the stream {stream} is of another version: \"{found}\", this is messages {FORMAT}")]
    #[diagnostic(help(
        "use the version that made it, or a server of your own; `nats stream rm {stream}` removes it with all that it holds"
    ))]
    OtherFormat {
        /// Its name.
        stream: String,
        /// What it says of itself.
        found: String,
    },
    /// This worker is of another version than a campaign.
    #[error("this worker is version {ours}, the campaign {campaign} is of version {theirs}")]
    #[diagnostic(help("results of two versions do not mix: start a worker of version {theirs}"))]
    OtherVersion {
        /// Of the worker.
        ours: String,
        /// Of the campaign.
        theirs: String,
        /// Its name.
        campaign: String,
    },
    /// Somebody else has it.
    #[error("{what} is held by {holder}")]
    #[diagnostic(help(
        "end that one; if it died already, its lease ends {seconds} s after it did"
    ))]
    Held {
        /// A bench or a campaign.
        what: String,
        /// Who.
        holder: String,
        /// How long a lease outlives its holder.
        seconds: u64,
    },
    /// The lease is another's now.
    #[error("the lease on {what} is lost to {holder}")]
    #[diagnostic(help(
        "this machine did not reach the server for too long, and another took over"
    ))]
    Lost {
        /// A bench or a campaign.
        what: String,
        /// Who has it now.
        holder: String,
    },
    /// A worker cannot carry the campaign out.
    #[error("the worker {worker} cannot carry out this campaign: {cause}")]
    #[diagnostic(help(
        "mend or end that worker, and start the campaign again: it goes on where it stopped"
    ))]
    Refused {
        /// Which.
        worker: String,
        /// Why.
        cause: String,
    },
    /// What a worker sent is nothing that it should send.
    #[error("a result of the case {case} cannot be read: {cause}")]
    #[diagnostic(help("who else writes to hil.results.> on this server?"))]
    Unreadable {
        /// The case.
        case: String,
        /// Why.
        cause: String,
    },
    /// No thread or no runtime for the connection.
    #[error("failed to start the connection to the server")]
    Start(#[source] std::io::Error),
}

impl NatsError {
    /// What the caller can mend by calling differently.
    pub const fn is_bad_input(&self) -> bool {
        matches!(
            self,
            Self::Argument { .. }
                | Self::Connect { .. }
                | Self::NoJetStream { .. }
                | Self::OtherFormat { .. }
                | Self::OtherVersion { .. }
                | Self::Held { .. }
        )
    }

    pub(super) fn server(what: impl Into<String>, cause: impl std::fmt::Display) -> Self {
        Self::Server { what: what.into(), cause: cause.to_string() }
    }
}
