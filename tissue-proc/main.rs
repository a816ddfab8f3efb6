//! The `tissue-proc` process.

fn main() -> std::process::ExitCode {
    tissue_proc::cli::main(volume_loader::load_labels_seeded)
}
