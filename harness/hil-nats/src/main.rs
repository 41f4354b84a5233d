//! `hil` with campaigns over a NATS server. Under its own name it does not take the place of the `hil` that other tests
//! are running.

fn main() -> std::process::ExitCode {
    hil::cli::main()
}
