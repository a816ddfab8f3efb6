//! The `window` process.

fn main() -> std::process::ExitCode {
    window::cli::main(window::cli::LabelReader {
        map: volume_loader::load_labels,
        names: |path| Ok(volume_loader::label_names(path)?),
    })
}
