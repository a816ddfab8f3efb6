//! The `slice-view-proc` process.

fn main() -> std::process::ExitCode {
    slice_view_proc::cli::main(volume_loader::load, volume_loader::load_labels)
}
