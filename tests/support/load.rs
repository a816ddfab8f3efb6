//! Busy loops beside a run, for benchmarks of a machine that has other work.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Busy loops, as long as it lives.
pub(crate) struct Load(Arc<AtomicBool>);

impl Load {
    pub(crate) fn new(count: usize) -> Self {
        let ended = Arc::new(AtomicBool::new(false));
        for _ in 0..count {
            let ended = Arc::clone(&ended);
            std::thread::spawn(move || {
                while !ended.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        Self(ended)
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// The words of the command line, the first of them as a number, and the number after `load`.
pub(crate) fn asked() -> (Vec<String>, Option<f64>, Option<usize>) {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let load = words.iter().position(|w| w == "load").and_then(|i| words.get(i + 1));
    let load = load.map(|n| n.parse().unwrap());
    let first = words.first().and_then(|n| n.parse().ok());
    (words, first, load)
}
