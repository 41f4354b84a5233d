//! `hil`: runs test plans on a bench, simulated or real. See `hil --help` and [`hil::cli`].

fn main() -> std::process::ExitCode {
    hil::cli::main()
}
