//! When poses arrive on a bus, seen by a thread that is woken by them.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::ToolPose;
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::session::Session;
use bus::topic::TOOL_POSE;
use bus::wake::Waits;

/// A pose that arrived.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Heard {
    /// When, on CLOCK_MONOTONIC.
    pub(crate) at_ns: i64,
    /// By how much the session's clock is ahead of the truth then.
    pub(crate) ahead_ns: i64,
}

/// Listens until it is asked what it heard.
pub(crate) struct Listener {
    stop: Arc<AtomicBool>,
    heard: Receiver<HashMap<u64, Heard>>,
}

impl Listener {
    /// On the bus of `run`. `epoch_ns` is that of the clock that its session's should show.
    pub(crate) fn on(run: &RunContext, epoch_ns: Option<i64>) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let (sender, heard) = channel();
        let (run, asked) = (run.clone(), stop.clone());
        std::thread::spawn(move || {
            let _ = sender.send(listen(&run, epoch_ns, &asked));
        });
        Self { stop, heard }
    }

    /// All that it heard, by number.
    pub(crate) fn heard(self) -> HashMap<u64, Heard> {
        self.stop.store(true, Ordering::Relaxed);
        self.heard.recv().unwrap()
    }
}

fn listen(run: &RunContext, epoch_ns: Option<i64>, stop: &AtomicBool) -> HashMap<u64, Heard> {
    let bus = Bus::join(run).unwrap();
    let poses = Subscriber::<ToolPose>::open_waking(&bus, &TOOL_POSE, "", TOOL_POSE.buffer).unwrap();
    let mut session = Session::open(&bus, run).unwrap();
    let mut heard = HashMap::new();
    let waits = Waits::every(Duration::from_millis(50)).message(&poses, None);
    waits
        .run(|| {
            session.follow().unwrap();
            while let Some(pose) = poses.next().unwrap() {
                let at_ns = monotonic_ns();
                let truth = epoch_ns.map(|epoch_ns| monotonic_ns() - epoch_ns);
                let ahead_ns = truth.map_or(0, |truth| session.clock().now_ns() - truth);
                heard.entry(pose.seq).or_insert(Heard { at_ns, ahead_ns });
            }
            match stop.load(Ordering::Relaxed) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        })
        .unwrap();
    heard
}
