//! `remote-proc`: see [`remote_proc`].

fn main() -> std::process::ExitCode {
    one_thread_for_the_link();
    remote_proc::cli::main()
}

/// zenoh reads and writes a TLS connection from two tasks at a time, which no TLS library allows: memory was overwritten where both ran at
/// once (<https://github.com/eclipse-zenoh/zenoh/issues/2557>, open in 1.10.2; here two of eight transfers of 210 MB ended in an
/// absurd allocation). So all its tasks are given to one thread, where none runs beside another. It takes that from the environment alone.
fn one_thread_for_the_link() {
    #[allow(unsafe_code, reason = "setting a variable of the environment")]
    // SAFETY: no other thread exists yet that could read the environment meanwhile.
    unsafe {
        std::env::set_var("ZENOH_RUNTIME", remote_proc::session::ONE_THREAD);
    }
}
