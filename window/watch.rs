//! The `window-watch` process.

fn main() -> std::process::ExitCode {
    window::watch::cli::main()
}
