//! All operations of a study, by several threads, in order.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc;

use bus::clock::{monotonic_ns, ms};

use crate::folder::{self, Folder, FolderError};
use crate::images::Images;
use crate::operation::operate;
use crate::plan::Plan;
use crate::record::Row;

/// Between two words of progress, s.
const TELL_S: f64 = 5.0;
/// Between two pages on the way, s.
const PAGE_S: f64 = 30.0;

/// Why a study did not come to its end.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// Its folder.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A folder for the files of one operation could not be made.
    #[error("a folder for the files of an operation: {0}")]
    Scratch(std::io::Error),
    /// The machine failed in the middle of an operation.
    #[error("operation {number} of {stratum}, {step}: {why}. The folder can be gone on with")]
    Machine {
        /// Which stratum.
        stratum: String,
        /// Which operation of it.
        number: u64,
        /// At which step.
        step: &'static str,
        /// What the system says.
        why: String,
    },
    /// A thread ended before its time.
    #[error("a thread ended before all operations were done; the folder can be gone on with")]
    Thread,
}

/// What a study came to.
#[derive(Debug)]
pub struct Done {
    /// All lines, in the order of the file.
    pub rows: Vec<Row>,
    /// Operations that were done now, and those that were there already.
    pub operations: [u64; 2],
    /// How long those of now took, s of a clock on the wall.
    pub took_s: f64,
}

/// Does what of the study is not done yet, with so many threads (at least one); lines go to `operations.csv` in `out` as soon
/// as all before them are there. The bytes do not depend on the number of threads, nor on where an earlier run was killed.
///
/// # Errors
/// [`RunError`]; what was written stays, and is gone on with.
pub fn run(plan: &Plan, out: &Path, threads: usize) -> Result<Done, RunError> {
    run_telling(plan, (out, threads), &mut |_| {})
}

/// The same; half a minute after the last time it gives all lines that there are by now to `page`.
///
/// # Errors
/// Those of [`run`].
pub fn run_telling(
    plan: &Plan,
    (out, threads): (&Path, usize),
    page: &mut dyn FnMut(&[Row]),
) -> Result<Done, RunError> {
    let mut folder = Folder::open(out, plan)?;
    let (before, total) = (folder.done, plan.operations());
    let images = Images::new(folder.file(folder::IMAGES))?;
    let next = AtomicU64::new(before);
    let began = monotonic_ns();
    std::thread::scope(|scope| {
        let (send, received) = mpsc::channel::<(u64, Result<Vec<Row>, RunError>)>();
        for _ in 0..threads.max(1) {
            let (send, next, images) = (send.clone(), &next, &images);
            scope.spawn(move || {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some((stratum, number)) = plan.operation(at) else {
                        break;
                    };
                    let scratch = tempfile::Builder::new().prefix("trocar-study-").tempdir();
                    let rows = scratch.map_err(RunError::Scratch).and_then(|scratch| {
                        let rows = operate(stratum, number, images, scratch.path());
                        rows.map_err(|refused| RunError::Machine {
                            stratum: stratum.name.clone(),
                            number,
                            step: refused.step.word(),
                            why: refused.why,
                        })
                    });
                    if send.send((at, rows)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let result = gathered(&mut folder, &received, (before, total, began), page);
        // Who is not received any more stops after what it is at.
        next.store(total, Ordering::Relaxed);
        result
    })?;
    if folder.done < total {
        return Err(RunError::Thread);
    }
    Ok(Done {
        operations: [folder.done - before, before],
        rows: std::mem::take(&mut folder.rows),
        took_s: seconds_since(began),
    })
}

/// Writes what comes, in order.
fn gathered(
    folder: &mut Folder,
    received: &mpsc::Receiver<(u64, Result<Vec<Row>, RunError>)>,
    (before, total, began): (u64, u64, i64),
    page: &mut dyn FnMut(&[Row]),
) -> Result<(), RunError> {
    let mut waiting = BTreeMap::new();
    let (mut told_s, mut paged_s) = (0.0, 0.0);
    for (at, rows) in received {
        waiting.insert(at, rows?);
        while let Some(rows) = waiting.remove(&folder.done) {
            folder.append(rows)?;
        }
        let passed_s = seconds_since(began);
        if passed_s - told_s > TELL_S || folder.done == total {
            told_s = passed_s;
            tell(folder.done, before, total, passed_s);
        }
        if passed_s - paged_s > PAGE_S && folder.done < total {
            page(&folder.rows);
            // From its end on: a page of many lines does not follow at once on another.
            paged_s = seconds_since(began);
        }
    }
    Ok(())
}

fn seconds_since(began: i64) -> f64 {
    ms(monotonic_ns() - began) / 1e3
}

fn tell(done: u64, before: u64, total: u64, passed_s: f64) {
    let here = done.saturating_sub(before).max(1) as f64;
    let left_s = passed_s / here * (total - done) as f64;
    bus::stderr_line!("study: {done} of {total} operations; {passed_s:.0} s, about {left_s:.0} s to go");
}
