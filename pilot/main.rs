//! The `pilot` process.

fn main() -> std::process::ExitCode {
    pilot::cli::main(volume_loader::load_seeded)
}
