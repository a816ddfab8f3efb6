//! `remote-proc`: see [`remote_proc`].

fn main() -> std::process::ExitCode {
    remote_proc::cli::main()
}
