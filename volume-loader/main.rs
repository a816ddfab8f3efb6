//! The `volume-loader` process.

fn main() -> std::process::ExitCode {
    volume_loader::cli::main()
}
