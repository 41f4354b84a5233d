//! `hil`: runs test plans on a bench, simulated or real. See `hil --help` and [`harness::cli`].

fn main() -> std::process::ExitCode {
    harness::cli::main()
}
