//! The `recorder` process.

fn main() -> std::process::ExitCode {
    recorder::cli::main()
}
