//! Errors of a campaign over a server.

use super::message::FORMAT;

/// Why a campaign cannot run over a server, or not any longer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum NatsError {
    #[error("{message}")]
    Argument {
        message: String,
        #[help]
        help: String,
    },
    /// The server is unreachable, or rejects the client.
    #[error("failed to connect to {server}: {cause}")]
    Connect {
        /// Its address, without a password.
        server: String,
        cause: String,
        #[help]
        help: &'static str,
    },
    #[error("the server {server} has no JetStream: {cause}")]
    #[diagnostic(help("start it with `nats-server -js -sd FOLDER`"))]
    NoJetStream {
        /// Its address, without a password.
        server: String,
        cause: String,
    },
    #[error("failed to {what}: {cause}")]
    #[diagnostic(help("`nats stream report` shows what the server holds"))]
    Server { what: String, cause: String },
    #[error(
        "the stream {stream} is of another version: \"{found}\", this is message format {FORMAT}"
    )]
    #[diagnostic(help(
        "use the version that made it, or a server of your own; `nats stream rm {stream}` removes it with all that it holds"
    ))]
    OtherFormat { stream: String, found: String },
    /// This worker and a campaign have different versions.
    #[error("this worker is version {ours}, the campaign {campaign} is of version {theirs}")]
    #[diagnostic(help("results of two versions do not mix: start a worker of version {theirs}"))]
    OtherVersion { ours: String, theirs: String, campaign: String },
    /// Another process holds the lease.
    #[error("{what} is held by {holder}")]
    #[diagnostic(help(
        "end that one; if it died already, its lease ends {seconds} s after it did"
    ))]
    Held {
        /// A bench or a campaign.
        what: String,
        holder: String,
        /// How long a lease outlives its holder.
        seconds: u64,
    },
    /// Another process has taken over the lease.
    #[error("the lease on {what} is lost to {holder}")]
    #[diagnostic(help(
        "this machine did not reach the server for too long, and another took over"
    ))]
    Lost { what: String, holder: String },
    /// A worker cannot carry out the campaign.
    #[error("the worker {worker} cannot carry out this campaign: {cause}")]
    #[diagnostic(help(
        "mend or end that worker, and start the campaign again: it goes on where it stopped"
    ))]
    Refused { worker: String, cause: String },
    /// A worker sent an invalid report.
    #[error("a result of the case {case} cannot be read: {cause}")]
    #[diagnostic(help("who else writes to hil.results.> on this server?"))]
    Unreadable { case: String, cause: String },
    /// The thread or the runtime for the connection could not be started.
    #[error("failed to start the connection to the server")]
    Start(#[source] std::io::Error),
}

impl NatsError {
    /// Whether the caller can correct it by different arguments.
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

#[cfg(test)]
mod tests {
    use super::NatsError;
    use crate::{News, Place};
    use miette::Diagnostic as _;

    #[test]
    fn each_says_what_mends_it() {
        let text = str::to_owned;
        let errors = [
            NatsError::NoJetStream {
                server: text("nats://here:4222"),
                cause: text("no responders"),
            },
            NatsError::server("make the stream HIL_CASES", "timed out"),
            NatsError::OtherFormat {
                stream: text("HIL_CASES"),
                found: text("hil, message format 99"),
            },
            NatsError::OtherVersion {
                ours: text("0.1.0"),
                theirs: text("0.2.0 (message format 1)"),
                campaign: text("c0ffee"),
            },
            NatsError::Held {
                what: text("the bench window"),
                holder: text("hil 0.1.0 on there, process 7"),
                seconds: 10,
            },
            NatsError::Lost {
                what: text("the bench window"),
                holder: text("hil 0.1.0 on there, process 7"),
            },
            NatsError::Refused {
                worker: text("hil 0.1.0 on there, process 7"),
                cause: text("no disk"),
            },
            NatsError::Unreadable {
                case: text("01ab"),
                cause: text("expected value at line 1 column 1"),
            },
        ];
        let mut all = String::new();
        for error in errors {
            let help = error.help().map(|help| help.to_string()).unwrap_or_default();
            all += &format!("{error}\n  {help}\n");
        }
        let news = [
            News::Away,
            News::Back,
            News::Waiting { place: Place::Virtual, queued: 12, taken: 3, idle: 0 },
            News::GivenUp { case: text("01ab"), times: 8 },
            News::Campaign { campaign: text("c0ffee"), plan: text("live-side") },
            News::Declines { campaign: text("c0ffee"), cause: text("no disk") },
            News::CarriedOut(120),
            News::Unreported(2),
            News::Holds(text("the bench window")),
            News::Held {
                what: text("this campaign"),
                holder: text("hil 0.1.0 on there, process 7"),
            },
        ];
        for news in news {
            all += &format!("{news}\n");
        }
        insta::assert_snapshot!(all);
    }
}
