//! Work of seconds on a thread of its own, while the one that waits for it gives signs of life.

use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// Works, and calls `beat` every so often until that is done.
///
/// # Errors
/// What `beat` gives, once the work is done.
pub(crate) fn beside<T: Send, E>(
    every: Duration,
    work: impl FnOnce() -> T + Send,
    mut beat: impl FnMut() -> Result<(), E>,
) -> Result<T, E> {
    thread::scope(|scope| {
        let (done, made) = mpsc::sync_channel(1);
        let working = scope.spawn(move || done.send(work()));
        loop {
            match made.recv_timeout(every) {
                Ok(made) => return Ok(made),
                Err(RecvTimeoutError::Timeout) => beat()?,
                // It ended without a word: by a panic, which goes on here.
                Err(RecvTimeoutError::Disconnected) => match working.join() {
                    Err(panic) => std::panic::resume_unwind(panic),
                    Ok(_) => unreachable!("what works sends before it ends"),
                },
            }
        }
    })
}
