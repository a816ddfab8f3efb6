//! The `pilot` process.

fn main() -> std::process::ExitCode {
    pilot::cli::main(pilot::cli::Hands {
        load: volume_loader::load_seeded,
        load_labels: volume_loader::load_labels,
        label_names: |path| Ok(volume_loader::label_names(path)?),
    })
}
