//! Work shared among threads.

use std::sync::{Mutex, PoisonError};

/// Does all jobs on so many threads, this one among them: whichever is free takes the next.
pub(super) fn share<J: Send>(jobs: Vec<J>, threads: usize, work: impl Fn(J) + Sync) {
    let others = threads.min(jobs.len()).saturating_sub(1);
    let queue = Mutex::new(jobs.into_iter());
    let all = || {
        let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
        while let Some(job) = next() {
            work(job);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..others {
            scope.spawn(all);
        }
        all();
    });
}
