//! The command line `hil`: reads arguments, shows progress and tables, sets the exit status. The work is done
//! elsewhere: [`harness::run`], [`::campaign::seeds`], [`views::report`]
//!
//! Tables and lists go to the standard output, everything else to the standard error, so that `hil ... > file` keeps
//! the result. A reader that closes early (`hil show RUN | head`) is no error.
//!
//! This module judges nothing, decides nothing about devices, and reads no clock but a stopwatch.

mod annotation;
mod build_server;
mod campaign;
mod check;
mod completions;
mod debug;
mod determinism;
mod diff;
mod doctor;
mod draw;
mod emulate;
mod envelopes;
mod export;
mod export_device;
mod export_whole;
mod failure;
mod findings;
mod identify;
mod import;
mod interrupt;
mod lease;
mod list;
mod listed;
mod log;
mod log_format;
mod man;
#[cfg(all(test, feature = "nats"))]
mod manual;
mod measured;
#[cfg(feature = "nats")]
mod nats;
mod new;
mod operator;
mod own;
mod paper;
mod parameters;
mod predict;
mod progress;
mod replay;
mod report;
mod rerun;
mod run;
mod schema;
mod seeds;
mod series;
mod setup;
mod show;
mod tame;
mod terminal;
mod watch;
#[cfg(feature = "nats")]
mod worker;

use clap::{Parser, Subcommand};
use failure::Failure;
use progress::Screen;
use record::outcome::{EXIT_BAD_INPUT, Outcome};
use serde::Serialize;
use serde_json::json;
use std::io::{self, Write};
use std::process::ExitCode;
use tracing_subscriber::EnvFilter;

/// Shown below the help of every command that has to do with runs.
const EXIT_STATUSES: &str = "\
Exit status:
  0  passed: every measurement is in its band (of several runs: in all of them)
  1  failed: a measurement is out of its band or was never made
  2  bad input: arguments, a plan, a device file, or a folder that is no run folder
  3  the bench broke: a port, a device, a disk that is full
  4  timeout: a step or a plan took longer than its limit
  5  aborted: by Ctrl-C or a request to terminate
Of several runs the worst counts.";

/// Tests CAN and serial devices and their controllers, simulated or on a bench.
///
/// Without a command it runs the plans of this folder in virtual time. In a clone of the repository of hil these are the
/// procedures of the paper.
#[derive(Debug, Parser)]
#[command(name = "hil", version, after_help = EXIT_STATUSES, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(flatten)]
    paper: paper::PaperArguments,
    /// Show only the result and errors.
    #[arg(long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::RunArguments),
    New(new::NewArguments),
    Campaign(Box<campaign::CampaignArguments>),
    #[cfg(feature = "nats")]
    Worker(worker::WorkerArguments),
    Check(check::CheckArguments),
    Report(report::ReportArguments),
    Show(show::ShowArguments),
    List(list::ListArguments),
    Diff(diff::DiffArguments),
    Rerun(rerun::RerunArguments),
    Debug(debug::DebugArguments),
    Replay(watch::replay::ReplayArguments),
    Doctor(doctor::DoctorArguments),
    Draw(draw::DrawArguments),
    Emulate(emulate::EmulateArguments),
    Export(export::ExportArguments),
    Import(import::ImportArguments),
    Log(log::LogArguments),
    Identify(identify::IdentifyArguments),
    Predict(predict::PredictArguments),
    Schema(schema::SchemaArguments),
    Completions(completions::CompletionsArguments),
    Man(man::ManArguments),
}

impl Cli {
    fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        match &self.command {
            None => self.paper.execute(screen),
            Some(Command::Run(arguments)) => arguments.execute(screen),
            Some(Command::New(arguments)) => arguments.execute(screen),
            Some(Command::Campaign(arguments)) => arguments.execute(screen),
            #[cfg(feature = "nats")]
            Some(Command::Worker(arguments)) => arguments.execute(screen),
            Some(Command::Check(arguments)) => arguments.execute(screen),
            Some(Command::Report(arguments)) => arguments.execute(screen),
            Some(Command::Show(arguments)) => arguments.execute(screen),
            Some(Command::List(arguments)) => arguments.execute(),
            Some(Command::Diff(arguments)) => arguments.execute(),
            Some(Command::Rerun(arguments)) => arguments.execute(screen),
            Some(Command::Debug(arguments)) => arguments.execute(screen),
            Some(Command::Replay(arguments)) => arguments.execute(screen),
            Some(Command::Doctor(arguments)) => arguments.execute(),
            Some(Command::Draw(arguments)) => arguments.execute(),
            Some(Command::Emulate(arguments)) => arguments.execute(screen),
            Some(Command::Export(arguments)) => arguments.execute(screen),
            Some(Command::Import(arguments)) => arguments.execute(screen),
            Some(Command::Log(arguments)) => arguments.execute(screen),
            Some(Command::Identify(arguments)) => arguments.execute(screen),
            Some(Command::Predict(arguments)) => arguments.execute(screen),
            Some(Command::Schema(arguments)) => arguments.execute(),
            Some(Command::Completions(arguments)) => arguments.execute(),
            Some(Command::Man(arguments)) => arguments.execute(),
        }
    }
}

/// Runs the command that the process's arguments name.
pub fn main() -> ExitCode {
    completions::answer();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return misread(&error),
    };
    let screen = Screen::new(cli.quiet);
    start_log(&screen);
    let status = match cli.execute(&screen) {
        Ok(outcome) => outcome.exit_status(),
        Err(failure) => told(&failure, &screen),
    };
    ExitCode::from(status)
}

/// Tells of a failure, also as JSON if the caller asked for it; returns the exit status.
fn told(failure: &Failure, screen: &Screen) -> u8 {
    if asks_for_json() {
        // A program that reads no document reads the status; a person reads the message.
        let _ = say_json(&failure.document());
    }
    screen.note(&failure.rendered(screen.fancy()));
    failure.annotation().show(screen);
    failure.exit_status()
}

/// Whether a program reads the standard output, as far as the arguments can be read.
fn asks_for_json() -> bool {
    std::env::args_os().any(|argument| argument == "--json")
}

/// The arguments are invalid or ask for help: reports to the user, and as JSON if the caller asked for it.
fn misread(error: &clap::Error) -> ExitCode {
    #[cfg(not(feature = "nats"))]
    if asks_for_nats(error) {
        return without_nats();
    }
    let status = u8::try_from(error.exit_code()).unwrap_or(EXIT_BAD_INPUT);
    if error.use_stderr() && asks_for_json() {
        let text = error.render().to_string();
        let (what, help) = text.split_once("\n\n").unwrap_or((&text, ""));
        let what = what.trim().trim_start_matches("error: ");
        let _ = say_json(&json!({ "error": what, "causes": [], "help": help.trim() }));
    }
    // If the message cannot be printed, only the status is left.
    let _ = error.print();
    ExitCode::from(status)
}

/// Whether it is about what only a build for campaigns over a server has. `clap` would propose another word.
#[cfg(not(feature = "nats"))]
fn asks_for_nats(error: &clap::Error) -> bool {
    use clap::error::{ContextKind, ContextValue};
    let is = |kind, word: &str| match error.get(kind) {
        Some(ContextValue::String(found)) => found == word,
        _ => false,
    };
    is(ContextKind::InvalidSubcommand, "worker") || is(ContextKind::InvalidArg, "--nats")
}

#[cfg(not(feature = "nats"))]
fn without_nats() -> ExitCode {
    let failure = Failure::arguments(
        "this build of hil cannot run campaigns over a NATS server: it lacks the feature `nats`",
        "build it with `cargo build --release -p hil --features nats`",
    );
    ExitCode::from(told(&failure, &Screen::new(false)))
}

/// Writes a document to the standard output, indented, with a final line feed.
fn say_json(document: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(document);
    say(&(text.map_err(|error| Failure::output(error.into()))? + "\n"))
}

/// Warnings. What a controller in this process notices is in its reports, and a campaign has a hundred thousand of them.
const WARNINGS: &str = "warn,controller=error";

/// Writes diagnostics to the standard error: warnings, or as `RUST_LOG` selects.
fn start_log(screen: &Screen) {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(WARNINGS));
    let log = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_ansi(screen.fancy())
        .with_writer(screen.clone())
        .without_time()
        .with_target(false);
    if log.try_init().is_err() {
        screen.note("another log is in use already");
    }
}

fn say(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(tame::tamed(text).as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::output(error)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::Cli;
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent() {
        Cli::command().debug_assert();
    }

    /// Includes every command.
    #[test]
    #[cfg(feature = "nats")]
    fn the_help_of_every_command() {
        let mut hil = Cli::command().term_width(100);
        hil.build();
        let mut help = hil.render_long_help().to_string();
        let names = [
            "run",
            "campaign",
            "worker",
            "check",
            "report",
            "show",
            "diff",
            "rerun",
            "debug",
            "replay",
            "list",
            "doctor",
            "draw",
            "emulate",
            "export",
            "import",
            "log",
            "identify",
            "predict",
            "new",
            "schema",
            "completions",
            "man",
        ];
        for name in names {
            let command = hil.find_subcommand_mut(name).expect(name);
            help += &format!("\n======== {name}\n{}", command.render_long_help());
            for device in command.get_subcommands_mut().filter(|it| it.get_name() != "help") {
                let title = format!("{name} {}", device.get_name());
                help += &format!("\n======== {title}\n{}", device.render_long_help());
            }
        }
        insta::assert_snapshot!(help);
    }
}
