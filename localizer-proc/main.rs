//! The `localizer-proc` process.

fn main() -> std::process::ExitCode {
    localizer_proc::cli::main()
}
