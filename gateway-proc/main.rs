//! The `gateway-proc` process.

fn main() -> std::process::ExitCode {
    gateway_proc::cli::main()
}
