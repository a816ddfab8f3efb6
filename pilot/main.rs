//! The `pilot` process.

fn main() -> std::process::ExitCode {
    pilot::cli::main(pilot::cli::Hands {
        load: volume_loader::load_seeded,
        load_labels: volume_loader::load_labels,
    })
}
