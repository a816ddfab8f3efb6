//! A command on a thread of its own, so that the process goes on giving signs of life.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use super::course::Said;
use crate::live::{Heard, Watch};

/// Does what a command line of `calib` asks, the first word of which is its name; whoever watches is told while it listens.
pub(crate) type CarryOut = Arc<dyn Fn(&[String], &Watch) -> Said + Send + Sync>;

/// A command that is being carried out.
pub(super) struct Job {
    thread: Option<JoinHandle<Said>>,
    heard: Arc<Mutex<Option<Heard>>>,
    stop: Arc<AtomicBool>,
}

impl Job {
    /// Starts the command with these words.
    ///
    /// # Errors
    /// In words: that there is no thread for it.
    pub(super) fn start(words: Vec<String>, carry_out: &CarryOut) -> Result<Self, String> {
        let (heard, stop) = (Arc::new(Mutex::new(None)), Arc::new(AtomicBool::new(false)));
        let (into, stopped) = (heard.clone(), stop.clone());
        let watch = Watch::new(move |now: &Heard| {
            *into.lock().unwrap_or_else(PoisonError::into_inner) = Some(now.clone());
            match stopped.load(Ordering::Relaxed) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
        let carry_out = carry_out.clone();
        let thread = std::thread::Builder::new()
            .name("command".to_owned())
            .spawn(move || carry_out(&words, &watch));
        let thread = thread.map_err(|error| format!("no thread for a command: {error}"))?;
        Ok(Self {
            thread: Some(thread),
            heard,
            stop,
        })
    }

    /// What the command said, where it has ended.
    pub(super) fn poll(&mut self) -> Option<Said> {
        let thread = self.thread.take_if(|thread| thread.is_finished())?;
        let ended = |_| Err("the command broke down; nothing was written".to_owned());
        Some(thread.join().unwrap_or_else(ended))
    }

    /// What was heard so far.
    pub(super) fn heard(&self) -> Option<Heard> {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Ends it as soon as it looks up; what it says then is that it was given up.
    pub(super) fn cancel(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}
