//! The pilot's death: who dies with it, and who is left a moment to tell others.

use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use rustix::process::{Pid, Signal, getpid, getppid, kill_process, set_parent_process_death_signal};

use super::{JoinError, Membership, StopFlag};

/// Between two looks at whether the pilot is there.
const LOOK: Duration = Duration::from_millis(100);

/// Asks the kernel to send this process `signal` when the pilot dies, in whatever way.
pub(super) fn die_with(parent: u32, signal: Signal) -> Result<(), JoinError> {
    set_parent_process_death_signal(Some(signal)).map_err(|e| JoinError::Signals(e.into()))?;
    // The pilot may have died before the line above.
    match is_parent(parent) {
        true => Ok(()),
        false => Err(JoinError::Orphan(parent)),
    }
}

/// For a process with something to say to others once the pilot has died: from here on that asks it to stop, as SIGTERM does, and it is
/// killed `within` so long after, whatever it does. To be called by the main thread, which has joined.
///
/// # Errors
/// [`JoinError::Orphan`], [`JoinError::Signals`].
pub fn take_leave(membership: &Membership, stop: &StopFlag, within: Duration) -> Result<(), JoinError> {
    let Some(parent) = membership.parent else {
        return Ok(());
    };
    die_with(parent, Signal::TERM)?;
    let stop = stop.clone();
    let watch = move || {
        while is_parent(parent) {
            thread::sleep(LOOK);
        }
        stop.0.store(true, Ordering::Relaxed);
        thread::sleep(within);
        // Nobody is left who would.
        let _ = kill_process(getpid(), Signal::KILL);
    };
    let thread = thread::Builder::new().name("leave".to_owned());
    thread.spawn(watch).map(drop).map_err(JoinError::Signals)
}

fn is_parent(parent: u32) -> bool {
    getppid().map(Pid::as_raw_nonzero).map(|pid| pid.get()) == i32::try_from(parent).ok()
}
