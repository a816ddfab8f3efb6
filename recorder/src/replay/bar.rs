//! Reads the recording beside the replay, for the bar that it is steered by.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use bus::message::Timeline;

use crate::report::basis::Limits;
use crate::report::timeline::follow;

/// The reader leaves the processor to whoever shows images.
const NICE: i32 = 19;

/// What the reader and the replayer share.
#[derive(Debug, Default)]
struct Shared {
    newest: Mutex<Option<Box<Timeline>>>,
    stop: AtomicBool,
}

/// A thread that reads the recording once.
#[derive(Debug)]
pub(super) struct Bar {
    shared: Arc<Shared>,
    reader: Option<JoinHandle<()>>,
}

impl Bar {
    /// Begins to read `recording`, whose samples are judged by `limits`, as the images are.
    pub(super) fn begin(recording: &Path, limits: Limits) -> Self {
        let shared = Arc::<Shared>::default();
        let (of, path) = (Arc::clone(&shared), recording.to_owned());
        let spawned = std::thread::Builder::new()
            .name("timeline".to_owned())
            .spawn(move || read(&path, limits, &of));
        if let Err(error) = &spawned {
            shared.put(Timeline::default().because(&format!("no thread to read the recording: {error}")));
        }
        Self {
            shared,
            reader: spawned.ok(),
        }
    }

    /// What is known since this was asked last.
    pub(super) fn news(&self) -> Option<Box<Timeline>> {
        self.shared.newest.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(reader) = self.reader.take() {
            // What it could not read is said in its last word.
            drop(reader.join());
        }
    }
}

impl Shared {
    fn put(&self, timeline: Timeline) {
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        *newest = Some(Box::new(timeline));
    }
}

fn read(path: &Path, limits: Limits, shared: &Shared) {
    // Of this thread alone. Where the system refuses it, the reading only takes the more of the processor.
    let _ = rustix::process::setpriority_process(None, NICE);
    let mut newest = Timeline::default();
    let followed = follow(path, Some(limits), &mut |timeline| {
        newest = timeline;
        shared.put(timeline);
        match shared.stop.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    });
    if let Err(error) = followed {
        shared.put(newest.because(&error.to_string()));
    }
}
