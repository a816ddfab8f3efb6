//! The `simulate` program.

fn main() -> std::process::ExitCode {
    simulation_cli::cli::main(volume_loader::load_label_map)
}
