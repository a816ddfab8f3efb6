//! The `calib` program.

fn main() -> std::process::ExitCode {
    calib_cli::cli::main(volume_loader::load)
}
