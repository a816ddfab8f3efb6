//! The `study` program.

fn main() -> std::process::ExitCode {
    study::cli::main()
}
