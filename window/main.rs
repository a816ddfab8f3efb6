//! The `window` process.

fn main() -> std::process::ExitCode {
    window::cli::main(volume_loader::load_labels)
}
