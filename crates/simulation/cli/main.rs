//! The `simulate` program.

fn main() -> std::process::ExitCode {
    simulation_cli::cli::main(|path| volume_loader::load_label_map(path))
}
