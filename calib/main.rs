//! The `calib` program.

fn main() -> std::process::ExitCode {
    calib_cli::cli::main()
}
