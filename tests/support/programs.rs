//! The command lines of all programs.

/// Each program's, by the name that it is started by.
pub(crate) fn all() -> Vec<clap::Command> {
    vec![
        pilot::cli::command(),
        volume_loader::cli::command(),
        tracker_proc::cli::command(),
        localizer_proc::cli::command(),
        slice_view_proc::cli::command(),
        recorder::cli::command(),
        gateway_proc::cli::command(),
        tissue_proc::cli::command(),
        window::cli::command(),
        window::watch::cli::command(),
        calib_cli::cli::command(),
        simulation_cli::cli::command(),
        study::cli::command(),
    ]
}
