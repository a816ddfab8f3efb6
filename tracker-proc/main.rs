//! The `tracker-proc` process.

fn main() -> std::process::ExitCode {
    tracker_proc::cli::main()
}
